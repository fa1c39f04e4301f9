"""Forms for participants: questionnaires on scales, and choice questions.

A file in `tactometry/questionnaires/` is a questionnaire. `parse` reads a questionnaire file from anywhere. The raw
answer increases from the left to the right label. A *reversed* item has its positive pole on the left, so that a high
raw answer is a low score.

A file in `tactometry/questionnaires/choices/` is a form of choices, whose answers are codes of categories.
Participants may always prefer not to say (`NOT_SAID`). Forms do not list that option.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from typing import Annotated, Any, Final, Self, TypeVar

from annotated_types import Ge

from .arguments.constraints import constrained
from .arguments.require import expect, first_repeat, lookup, one_of, some
from .config.strict import build
from .config.toml import errors_in, load_shipped, shipped_in, table_of
from .errors import InvalidParameter

FOLDER: Final = "tactometry.questionnaires"
KIND: Final = "choices"
NOT_SAID: Final = 0
"""Code of "prefer not to say"."""
PREFER_NOT: Final = "prefer_not"
SAY: Final = "say_number"
"""Labels of that answer, and of the option to enter a number."""
MOST_CODE: Final = 9
"""Largest code, so that each option has one digit. Years of birth or age, which could identify a person, have more
digits."""
MOST_NUMBER: Final = 999_999_999
"""Largest number that a page accepts: nine digits without a sign."""


@dataclass(frozen=True)
class Item:
    """Question of a questionnaire.

    - `id`: Name of the item in tables.
    - `dimension`: Dimension to whose score the item contributes.
    - `reversed`: True if the positive pole is presented on the left.
    - `order`: Position in the published order, from 1.
    - `poles`: The two end labels, by language. Empty if the questionnaire has the same `ends` for every item.
    - `statement`: Statement to rate, by language. Empty for a semantic differential.
    """

    id: str
    dimension: str
    order: int
    reversed: bool = False
    poles: dict[str, tuple[str, ...]] = field(default_factory=dict)
    statement: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
@constrained
class Dimension:
    """Score that is the mean of its items, or of the items of its parts.

    - `min_answered`: Number of answers required to compute the score.
    - `title`: Name of the dimension in reports, by language.
    - `parts`: Dimensions whose items it combines. Without them, it has separate items.
    """

    min_answered: Annotated[int, Ge(1)]
    title: dict[str, str] = field(default_factory=dict)
    parts: tuple[str, ...] = ()


@dataclass(frozen=True)
class Questionnaire:
    """Items on one scale, in the published order.

    - `low`: Raw answer at the left end.
    - `high`: Raw answer at the right end.
    - `steps`: Number of evenly spaced raw answers, or None for a continuous line.
    - `score_low`: Score of the worst answer, which is `low` unless the item is reversed.
    - `score_high`: Score of the best answer, which is `high` unless the item is reversed.
    - `ends`: Labels at the ends of every item, as presented, by language. Empty if each item has separate poles.
    - `reference`: Publication, with a note on unverified translations and choices.
    - `stem`: Introduction above every page, by language.
    - `name`: Name in studies and tables.
    - `title`: Name in reports.
    - `items`: Statements or pairs of poles, in any order.
    - `dimensions`: Scores, by name.

    >>> attrakdiff = load("attrakdiff")
    >>> attrakdiff.items[0].id, attrakdiff.words("PQ1", "en"), attrakdiff.score("PQ1", 1)
    ('PQ1', ('', 'Human', 'Technical'), 3.0)
    """

    name: str
    title: str
    low: float
    high: float
    steps: int | None = field(default=None, kw_only=True)
    score_low: float
    score_high: float
    items: tuple[Item, ...]
    dimensions: dict[str, Dimension]
    reference: str
    ends: dict[str, tuple[str, ...]] = field(default_factory=dict)
    stem: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        is_scale = math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high
        expect(is_scale, "low", f"{self.low:g}", f"a number below high ({self.high:g})")
        scored = self.score_low, self.score_high
        are_scores = all(map(math.isfinite, scored)) and self.score_low != self.score_high
        expect(are_scores, "score_low", f"{scored[0]:g} with score_high {scored[1]:g}", "two different finite numbers")
        enough = "at least 2; omit it for a continuous line"
        expect(self.steps is None or self.steps >= 2, "steps", self.steps, enough)
        some("items", self.items)
        for language, ends in self.ends.items():
            _check_pair(ends, f"ends.{language}", "the left and the right end")
        for index, item in enumerate(self.items):
            path = f"items[{index}]"
            one_of(f"{path}.dimension", item.dimension, self.dimensions)
            for language, poles in item.poles.items():
                _check_pair(poles, f"{path}.poles.{language}", "the negative and the positive pole")
            two = "two poles, or ends for all items"
            expect(bool(item.poles or self.ends), f"{path}.poles", f"none for {item.id!r}", two)
        for key in ("id", "order"):
            _check_each_once(self.items, key)
        expect(len(self.languages) > 0, "items", "no language with texts for all items", "at least one")
        for name, dimension in self.dimensions.items():
            for part in dimension.parts:
                is_other = part in self.dimensions and part != name
                expect(is_other, f"dimensions.{name}.parts", repr(part), "the name of another dimension")
            n_items, least = len(self.items_of(name)), dimension.min_answered
            to_all = f"from 1 to the number of its items ({n_items})"
            expect(1 <= least <= n_items, f"dimensions.{name}.min_answered", least, to_all)
        object.__setattr__(self, "items", tuple(sorted(self.items, key=lambda item: item.order)))

    def __deepcopy__(self, memo: dict[int, object]) -> Self:
        """Return itself, because tables that contain it copy it with each operation."""
        return self

    @property
    def languages(self) -> tuple[str, ...]:
        """Languages in which every item can be presented."""
        sides = [set(item.poles or self.ends) for item in self.items]
        statements = [set(item.statement) for item in self.items if item.statement]
        return tuple(sorted(set.intersection(*sides, *statements)))

    def item(self, name: str) -> Item:
        """Return the item with this id."""
        return lookup(f"item of {self.name}", name, {item.id: item for item in self.items})

    def words(self, name: str, language: str) -> tuple[str, str, str]:
        """Return statement, left label and right label of an item.

        Raises `InvalidParameter` if the item or the language does not exist.
        """
        item = self.item(name)
        one_of(f"language of {self.name}", language, self.languages)
        left, right = self.ends[language] if not item.poles else item.poles[language][:: -1 if item.reversed else 1]
        return item.statement.get(language, ""), left, right

    def items_of(self, dimension: str) -> tuple[str, ...]:
        """Return the ids of the items whose mean is the score of a dimension."""
        names = (dimension, *self.dimensions[dimension].parts)
        return tuple(item.id for item in self.items if item.dimension in names)

    def takes(self, raw: float) -> bool:
        """Return True if a number is a raw answer of the scale."""
        if not self.low <= raw <= self.high:
            return False
        place = (raw - self.low) / (self.high - self.low) * ((self.steps or 2) - 1)
        return self.steps is None or math.isclose(place, round(place), abs_tol=1e-9)

    def score(self, name: str, raw: float) -> float:
        """Return the score of a raw answer to an item.

        Raises `InvalidParameter` if the item is unknown, or the answer is not on the scale.
        """
        item = self.item(name)
        scale = f"{self.low:g} to {self.high:g}{'' if self.steps is None else f' in {self.steps} steps'}"
        expect(self.takes(raw), f"{self.name}, item {name}", f"the answer {raw:g}", scale)
        from_worst = self.high - raw if item.reversed else raw - self.low
        return self.score_low + (self.score_high - self.score_low) * from_worst / (self.high - self.low)

    def scores(self, answers: Mapping[str, float | None]) -> dict[str, float | None]:
        """Return the score of each dimension, or None if answers are missing.

        Raises `InvalidParameter` if an item is unknown or an answer is not on the scale.
        """
        scored = {name: self.score(name, raw) for name, raw in answers.items() if raw is not None}
        return {name: self._mean(name, scored) for name in self.dimensions}

    def _mean(self, dimension: str, scored: Mapping[str, float]) -> float | None:
        answered = [scored[name] for name in self.items_of(dimension) if name in scored]
        enough = len(answered) >= self.dimensions[dimension].min_answered
        return math.fsum(answered) / len(answered) if enough else None


def _check_pair(words: Sequence[str], path: str, what: str) -> None:
    are_two = len(words) == 2 and all(word.strip() for word in words)
    expect(are_two, path, list(words), f"two words, {what}")


def _check_each_once(items: Sequence[object], key: str) -> None:
    values = [getattr(item, key) for item in items]
    index = first_repeat(values)
    if index is not None:
        raise InvalidParameter(f"items[{index}].{key}: found {values[index]!r} twice, expected each {key} once")


@dataclass(frozen=True)
class Option:
    """Category that answers a question.

    - `code`: Code in the table, from 1 to 9.
    - `words`: Text shown to participants, by language.
    """

    code: int
    words: dict[str, str]


@dataclass(frozen=True)
class ChoiceItem:
    """Question answered with an option or a number within bounds.

    - `id`: Name in the tables.
    - `prompt`: Text of the question, by language.
    - `options`: Two to nine options, in order.
    - `low`: Lowest accepted number, instead of options.
    - `high`: Highest accepted number, instead of options.
    """

    id: str
    prompt: dict[str, str]
    options: tuple[Option, ...] = ()
    low: float | None = None
    high: float | None = None

    @property
    def bounds(self) -> tuple[float, float] | None:
        """Bounds of a number, or None if the question has options."""
        return None if self.low is None or self.high is None else (self.low, self.high)

    @property
    def codes(self) -> tuple[int, ...]:
        """Codes of all answers, `NOT_SAID` last."""
        return (*(option.code for option in self.options), NOT_SAID)

    @property
    def languages(self) -> set[str]:
        return set.intersection(set(self.prompt), *(set(option.words) for option in self.options))

    def category(self, code: int, language: str = "en") -> str:
        """Return the category of a code, or an empty text.

        >>> load_choices("demographics").items[1].category(1)
        'right'
        """
        words = {option.code: option.words for option in self.options}.get(code, {})
        return words.get(language, next(iter(words.values()), ""))


@dataclass(frozen=True)
class ChoiceForm:
    """Form of questions about the participant, one per page.

    Raises `InvalidParameter` if a question has no options, an id or code occurs twice, or no language is complete.

    - `name`: Name in studies and tables.
    - `title`: Name in reports.
    - `reference`: Publication, or a note that the questions are custom.
    - `kind`: ``choices``.
    - `items`: Questions, in order.

    >>> demographics = load_choices("demographics")
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
        _check_each_once(self.items, "id")
        for n, item in enumerate(self.items):
            _check_item(item, f"items[{n}]")
        expect(len(self.languages) > 0, "items", "no language with texts for all items", "at least one")

    @property
    def languages(self) -> tuple[str, ...]:
        return tuple(sorted(set.intersection(*(item.languages for item in self.items))))

    @property
    def numbers(self) -> tuple[str, ...]:
        """Questions answered with a number, which might identify a person."""
        return tuple(item.id for item in self.items if item.bounds is not None)

    def item(self, name: str) -> ChoiceItem | None:
        return next((item for item in self.items if item.id == name), None)


def _check_item(item: ChoiceItem, path: str) -> None:
    expect(bool(item.id.strip()), f"{path}.id", repr(item.id), "a name for the tables")
    if item.low is None and item.high is None:
        expect(
            len(item.options) >= 2,
            f"{path}.options",
            len(item.options),
            "at least 2, in addition to 'prefer not to say'",
        )
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
            expect(bool(text.strip()), f"{where}.{language}", "an empty text", "the text that participants read")


F = TypeVar("F", Questionnaire, ChoiceForm)


def is_choices(table: object) -> bool:
    return isinstance(table, Mapping) and table.get("kind") == KIND


def form_of(table: Mapping[str, Any], path: str) -> Questionnaire | ChoiceForm:
    """Build the form of a table. `path` begins each key path."""
    return build(ChoiceForm, table, path) if is_choices(table) else build(Questionnaire, table, path)


def questionnaires_of(tables: Mapping[str, Mapping[str, Any]]) -> dict[str, Questionnaire]:
    """Return the questionnaires of a study by name."""
    return _named(Questionnaire, {name: table for name, table in tables.items() if not is_choices(table)})


def choice_forms_of(tables: Mapping[str, Mapping[str, Any]]) -> dict[str, ChoiceForm]:
    """Return the forms of choices in `[forms.NAME]` of a study, by name."""
    return _named(ChoiceForm, {name: table for name, table in tables.items() if is_choices(table)})


def _named(kind: type[F], tables: Mapping[str, Mapping[str, Any]]) -> dict[str, F]:
    return {name: build(kind, {"name": name, **table}, f"forms.{name}") for name, table in tables.items()}


def parse(content: bytes, where: str) -> Questionnaire:
    """Parse the bytes of a questionnaire file. `where` begins error messages."""
    return _parse(Questionnaire, content, where)


def _parse(kind: type[F], content: bytes, where: str) -> F:
    table = table_of(content, where, "a questionnaire")
    with errors_in(where):
        return build(kind, table, "")


@cache
def shipped_names() -> tuple[str, ...]:
    """Return the names of the shipped questionnaires."""
    return shipped_in(FOLDER)


@cache
def shipped_choices() -> tuple[str, ...]:
    """Return the names of the shipped forms of choices."""
    return shipped_in(f"{FOLDER}.choices")


@cache
def load(name: str) -> Questionnaire:
    """Load a shipped questionnaire."""
    return load_shipped(FOLDER, name, "questionnaire", parse)


@cache
def load_choices(name: str) -> ChoiceForm:
    """Load a shipped form of choices."""
    return load_shipped(f"{FOLDER}.choices", name, "form", partial(_parse, ChoiceForm))
