"""Questions with choices of their own, as those about a person: each answer is the code of a category.

A file in `tactometry/questionnaires/choices/` is such a form, or a table `[forms.NAME]` of a study with
``kind = "choices"``. Everybody may say that they prefer not to say: that is `NOT_SAID`, and no form states it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

from .arguments.require import expect, first_repeat, one_of, some
from .config.strict import build
from .config.toml import errors_in, load_shipped, shipped_in, table_of
from .errors import InvalidParameter

KIND: Final = "choices"
NOT_SAID: Final = 0
"""The code of an answer that someone prefers not to give."""
PREFER_NOT: Final = "prefer_not"
"""The label of that answer."""
MOST_CODE: Final = 9
"""Each option has a digit of its own. Years of birth or of age, which could tell who someone is, have not enough."""
MOST_NUMBER: Final = 999_999_999
"""A page takes nine digits, and no sign."""
SAY: Final = "say_number"
"""The label of the wish to answer by a number."""
FOLDER: Final = "tactometry.questionnaires.choices"


@dataclass(frozen=True)
class Option:
    """A category: the `code` that the table holds, from 1 to 9, and its words by language.

    - `code`: What the table holds, from 1 to 9.
    - `words`: What participants read, by language.
    """

    code: int
    words: dict[str, str]


@dataclass(frozen=True)
class ChoiceItem:
    """One question: what the tables call it, its words by language, and its options in their order; or in their place
    the bounds `low` and `high` of a number, which could tell who somebody is.

    - `id`: What the tables call it.
    - `prompt`: The question, by language.
    - `options`: Two to nine, in their order.
    - `low`: Lowest number of an answer, in place of options.
    - `high`: Highest number of an answer, in place of options.
    """

    id: str
    prompt: dict[str, str]
    options: tuple[Option, ...] = ()
    low: float | None = None
    high: float | None = None

    @property
    def bounds(self) -> tuple[float, float] | None:
        """Bounds of a number; None if it has options."""
        return None if self.low is None or self.high is None else (self.low, self.high)

    @property
    def codes(self) -> tuple[int, ...]:
        """Codes of all answers, `NOT_SAID` last."""
        return (*(option.code for option in self.options), NOT_SAID)

    @property
    def languages(self) -> set[str]:
        return set.intersection(set(self.prompt), *(set(option.words) for option in self.options))

    def category(self, code: int, language: str = "en") -> str:
        """Return what a code stands for; empty for `NOT_SAID` and unknown codes.

        >>> load("demographics").items[1].category(1)
        'right'
        """
        words = {option.code: option.words for option in self.options}.get(code, {})
        return words.get(language, next(iter(words.values()), ""))


@dataclass(frozen=True)
class ChoiceForm:
    """Questions that are asked one page each, about a person.

    Raises `InvalidParameter` if a question has no options, an id or a code stands twice, or no language has all words.

    - `name`: What studies and tables call it.
    - `title`: What reports call it.
    - `reference`: Where it was published, or that the words are one's own.
    - `kind`: ``choices``.
    - `items`: The questions, in their order.

    >>> demographics = load("demographics")
    >>> [item.id for item in demographics.items], demographics.languages
    (['age_band', 'handedness', 'gender'], ('de', 'en', 'fr'))
    """

    name: str
    title: str
    reference: str
    kind: str
    items: tuple[ChoiceItem, ...]

    def __post_init__(self) -> None:
        one_of("kind", self.kind, (KIND,))
        some("items", self.items)
        again = first_repeat([item.id for item in self.items])
        if again is not None:
            raise InvalidParameter(f"items[{again}].id: found {self.items[again].id!r} twice, expected each id once")
        for n, item in enumerate(self.items):
            _check_item(item, f"items[{n}]")
        expect(len(self.languages) > 0, "items", "no language that has words for all of them", "at least one")

    @property
    def languages(self) -> tuple[str, ...]:
        return tuple(sorted(set.intersection(*(item.languages for item in self.items))))

    @property
    def numbers(self) -> tuple[str, ...]:
        """Questions that are answered by a number, which might identify a person."""
        return tuple(item.id for item in self.items if item.bounds is not None)

    def item(self, name: str) -> ChoiceItem | None:
        return next((item for item in self.items if item.id == name), None)


def _check_item(item: ChoiceItem, path: str) -> None:
    expect(bool(item.id.strip()), f"{path}.id", repr(item.id), "a name, which stands in the tables")
    if item.low is None and item.high is None:
        expect(len(item.options) >= 2, f"{path}.options", len(item.options), "at least 2, beside the one not to say")
    else:
        low, high = item.bounds or (0.0, 0.0)
        can_be_typed = 0 <= low < high <= MOST_NUMBER and not item.options
        below = f"a number from 0 on, below high, and high at most {MOST_NUMBER}; without options"
        expect(can_be_typed, f"{path}.low", f"{item.low} with high {item.high}", below)
    codes = [option.code for option in item.options]
    for n, code in enumerate(codes):
        fits = f"a whole number from 1 to {MOST_CODE}, each once; {NOT_SAID} is 'prefer not to say'"
        expect(1 <= code <= MOST_CODE and codes.index(code) == n, f"{path}.options[{n}].code", code, fits)
    texts = {f"{path}.prompt": item.prompt}
    texts |= {f"{path}.options[{n}].words": option.words for n, option in enumerate(item.options)}
    for where, by_language in texts.items():
        for language, text in by_language.items():
            expect(bool(text.strip()), f"{where}.{language}", "a text that says nothing", "what participants read")


def is_choices(table: object) -> bool:
    return isinstance(table, Mapping) and table.get("kind") == KIND


def choice_form_of(table: Mapping[str, Any], path: str) -> ChoiceForm:
    """Build a form from the table of a file; `path` opens each key path.

    Raises `InvalidParameter` if a key is wrong or the form is impossible.
    """
    return build(ChoiceForm, table, path)


def choice_forms_of(tables: Mapping[str, Mapping[str, Any]]) -> dict[str, ChoiceForm]:
    """Return the forms of a study by name, from its `[forms.NAME]`."""
    own = {name: table for name, table in tables.items() if is_choices(table)}
    return {name: choice_form_of({"name": name, **table}, f"forms.{name}") for name, table in own.items()}


@cache
def shipped_choices() -> tuple[str, ...]:
    """Return the names of the shipped forms.

    >>> shipped_choices()
    ('demographics',)
    """
    return shipped_in(FOLDER)


@cache
def load(name: str) -> ChoiceForm:
    """Load a shipped form."""
    return load_shipped(FOLDER, name, "form", _parse)


def _parse(content: bytes, where: str) -> ChoiceForm:
    table = table_of(content, where, "a form")
    with errors_in(where):
        return choice_form_of(table, "")
