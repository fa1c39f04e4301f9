"""Questionnaires: items, poles and scoring, read from a file each.

A file in `tactometry/questionnaires/` is a questionnaire; `parse` reads one from anywhere. The raw answer grows from
the left word to the right word. A *reversed* item has its positive pole on the left, so that a high raw answer is a low
score.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Annotated, Any, Final, Self

from annotated_types import Ge

from .arguments.constraints import constrained
from .arguments.require import expect, first_repeat, lookup, one_of, some
from .choice_form import is_choices
from .config.strict import build
from .config.toml import errors_in, load_shipped, shipped_in, table_of
from .errors import InvalidParameter

FOLDER: Final = "tactometry.questionnaires"


@dataclass(frozen=True)
class Item:
    """One question.

    - `id`: Name of the item in tables.
    - `dimension`: Dimension whose score the item belongs to.
    - `reversed`: Whether the positive pole is presented on the left.
    - `order`: Place in the published order, from 1.
    - `poles`: The two words, by language; empty where the questionnaire has the same two `ends` for every item.
    - `statement`: What is rated, by language; empty for a semantic differential, whose poles say all.
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
    """A score: the mean of its items, or of the items of its parts.

    - `min_answered`: Number of answered items that a score needs.
    - `title`: Name of the dimension in reports, by language.
    - `parts`: Dimensions whose items it joins; without them its own items.
    """

    min_answered: Annotated[int, Ge(1)]
    title: dict[str, str] = field(default_factory=dict)
    parts: tuple[str, ...] = ()


@dataclass(frozen=True)
class Questionnaire:
    """Items on one scale, in the published order.

    - `low`: Raw answer at the left end.
    - `high`: Raw answer at the right end.
    - `steps`: How many raw answers there are, evenly spaced; None for a continuous line.
    - `score_low`: Score of the worst answer, which an item that is not reversed has at `low`.
    - `score_high`: Score of the best answer, which an item that is not reversed has at `high`.
    - `ends`: The words at the ends of every item, as presented, by language; empty where each item has its own poles.
    - `reference`: Where it was published; translations and choices that nobody verified are named there.
    - `stem`: What opens every page of it, by language: what the answers are about.
    - `name`: What studies and tables call it.
    - `title`: What reports call it.
    - `items`: The statements or pairs of poles, in any order.
    - `dimensions`: The scores, by name.

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
        _check_scale(self)
        for index, item in enumerate(self.items):
            path = f"items[{index}]"
            one_of(f"{path}.dimension", item.dimension, self.dimensions)
            for language, poles in item.poles.items():
                _check_pair(poles, f"{path}.poles.{language}", "the negative and the positive pole")
            two = "two poles, or ends for all items"
            expect(bool(item.poles or self.ends), f"{path}.poles", f"none for {item.id!r}", two)

        _check_order(self)
        expect(len(self.languages) > 0, "items", "no language that has words for all of them", "at least one")

        for name, dimension in self.dimensions.items():
            for part in dimension.parts:
                is_other = part in self.dimensions and part != name
                expect(is_other, f"dimensions.{name}.parts", repr(part), "the name of another dimension")
            n_items, least = len(self.items_of(name)), dimension.min_answered
            to_all = f"from 1 to the number of its items ({n_items})"
            expect(1 <= least <= n_items, f"dimensions.{name}.min_answered", least, to_all)
        object.__setattr__(self, "items", tuple(sorted(self.items, key=lambda item: item.order)))

    def __deepcopy__(self, memo: dict[int, object]) -> Self:
        """Return itself: a table that names it copies it with each operation."""
        return self

    @property
    def languages(self) -> tuple[str, ...]:
        """Languages in which every item can be presented."""
        sides = [set(item.poles or self.ends) for item in self.items]
        statements = [set(item.statement) for item in self.items if item.statement]
        return tuple(sorted(set.intersection(*sides, *statements)))

    def item(self, name: str) -> Item:
        """Return the item of this id."""
        return lookup(f"item of {self.name}", name, {item.id: item for item in self.items})

    def words(self, name: str, language: str) -> tuple[str, str, str]:
        """Return statement (may be empty), left word and right word of an item, as presented.

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

        Raises `InvalidParameter` if the item is unknown, or the answer not on the scale.
        """
        item = self.item(name)
        scale = f"{self.low:g} to {self.high:g}{'' if self.steps is None else f' in {self.steps} steps'}"
        expect(self.takes(raw), f"{self.name}, item {name}", f"the answer {raw:g}", scale)
        from_worst = self.high - raw if item.reversed else raw - self.low
        return self.score_low + (self.score_high - self.score_low) * from_worst / (self.high - self.low)

    def scores(self, answers: Mapping[str, float | None]) -> dict[str, float | None]:
        """Return the score of each dimension from raw answers by item; None if too few items are answered.

        Raises `InvalidParameter` if an item is unknown or an answer is not on the scale.

        >>> scores = load("attrakdiff").scores({item.id: 7.0 for item in load("attrakdiff").items})
        >>> {name: round(7 * score) for name, score in scores.items()}
        {'PQ': -3, 'HQI': 3, 'HQS': -3, 'ATT': -3, 'HQ': 0}
        """
        scored = {name: self.score(name, raw) for name, raw in answers.items() if raw is not None}
        return {name: self._mean(name, scored) for name in self.dimensions}

    def _mean(self, dimension: str, scored: Mapping[str, float]) -> float | None:
        answered = [scored[name] for name in self.items_of(dimension) if name in scored]
        enough = len(answered) >= self.dimensions[dimension].min_answered
        return math.fsum(answered) / len(answered) if enough else None


def _check_scale(form: Questionnaire) -> None:
    is_scale = math.isfinite(form.low) and math.isfinite(form.high) and form.low < form.high
    expect(is_scale, "low", f"{form.low:g}", f"a number below high ({form.high:g})")
    scored = form.score_low, form.score_high
    are_scores = all(map(math.isfinite, scored)) and form.score_low != form.score_high
    expect(are_scores, "score_low", f"{scored[0]:g} with score_high {scored[1]:g}", "two different finite numbers")
    enough = "at least 2; leave it out for a continuous line"
    expect(form.steps is None or form.steps >= 2, "steps", form.steps, enough)
    some("items", form.items)
    for language, ends in form.ends.items():
        _check_pair(ends, f"ends.{language}", "the left and the right end")


def _check_pair(words: Sequence[str], path: str, what: str) -> None:
    are_two = len(words) == 2 and all(word.strip() for word in words)
    expect(are_two, path, list(words), f"two words, {what}")


def _check_order(form: Questionnaire) -> None:
    for key in ("id", "order"):
        values = [getattr(item, key) for item in form.items]
        index = first_repeat(values)
        if index is not None:
            raise InvalidParameter(f"items[{index}].{key}: found {values[index]!r} twice, expected each {key} once")


def questionnaire_of(table: Mapping[str, Any], path: str) -> Questionnaire:
    """Build a questionnaire from a table of a file; `path` opens each key path.

    Raises `InvalidParameter` if a key is wrong or the questionnaire is impossible.
    """
    return build(Questionnaire, table, path)


def parse(content: bytes, where: str) -> Questionnaire:
    """Parse the bytes of a questionnaire file; `where` opens error messages.

    Raises `InvalidFile` if they are no TOML, or anything is unknown, missing or impossible.
    """
    table = table_of(content, where, "a questionnaire")
    with errors_in(where):
        return questionnaire_of(table, "")


def questionnaires_of(tables: Mapping[str, Mapping[str, Any]]) -> dict[str, Questionnaire]:
    """Return the questionnaires of a study by name, from its `[forms.NAME]`, without forms of choices."""
    scales = {name: table for name, table in tables.items() if not is_choices(table)}
    return {name: questionnaire_of({"name": name, **table}, f"forms.{name}") for name, table in scales.items()}


@cache
def shipped_names() -> tuple[str, ...]:
    """Return the names of the shipped questionnaires.

    >>> "attrakdiff" in shipped_names()
    True
    """
    return shipped_in(FOLDER)


@cache
def load(name: str) -> Questionnaire:
    """Load a shipped questionnaire."""
    return load_shipped(FOLDER, name, "questionnaire", parse)
