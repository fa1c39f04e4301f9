"""Kinds of simulated participants, and custom observers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from operator import add
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Protocol

import numpy as np

from ..arguments.require import expect
from ..config.strict import as_table, build, build_kind, check_keys
from ..loading import resolve
from .changes import CHANGES, Answer, Change, Shift, Shifted
from .decisions import Observer
from .people import Draws, Feeling, People, SimulatedPerson, Stated, Varied

if TYPE_CHECKING:
    from .raters import Raters
import functools
import math
from contextlib import suppress
from types import NoneType

from ..user_code import MARK, Expected, class_beside, guarded, not_allowed

USUAL: Final = "signal_detection"
"""Kind of a table without the key `kind`."""
OBSERVERS: Final = {
    USUAL: "tactometry.observers.signal_detection:SignalDetectionObserver",
    "ideal": "tactometry.observers.ideal:IdealObserver",
    "psychometric": "tactometry.observers.psychometric:PsychometricObserver",
}


class Middle(Protocol):
    """Table of an observer: the average of the population of participants."""

    def participant(self, rng: np.random.Generator) -> Observer: ...


@dataclass(frozen=True)
class Population:
    """Population of participants: average, differences and changes."""

    middle: Middle
    people: People = field(default_factory=People)
    changes: Mapping[str, Change] = field(default_factory=dict)
    raters: "Raters | None" = None

    def check_allowed(self) -> None:
        """Refuse code that is not allowed to run, before anything is written."""
        if isinstance(self.middle, NotAllowed):
            self.middle.participant(np.random.default_rng(0))

    def person(self, rng: np.random.Generator) -> SimulatedPerson:
        """Draw a participant, with the traits of the population if it has any."""
        if not isinstance(self.middle, Varied):
            return SimulatedPerson(self.middle.participant(rng))
        traits = self.people.traits(rng)
        observer: Any = self.middle.person(traits)
        return SimulatedPerson(observer, traits.force_factor, traits.speed_factor)

    def feeling(
        self, person: SimulatedPerson, factors: Mapping[str, float | str], modality: str, draws: Draws
    ) -> Feeling:
        stated = person.observer.stated(factors) if isinstance(person.observer, Stated) else Feeling()
        return replace(stated, deviation_db=self.people.deviation_db(factors, modality, draws))

    def check(self, factors: Mapping[str, Sequence[float | str]], path: str) -> None:
        """Refuse names that are not factors or levels of a study."""
        self.people.check(factors, f"{path}.people")
        if isinstance(self.middle, Stated):
            self.middle.check(factors, path)

    def shift(self, n_trials: int, answers: Sequence[Answer], draws: Draws) -> Shift:
        """Return the change of a participant in a trial."""
        parts = (change.shift(n_trials, answers, draws("change", kind)) for kind, change in self.changes.items())
        return reduce(add, parts, Shift())


def population_of(table: Mapping[str, Any], path: str, code_from: Path | None = None) -> Population:
    """Build the population of a table. Custom code needs a folder.

    Raises `InvalidParameter` if the kind or a key is unknown.

    >>> population_of({"criterion": 2.0, "people": {"criterion_sd": 0.3}}, "observer").middle.criterion
    2.0
    """
    of_middle = {key: value for key, value in table.items() if key not in ("people", "changes", "raters")}
    middle = _middle_of({"kind": USUAL, **of_middle}, path, code_from)
    people = build(People, table.get("people", {}), f"{path}.people")
    kind = of_middle.get("kind", USUAL)
    has_traits = isinstance(middle, Varied | NotAllowed) or people == People()
    expect(has_traits, f"{path}.people", f"a table, but participants of the kind {kind!r} have no traits", "none")
    changes = _changes_of(as_table(table.get("changes", {}), f"{path}.changes"), f"{path}.changes")
    can_change = isinstance(middle, Shifted | NotAllowed) or not changes
    expect(can_change, f"{path}.changes", f"a table, but participants of the kind {kind!r} do not change", "none")
    return Population(middle, people, changes, _raters_of(table, f"{path}.raters"))


def _middle_of(table: Mapping[str, Any], path: str, code_from: Path | None) -> Middle:
    kind = table["kind"]
    middle: Middle
    if not isinstance(kind, str) or ":" not in kind:
        middle = build_kind(table, path, OBSERVERS)
    elif code_from is None:
        middle = NotAllowed(kind, path)
    else:
        keys = {key: value for key, value in table.items() if key != "kind"}
        middle = build(own_class(kind, code_from, path), keys, path)
    return middle


def _raters_of(table: Mapping[str, Any], path: str) -> "Raters | None":
    if "raters" not in table:
        return None
    from .raters import Raters

    return build(Raters, table["raters"], path)


def _changes_of(table: Mapping[str, Any], path: str) -> dict[str, Change]:
    check_keys(table, CHANGES, path, "kind of change")
    return {kind: build(resolve(CHANGES[kind]), keys, f"{path}.{kind}") for kind, keys in table.items()}


def _is_number(value: Any, low: float, high: float = math.inf) -> bool:
    is_number = isinstance(value, int | float | np.integer | np.floating)
    return is_number and bool(low <= value <= high) and math.isfinite(value)


def _is_yes_or_no(value: object, _: tuple[Any, ...]) -> bool:
    return isinstance(value, np.bool_) or (isinstance(value, int | np.integer) and value in (0, 1))


def _is_index(value: object, asked: tuple[Any, ...]) -> bool:
    return isinstance(value, int | np.integer) and bool(0 <= value < len(asked[0]))


def _are_facts(value: object, _: tuple[Any, ...]) -> bool:
    return isinstance(value, Mapping) and all(
        isinstance(name, str) and type(fact) in (str, int, float, bool, NoneType) for name, fact in value.items()
    )


def _is_observer(value: object, _: tuple[Any, ...]) -> bool:
    return all(callable(getattr(value, name, None)) for name in ANSWERS)


YES_OR_NO: Final = Expected("True or False", _is_yes_or_no, bool)
INDEX: Final = Expected("the index of an alternative, from 0", _is_index, int)
AMOUNT: Final = Expected("a finite number, at least 0", lambda value, _: _is_number(value, 0.0), float)
LIKING: Final = Expected("a number from -1 to 1", lambda value, _: _is_number(value, -1.0, 1.0), float)
FACTS: Final = Expected("a dictionary of texts and numbers", _are_facts, dict)
ANSWERS: Final = {
    "detect": YES_OR_NO, "compare": INDEX, "identify": INDEX, "differ": YES_OR_NO, "magnitude": AMOUNT,
    "liking": LIKING, "answer_time_s": AMOUNT, "facts": FACTS,
}  # fmt: skip
"""Answers that an observer must return, by method, as defined in `observers/decisions.py`."""
PEOPLE: Final = ("participant", "person", "shifted")
"""Methods that return an observer."""
OTHERS: Final = ("stated", "check", "__post_init__")


@functools.cache
def guarded_observer(kind: type) -> type:
    """Return a class whose calls return a plain answer or raise an error."""
    observer = Expected("an observer (observers/decisions.py)", _is_observer, _of_guarded_class)
    return guarded(kind, {**ANSWERS, **dict.fromkeys(PEOPLE, observer), **dict.fromkeys(OTHERS)})


def _of_guarded_class(observer: Any) -> Any:
    """Guard the class of an observer that user code created."""
    kind: Any = type(observer)
    if not kind.__module__.startswith("tactometry.") and not hasattr(kind, MARK):
        with suppress(TypeError):  # classes written in C cannot be guarded
            object.__setattr__(observer, "__class__", guarded_observer(kind))
    return observer


METHODS: Final = ("participant", *ANSWERS)
"""Methods that a custom observer must have."""


@dataclass(frozen=True)
class NotAllowed:
    """Observer whose code may not run, for a study that is only read."""

    target: str
    path: str

    def participant(self, rng: np.random.Generator) -> Observer:
        """Raise `InvalidParameter`."""
        del rng
        raise not_allowed(f"{self.path}.kind", self.target, "an observer")


def own_class(target: str, folder: Path, path: str) -> Any:
    """Return the class that ``module:Class`` names, from a file in `folder`.

    Raises `InvalidParameter` if the class is missing, its import fails, or it lacks methods of an observer.
    """
    where = f"{path}.kind"
    kind = class_beside(target, folder, where)
    lacking = [method for method in METHODS if not callable(getattr(kind, method, None))]
    found = f"{target!r}, which lacks {', '.join(lacking)}"
    expect(not lacking, where, found, "the methods of an observer (tactometry/observers/decisions.py)")
    return guarded_observer(kind)
