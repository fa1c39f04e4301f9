"""Values times a number: what is computed for one volt, at the voltage of a run; and the largest of some."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from ...composition.effect import Demand, Size, Stage

if TYPE_CHECKING:
    from ...arrays import FloatArray

MULTIPLY = "operator:mul"
HIGHEST = f"{__name__}:highest"


def at_voltage(name: str, per_volt: str, gives: str, size: Callable[[Demand], Size] | None = None) -> Stage:
    """The stage that brings a quantity per volt to the voltage of a run."""
    return Stage(name, (per_volt, "voltage_v"), gives, MULTIPLY, size=size)


def highest(course: "FloatArray") -> float:
    """The largest value of a course."""
    return float(course.max())
