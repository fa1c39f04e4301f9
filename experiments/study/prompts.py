"""Custom prompts above task questions and questionnaires."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

from tactometry.arguments.require import expect
from tactometry.questionnaire import Questionnaire

Prompt = str | dict[str, str]
"""Text for every language, or texts by two-letter language code."""
ASKED_BY = {"magnitude": ("how_strong",), "adjustment": ("adjust",), "measurement": ("vibrometer_nm",)}
"""Messages of tasks that ask for no choice."""


@dataclass(frozen=True)
class PromptTable:
    """Key `prompt` of the table `task`.

    - `prompt`: Question that replaces the built-in one: one text, or a text for each language.
    """

    prompt: Prompt = ""

    def __post_init__(self) -> None:
        check_prompt(self.prompt, "PromptTable.prompt")


def check_prompt(prompt: Prompt, where: str) -> None:
    """Raise `InvalidParameter` for a prompt with an empty text."""
    texts = prompt.values() if isinstance(prompt, dict) else [prompt or "?"]
    says_something = all(text.strip() for text in texts)
    expect(says_something, where, "an empty text", "the question for participants; or remove the key")


def by_language(prompt: Prompt) -> dict[str, str]:
    """Return a prompt by language. A single text counts as English.

    >>> by_language("Rough?"), by_language({"fr": "Rugueux ?"}), by_language("")
    ({'en': 'Rough?'}, {'fr': 'Rugueux ?'}, {})
    """
    return prompt if isinstance(prompt, dict) else {"en": prompt} if prompt else {}


def prompted(form: Questionnaire, prompt: Prompt) -> Questionnaire:
    """Return a questionnaire with the study's prompt as its stem."""
    return replace(form, stem=by_language(prompt)) if prompt else form


def messages_of(kind: str, questions: Iterable[str]) -> tuple[str, ...]:
    """Return the messages that present a task's questions.

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
