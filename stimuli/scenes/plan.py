"""Plans of scenes, and their runs."""

import math
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import isfinite
from typing import Any

import numpy as np

from tactometry.config.quantity import unit_suffix, units
from tactometry.errors import InvalidParameter
from tactometry.provenance import versions

from ..arrays import FloatArray
from ..composition.effect import Stage

Step = tuple[Callable[..., Any], tuple[int, ...], int]
"""A callable, the registers that it reads, and the register that it writes."""


OPERATIONS_PER_S = 1e9
CALL_S = 5e-6


@dataclass(frozen=True)
class Plan:
    """Stages from the `given` quantities to the `outputs`, each after those it needs."""

    stages: tuple[Stage, ...]
    given: tuple[str, ...]
    outputs: tuple[str, ...]

    def __repr__(self) -> str:
        """Return one line: given quantities, stages and outputs.

        >>> Plan((Stage("force", ("voltage_v",), "force_n", "math:sqrt"),), ("voltage_v",), ("force_n",))
        Plan(voltage_v > force > force_n)
        """
        stages = ", ".join(stage.name for stage in self.stages)
        return f"Plan({', '.join(self.given)} > {stages} > {', '.join(self.outputs)})"

    @property
    def error(self) -> float:
        """Predicted relative error of the outputs: the sum over the stages."""
        return sum(stage.error for stage in self.stages)

    @property
    def n_operations(self) -> float:
        return sum(stage.n_operations for stage in self.stages)

    @property
    def predicted_s(self) -> float:
        """Predicted time: `CALL_S` per stage, plus the operations."""
        return sum(predicted_s(stage) for stage in self.stages)

    def prepare(self) -> None:
        """Bind the stages and compute those that do not depend on given values."""
        _ = self._program

    def timed(self, given: Mapping[str, Any]) -> tuple[float, ...]:
        """Measure the time (s) of each stage in a separate run, imports included."""
        values = dict(given)
        times: list[float] = []
        for stage in self.stages:
            start_s = time.perf_counter()
            values[stage.gives] = stage.bind()(*(values[need] for need in stage.needs))
            times.append(time.perf_counter() - start_s)
        return tuple(times)

    def run(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Return the outputs for the given quantities.

        Stages that depend on none of them run once for all runs of this plan.

        Raises `InvalidParameter` if a quantity is missing, unexpected or not finite.
        """
        program = self._program
        if given.keys() != program.given:
            raise InvalidParameter(
                f"scene: found {', '.join(sorted(given)) or 'nothing'} given, expected "
                f"{', '.join(self.given) or 'nothing'}"
            )
        for name, value in given.items():
            if isinstance(value, (int, float)) and not isfinite(value):
                raise InvalidParameter(f"given.{name}: found {value}, expected a finite number")
        registers = [*program.constants, *[given[name] for name in self.given]]
        registers += [None] * program.n_varying
        for call, read, written in program.steps:
            registers[written] = call(*[registers[n] for n in read])
        return {name: registers[n] for name, n in program.outputs.items()}

    @cached_property
    def _program(self) -> "_Program":
        return _compile(self)


def predicted_s(stage: Stage) -> float:
    """Return the predicted time (s) of a stage.

    >>> predicted_s(Stage("a", (), "b", "c:d", n_operations=995e3))
    0.001
    """
    return CALL_S + stage.n_operations / OPERATIONS_PER_S


@dataclass(frozen=True)
class _Program:
    """Constant values and the steps of a run."""

    constants: tuple[Any, ...]
    given: frozenset[str]
    n_varying: int
    steps: tuple[Step, ...]
    outputs: Mapping[str, int]


def _compile(plan: Plan) -> _Program:
    constant, varying = _split(plan.stages, plan.given)
    values: dict[str, Any] = {}
    for stage in constant:  # release replaced values: the motion of a plate may fill half of the memory
        values[stage.gives] = stage.bind()(*(values[need] for need in stage.needs))
    read = {name for stage in varying for name in stage.needs} | set(plan.outputs)
    values = {name: value for name, value in values.items() if name in read}
    at = {name: n for n, name in enumerate((*values, *plan.given))}
    first = len(at)
    steps: list[Step] = []
    for n, stage in enumerate(varying):
        steps.append((stage.bind(), tuple(at[need] for need in stage.needs), first + n))
        at[stage.gives] = first + n
    outputs = {name: at[name] for name in plan.outputs}
    return _Program(tuple(values.values()), frozenset(plan.given), len(varying), tuple(steps), outputs)


def _split(stages: Sequence[Stage], given: Collection[str]) -> tuple[list[Stage], list[Stage]]:
    """Split stages by whether they depend on a given quantity, in order."""
    moving = set(given)
    still: list[Stage] = []
    varying: list[Stage] = []
    for stage in stages:
        moves = not moving.isdisjoint(stage.needs)
        (varying if moves else still).append(stage)
        if moves:
            moving.add(stage.gives)
    return still, varying


def parted(plan: Plan, late: str) -> tuple[Plan, Plan]:
    """Split a plan by whether stages depend on one given quantity.

    The second plan is given that quantity and the outputs of the first.

    >>> double = Stage("double", ("a",), "b", "operator:neg")
    >>> both = Stage("both", ("b", "c"), "d", "operator:mul")
    >>> early, rest = parted(Plan((double, both), ("a", "c"), ("d",)), "c")
    >>> early.outputs, rest.given, rest.run({**early.run({"a": 2.0}), "c": 5.0})
    (('b',), ('b', 'c'), {'d': -10.0})
    """
    early, rest = _split(plan.stages, {late})
    made = {stage.gives for stage in early}
    needed = dict.fromkeys([*(need for stage in rest for need in stage.needs), *plan.outputs])
    handed = tuple(name for name in needed if name in made or (name in plan.given and name != late))
    before = Plan(tuple(early), tuple(name for name in plan.given if name != late), handed)
    return before, Plan(tuple(rest), (*handed, late), plan.outputs)


ABOVE_THRESHOLD = ("sensation_db", "channels_db")


@dataclass(frozen=True)
class Result:
    """Outputs of a plan, with its input, package versions and run times.

    `prepared_s` is the time of the stages that are the same in all runs. No stage is random, so there is no seed.
    """

    values: Mapping[str, Any]
    plan: Plan
    given: Mapping[str, float]
    elapsed_s: float
    prepared_s: float = 0.0
    versions: Mapping[str, str] = field(default_factory=versions)

    def unit(self, name: str) -> str:
        """Return the unit in the name of an output.

        >>> Result({"peak_force_n": 1.0}, Plan((), (), ()), {}, 0.0).unit("peak_force_n")
        'N'
        """
        return unit_of(name)


def unit_of(name: str) -> str:
    """Return the unit in the name of a quantity, or "".

    Sensation levels (dB SL) are relative to the detection threshold.

    >>> unit_of("peak_m"), unit_of("sensation_db"), unit_of("field")
    ('m', 'dB SL', '')
    """
    if "_db" in name:
        return "dB(A)" if name.endswith("_dba") else "dB SL" if name.endswith(ABOVE_THRESHOLD) else "dB"
    suffix = unit_suffix(name)
    return units(suffix)[0] if suffix else ""


def compute(plan: Plan, given: Mapping[str, float]) -> Result:
    """Run a plan and time it, after computing the shared stages.

    Raises `InvalidParameter` if the plan does not fit into memory.
    """
    begin_s = time.perf_counter()
    try:
        plan.prepare()
        start_s = time.perf_counter()
        values = plan.run(given)
    except MemoryError as error:
        raise InvalidParameter(
            f"scene: found more data than fit into memory ({error}), expected a smaller scene; loosen the accuracy or "
            "lower its settings"
        ) from None
    return Result(values, plan, given, time.perf_counter() - start_s, start_s - begin_s)


FORCE, MOVED = "contact_force_n", "motion"


@dataclass(frozen=True)
class PulledFinger:
    """A finger, its normal force (N), and the plate's largest pull (N) on it at a voltage (V)."""

    finger: int
    force_n: float
    pull_n: float
    voltage_v: float

    @property
    def lifts_off(self) -> bool:
        return self.pull_n > self.force_n

    @property
    def first_db_re_1v(self) -> float:
        """Voltage at which a linear contact begins to pull, in dB re 1 V."""
        first_v = abs(self.voltage_v) * self.force_n / self.pull_n if self.pull_n else math.inf
        return 20 * math.log10(first_v)

    @property
    def line(self) -> str:
        """Describe lift-off in one sentence.

        >>> PulledFinger(1, 2.0, 0.5, 10.0).line
        'finger 1 stays: at 20 dB re 1 V the plate would pull it by 0.5 N, and its normal force is 2 N'
        """
        at = f"at {20 * math.log10(abs(self.voltage_v)):.3g} dB re 1 V" if self.voltage_v else "at 0 V"
        pulled = f"{at} the plate would pull it by {self.pull_n:.2g} N, and its normal force is {self.force_n:g} N"
        if not self.lifts_off:
            return f"finger {self.finger} stays: {pulled}"
        return f"finger {self.finger} lifts off: {pulled}; contact is lost from {self.first_db_re_1v:.3g} dB re 1 V on"


def loads_n(plan: Plan) -> FloatArray:
    """Return the normal forces (n_contacts,) of the fingers, in order."""
    loads = (stage.settings for stage in plan.stages if stage.gives == MOVED and "force_n" in stage.settings)
    return np.asarray(next(loads, {}).get("force_n", ()), float)


def is_linear(plan: Plan) -> bool:
    """Return True if the plate's motion is proportional to the voltage."""
    return not any(stage.gives == MOVED and "voltage_v" in stage.needs for stage in plan.stages)


def pulled_fingers(result: Result) -> list[PulledFinger]:
    """Return the fingers under linear contacts, with the pull on each."""
    if FORCE not in result.values or not is_linear(result.plan):
        return []
    lowest = np.atleast_2d(result.values[FORCE]).min(axis=1)
    pressed = zip(loads_n(result.plan), lowest, strict=True)
    return [
        PulledFinger(n, float(force_n), max(-float(least), 0.0), result.given["voltage_v"])
        for n, (force_n, least) in enumerate(pressed, 1)
    ]
