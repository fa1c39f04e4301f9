"""The tables of a study file that say what simulated participants feel, and how they answer and touch."""

from collections.abc import Iterator, Mapping
from typing import Final

from tactometry.observers.changes import CHANGES
from tactometry.observers.kinds import OBSERVERS, USUAL

from ..study.stimulus_kinds import ELECTROVIBRATION, STIMULI
from .key_table import KeyTable, Values
from .study_tables import stimulus_gives

_SKIN: Final = "tactometry.stimuli.electrovibration"
_OF_SETUP: Final = ("focus", "measured_focus", "foci", "hybrid")
"""A kind for each model of what is felt of a screen."""
_SENSATION: Final[Values] = {
    "finger_x_m": 0.1, "finger_y_m": 0.1, "reference_force_n": 0.05, "polarity": {"positive_share": 0.5}, "x_m": 0.1,
    "y_m": 0.1,
}  # fmt: skip
_OBSERVERS: Final[Mapping[str, Values]] = {"psychometric": {"threshold": 26.0}}
_OF_PEOPLE: Final[Values] = {
    "factor_sd_db": {"force_n": 1.0},
    "effects_db": {"force_n": {"2": 3.0}},
    "correlations": {"sensitivity": {"criterion": 0.3}},
}
_OF_RATERS: Final[Values] = {"loadings": {"PQ1": 0.5}, "effects": {"wave": {"P1": {"PQ": 0.4}}}}


def people_tables() -> Iterator[KeyTable]:
    """The tables of sensation, observer and finger."""
    yield KeyTable("sensation", "[sensation]", ELECTROVIBRATION, samples=_SENSATION)
    layer = {"thickness_m": 5e-3}
    yield KeyTable("sensation.skin", "[sensation.skin]", f"{_SKIN}.skin.skin:Skin", samples={"tissue": layer})
    yield KeyTable("sensation.skin.tissue", "[sensation.skin.tissue]", f"{_SKIN}.skin.stack:Layer", example=layer)
    yield from _parts_of_sensation()
    yield from map(_of_screen, _OF_SETUP)
    yield from map(_observer, OBSERVERS)
    people, raters = "tactometry.observers.people:People", "tactometry.observers.raters:Raters"
    yield KeyTable("observer.people", "[observer.people]", people, samples=_OF_PEOPLE)
    yield KeyTable("observer.raters", "[observer.raters]", raters, samples=_OF_RATERS)
    for kind, target in CHANGES.items():
        yield KeyTable(f"observer.changes.{kind}", f"[observer.changes.{kind}]", target)
    yield KeyTable("finger", "[finger]", "tactometry.observers.finger:SimulatedFinger")


def _parts_of_sensation() -> Iterator[KeyTable]:
    attraction, motion = f"{_SKIN}.attraction", f"{_SKIN}.motion"
    targets = {
        "friction": f"{motion}.coulomb_friction:CoulombFriction",
        "lag": f"{motion}.friction_lag:FrictionLag",
        "mobility": f"{motion}.skin_mobility:SkinMobility",
        "polarity": f"{attraction}.polarity:Polarity",
    }
    for name, target in targets.items():
        example = {"positive_share": 0.5} if name == "polarity" else {}
        yield KeyTable(f"sensation.{name}", f"[sensation.{name}]", target, example=example)


def _of_screen(kind: str) -> KeyTable:
    known = STIMULI[kind]
    samples = {**_SENSATION, "fingers": ["index"]}
    given = stimulus_gives(*known.shared)
    return KeyTable(f"sensation.{kind}", "[sensation]", known.sensation, samples=samples, given=given)


def _observer(kind: str) -> KeyTable:
    return KeyTable(
        f"observer.{kind}",
        "[observer]",
        OBSERVERS[kind],
        kind,
        usual=kind == USUAL,
        example=_OBSERVERS.get(kind, {}),
        samples={"conditions": [{"force_n": 0.5, "threshold": 24.0}]},
        also=("observer.people", "observer.raters"),
        in_levels=("threshold", "width"),
    )
