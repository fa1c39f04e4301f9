"""Influence of each parameter on the sensation level in a study."""

import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import partial
from importlib import import_module
from math import inf, isfinite
from types import ModuleType
from typing import Any, Final, Literal

from tactometry.arguments.require import expect
from tactometry.config.strict import build
from tactometry.config.toml import shipped_table
from tactometry.errors import InvalidParameter, LimitExceeded
from tactometry.loading import resolve
from tactometry.observers.signal_detection import SignalDetectionObserver
from tactometry.stimuli.scenes.scene import Scene

from .cells import WiredCell
from .experiment import Experiment
from .felt_scene import FeltScene, felt
from .predictions import contact_of, felt_db, threshold_db

Value = float | str
Status = Literal["exact", "published", "abstract", "choice", "from_memory", "no_source"]
UNVERIFIED: Final = ("from_memory", "no_source")
"""Statuses of defaults whose number was not read in a source."""


@dataclass(frozen=True)
class Parameter:
    """A default with its range and source.

    `key` is the group and the name in the code. `read` states how the source was read.
    """

    key: str
    value: Value
    low: Value
    high: Value
    unit: str
    status: Status
    source: str
    read: str

    @property
    def is_unverified(self) -> bool:
        """True if the number was not read in a source."""
        return self.status in UNVERIFIED

    @property
    def status_text(self) -> str:
        """The status in words."""
        return self.status.replace("_", " ")

    @property
    def path(self) -> list[str]:
        """Names from the class or module of the group to the value."""
        return self.key.split(".")[1:]


@dataclass(frozen=True)
class Group:
    """Parameters of one class or module.

    - `code`: Class or object with the defaults (``module:Class``), or a module with constants.
    - `kinds`: Classes whose objects have the values in a study, by default that of `code`.
    - `effects`: Effects of a scene that use the constants of a module.
    - `varied`: False if the effect on the sensation level is not computed.
    """

    name: str
    code: str
    kinds: tuple[str, ...]
    effects: tuple[str, ...]
    varied: bool
    parameters: tuple[Parameter, ...]

    @property
    def target(self) -> Any:
        """The class, object or module with the defaults."""
        return resolve(self.code) if ":" in self.code else import_module(self.code)

    @property
    def classes(self) -> tuple[type, ...]:
        """Classes whose objects have the values in a study, none for a module."""
        if self.kinds:
            return tuple(resolve(kind) for kind in self.kinds)
        return (self.target,) if isinstance(self.target, type) else ()

    def default(self, parameter: Parameter) -> Value:
        """Return the default in the code."""
        return value_at(self.target, parameter.path)


def groups() -> tuple[Group, ...]:
    """Read the table of sources.

    >>> [group.name for group in groups()][:3]
    ['skin', 'skin_leakage', 'contact_area']
    """
    return tuple(_group(name, dict(rows)) for name, rows in shipped_table("tactometry.stimuli", "sources").items())


def parameters() -> tuple[Parameter, ...]:
    """Return the parameters of all groups."""
    return tuple(parameter for group in groups() for parameter in group.parameters)


def status_counts(listed: Iterable[Parameter]) -> str:
    """Return the number of parameters of each status as a text."""
    counts = Counter(one.status_text for one in listed)
    return ", ".join(f"{n} {status}" for status, n in sorted(counts.items()))


def value_at(holder: Any, path: list[str]) -> Value:
    """Return the value at a path of attributes and indices.

    >>> value_at(slice((3, 4.5)), ["stop", "1"])
    4.5
    """
    for name in path:
        holder = holder[int(name)] if name.isdigit() else getattr(holder, name)
    result: Value = holder
    return result


def _group(name: str, rows: dict[str, Any]) -> Group:
    code, varied = rows.pop("code"), rows.pop("varied", True)
    kinds, effects = tuple(rows.pop("kinds", ())), tuple(rows.pop("effects", ()))
    each = (build(Parameter, row, f"{name}.{of}", key=f"{name}.{of}") for of, row in rows.items())
    return Group(name, code, kinds, effects, varied, tuple(each))


Classes = tuple[type, ...]
N_MARKED: Final = 3
NEGLIGIBLE_DB: Final = 5e-3
"""Smaller changes are not marked."""


@dataclass(frozen=True)
class Influence:
    """Change of the sensation level (dB) at both ends of a parameter's range.

    `set_to` is the value in the study. A change is None if it was not or cannot be computed.
    """

    parameter: Parameter
    set_to: Value
    at_low_db: float | None = None
    at_high_db: float | None = None
    is_marked: bool = False

    @property
    def largest_db(self) -> float:
        """The larger change, 0 without any."""
        return max(abs(self.at_low_db or 0.0), abs(self.at_high_db or 0.0))


@dataclass(frozen=True)
class StudySources:
    """Parameters in the first condition of a study, the most influential first."""

    condition: Mapping[str, float | str]
    level: float
    level_unit: str
    is_threshold: bool
    influences: tuple[Influence, ...]


@dataclass(frozen=True)
class _Reference:
    """A condition at a level."""

    cell: WiredCell
    scene: Scene
    level: float

    def sensation_db(self) -> float:
        return felt_db(self.cell, self.level, contact_of(self.cell))

    def varied(self, kinds: Classes, name: str, value: Value) -> "_Reference":
        """Return the condition with another value in all objects of some classes."""
        stimulus, scene = (_varied(part, kinds, name, value) for part in (self.cell.stimulus, self.scene))
        return self._with(stimulus, scene)

    def renewed(self) -> "_Reference":
        """Return the condition without cached results."""
        stimulus: Any = self.cell.stimulus
        return self._with(replace(stimulus), replace(self.scene))

    def _with(self, stimulus: Any, scene: Scene) -> "_Reference":
        return replace(self, cell=replace(self.cell, stimulus=stimulus, sensation=felt(scene)), scene=scene)


def sources_of(experiment: Experiment) -> StudySources:
    """Set each parameter of a study to both ends of its range, one at a time.

    Raises `InvalidParameter` if no simulated participant feels a scene in the first condition.
    """
    cell = next(iter(experiment.cells.values()))
    scene = _felt_scene(experiment, cell)
    level, is_threshold = _reference_level(cell)
    reference = _Reference(cell, scene, level)
    parts = (cell.stimulus, scene, experiment.people.middle, experiment.people.raters, experiment.study.finger)
    before_db = reference.sensation_db()
    result = [one for group in groups() for one in _influences(group, reference, before_db, parts)]
    result.sort(key=lambda one: -one.largest_db)
    marked = [replace(one, is_marked=one.largest_db > NEGLIGIBLE_DB) for one in result[:N_MARKED]]
    shown = (*marked, *result[N_MARKED:])
    return StudySources(cell.condition.factors, level, cell.stimulus.level_unit, is_threshold, shown)


def _felt_scene(experiment: Experiment, cell: WiredCell) -> Scene:
    """Return the scene that simulated participants feel, or raise."""
    expected = "one whose simulated participants feel a scene"
    measured = f"{experiment.where!r}, which has no simulated participants: a device reads its stimuli"
    expect(experiment.table.kind != "measurement", "STUDY", measured, expected)
    follows = isinstance(experiment.people.middle, SignalDetectionObserver)
    if not (follows and isinstance(cell.sensation, FeltScene)):
        raise InvalidParameter(
            f"STUDY: found {experiment.where!r}, whose simulated participants do not follow from physics, "
            f"expected {expected}"
        )
    return cell.sensation.scene


def _reference_level(cell: WiredCell) -> tuple[float, bool]:
    """Return the level at the threshold of a condition, else its highest level."""
    bounds = cell.procedure.rule.bounds
    result = None
    if cell.stimulus.level_unit.startswith("dB"):
        result = threshold_db(partial(felt_db, cell, contact=contact_of(cell)), bounds)
    return (bounds[1], False) if result is None else (result, True)


def _influences(group: Group, reference: _Reference, before_db: float, parts: tuple[Any, ...]) -> Iterator[Influence]:
    """Yield the influences of a group, none if the study does not use it."""
    if group.classes:
        held = next(_instances(parts, group.classes), None)
    else:
        is_used = any(effect.kind in group.effects for effect in reference.scene.effects)
        held = group.target if is_used else None
    for parameter in group.parameters if held is not None else ():
        set_to = value_at(held, parameter.path)
        one = Influence(parameter, set_to)
        if group.varied:
            ends = parameter.low, parameter.high
            low_db, high_db = (
                0.0 if end == set_to else _finite(_db_at(reference, group, parameter, end) - before_db) for end in ends
            )
            one = replace(one, at_low_db=low_db, at_high_db=high_db)
        yield one


def _db_at(reference: _Reference, group: Group, parameter: Parameter, end: Value) -> float:
    """Return the sensation level at an end of a range, -inf if it cannot be computed."""
    with suppress(InvalidParameter, LimitExceeded):
        if group.classes:
            return reference.varied(group.classes, parameter.path[0], end).sensation_db()
        with _constant(group.target, parameter.path, end):
            return reference.renewed().sensation_db()
    return -inf


def _finite(change_db: float) -> float | None:
    return change_db if isfinite(change_db) else None


def _varied(thing: Any, kinds: Classes, name: str, value: Value) -> Any:
    """Return a value in which all objects of some classes have another field."""
    if isinstance(thing, kinds):
        changed: Any = thing
        return replace(changed, **{name: value})
    if isinstance(thing, tuple):
        return tuple(_varied(part, kinds, name, value) for part in thing)
    if not is_dataclass(thing) or isinstance(thing, type):
        return thing
    inner = {one.name: getattr(thing, one.name) for one in fields(thing) if one.init}
    new = {key: _varied(part, kinds, name, value) for key, part in inner.items()}
    return replace(thing, **{key: part for key, part in new.items() if part is not inner[key]})


def _instances(thing: Any, kinds: Classes) -> Iterator[Any]:
    """Yield the objects of some classes within a value."""
    if isinstance(thing, kinds):
        yield thing
    elif isinstance(thing, tuple):
        for part in thing:
            yield from _instances(part, kinds)
    elif is_dataclass(thing):
        for one in fields(thing):
            yield from _instances(getattr(thing, one.name), kinds)


@contextmanager
def _constant(module: ModuleType, path: list[str], value: Value) -> Iterator[None]:
    """Set a constant of a module, also one within tuples, for a while."""
    name, *inner = path
    usual = getattr(module, name)
    setattr(module, name, _set(usual, inner, value))
    try:
        _forget()
        yield
    finally:
        setattr(module, name, usual)
        _forget()


def _set(held: Any, path: list[str], value: Value) -> Any:
    if not path:
        return value
    n = int(path[0])
    return (*held[:n], _set(held[n], path[1:], value), *held[n + 1 :])


def _forget() -> None:
    """Clear the caches of the stimuli, which know nothing of changed constants."""
    modules = [module for name, module in sys.modules.items() if name.startswith("tactometry.stimuli")]
    for thing in (thing for module in modules for thing in vars(module).values()):
        if hasattr(thing, "cache_clear"):
            thing.cache_clear()
