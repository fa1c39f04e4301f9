"""Every kind of simulated participant, by the name that a study file uses, imported when it is named."""

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
from .own import NotAllowed, own_class
from .people import Draws, Feeling, People, SimulatedPerson, Stated, Varied

if TYPE_CHECKING:
    from .raters import Raters

USUAL: Final = "signal_detection"
"""What a table that names no kind means."""
OBSERVERS: Final = {
    USUAL: "tactometry.observers.signal_detection:SignalDetectionObserver",
    "ideal": "tactometry.observers.ideal:IdealObserver",
    "psychometric": "tactometry.observers.psychometric:PsychometricObserver",
}


class Middle(Protocol):
    """The table of an observer: the middle of the people that a participant is drawn from."""

    def participant(self, rng: np.random.Generator) -> Observer: ...


@dataclass(frozen=True)
class Population:
    """The people that participants are drawn from: their middle, how they differ from it, how they change during a
    session, by the kind of the change, and how they rate, where not by how good the strength of a stimulus feels."""

    middle: Middle
    people: People = field(default_factory=People)
    changes: Mapping[str, Change] = field(default_factory=dict)
    raters: "Raters | None" = None

    def check_allowed(self) -> None:
        """Refuse people whose code is not allowed to run, before anything is written."""
        if isinstance(self.middle, NotAllowed):
            self.middle.participant(np.random.default_rng(0))

    def person(self, rng: np.random.Generator) -> SimulatedPerson:
        """One of them; a middle that knows no traits draws its participant itself."""
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
        """Refuse what names no factor or level of a study.

        Raises `InvalidParameter` at the first; `path` opens the sentence.
        """
        self.people.check(factors, f"{path}.people")
        if isinstance(self.middle, Stated):
            self.middle.check(factors, path)

    def shift(self, n_trials: int, answers: Sequence[Answer], draws: Draws) -> Shift:
        """By how much the person whose session has these streams is off in a trial."""
        parts = (change.shift(n_trials, answers, draws("change", kind)) for kind, change in self.changes.items())
        return reduce(add, parts, Shift())


def population_of(table: Mapping[str, Any], path: str, code_from: Path | None = None) -> Population:
    """The people that a table describes; the code of an observer of one's own, ``module:Class``, is run only if it is
    allowed to be taken from a folder.

    Raises `InvalidParameter` if the kind is unknown, or does not know what the table holds; `path` opens the sentence.

    >>> population_of({"criterion": 2.0, "people": {"criterion_sd": 0.3}}, "observer").middle.criterion
    2.0
    """
    of_middle = {key: value for key, value in table.items() if key not in ("people", "changes", "raters")}
    middle = _middle_of({"kind": USUAL, **of_middle}, path, code_from)
    people = build(People, table.get("people", {}), f"{path}.people")
    kind = of_middle.get("kind", USUAL)
    has_traits = isinstance(middle, Varied | NotAllowed) or people == People()
    expect(has_traits, f"{path}.people", f"a table beside the kind {kind!r}, whose people have no traits", "none")
    changes = _changes_of(as_table(table.get("changes", {}), f"{path}.changes"), f"{path}.changes")
    can_change = isinstance(middle, Shifted | NotAllowed) or not changes
    expect(can_change, f"{path}.changes", f"a table beside the kind {kind!r}, whose people do not change", "none")
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
