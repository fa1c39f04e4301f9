"""Values times a number: what is computed for one volt, at the voltage of a run."""

from collections.abc import Callable

from ...composition.effect import Demand, Size, Stage

MULTIPLY = "operator:mul"


def at_voltage(name: str, per_volt: str, gives: str, size: Callable[[Demand], Size] | None = None) -> Stage:
    """The stage that brings a quantity per volt to the voltage of a run."""
    return Stage(name, (per_volt, "voltage_v"), gives, MULTIPLY, size=size)
