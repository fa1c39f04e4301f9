"""Custom prompts above task questions and questionnaires."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

from tactometry.arguments.require import expect
from tactometry.questionnaire import Questionnaire

Prompt = str | dict[str, str]
"""A text for every language, or one for each, by its two letters."""
ASKED_BY = {"magnitude": ("how_strong",), "adjustment": ("adjust",), "measurement": ("vibrometer_nm",)}
"""The messages of tasks that ask for no choice."""


@dataclass(frozen=True)
class PromptTable:
    """The key `prompt` of the table `task`.

    Parameters
    ----------
    prompt : str or mapping of str to str
        What participants are asked, in place of the shipped question: a text, or one for each language.
    """

    prompt: Prompt = ""

    def __post_init__(self) -> None:
        check_prompt(self.prompt, "PromptTable.prompt")


def check_prompt(prompt: Prompt, where: str) -> None:
    """Refuse a prompt that says nothing in a language.

    Raises
    ------
    InvalidParameter
        If a text is empty.
    """
    texts = prompt.values() if isinstance(prompt, dict) else [prompt or "?"]
    says_something = all(text.strip() for text in texts)
    expect(says_something, where, "a text that says nothing", "what participants are asked; or leave it out")


def by_language(prompt: Prompt) -> dict[str, str]:
    """A prompt by language; that of English is shown where a language has none.

    >>> by_language("Rough?"), by_language({"fr": "Rugueux ?"}), by_language("")
    ({'en': 'Rough?'}, {'fr': 'Rugueux ?'}, {})
    """
    return prompt if isinstance(prompt, dict) else {"en": prompt} if prompt else {}


def prompted(form: Questionnaire, prompt: Prompt) -> Questionnaire:
    """A questionnaire under a stem of the study."""
    return replace(form, stem=by_language(prompt)) if prompt else form


def messages_of(kind: str, questions: Iterable[str]) -> tuple[str, ...]:
    """The messages that a task asks with.

    >>> messages_of("yes_no", ["felt"]), messages_of("magnitude", [])
    (('felt',), ('how_strong',))
    """
    return tuple(questions) or ASKED_BY.get(kind, ())


def texts_of(prompt: Prompt, messages: Iterable[str], language: str) -> dict[str, str]:
    """Return a prompt's text for each message, with its braces escaped.

    >>> texts_of("{Rough}?", ["felt"], "fr")
    {'felt': '{{Rough}}?'}
    """
    words = by_language(prompt)
    text = words.get(language, words.get("en", "")).replace("{", "{{").replace("}", "}}")
    return dict.fromkeys(messages, text) if text else {}
