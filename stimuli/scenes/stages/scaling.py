"""Values times a number: what is computed for one volt, at the voltage of a run."""

from collections.abc import Callable
from typing import Any

from ...composition.effect import Demand, Size, Stage

MULTIPLIED = f"{__name__}:multiplied"


def at_voltage(name: str, per_volt: str, gives: str, size: Callable[[Demand], Size] | None = None) -> Stage:
    """The stage that brings a quantity per volt to the voltage of a run."""
    return Stage(name, (per_volt, "voltage_v"), gives, MULTIPLIED, size=size)


def multiplied() -> Callable[[Any, float], Any]:
    """Values times a number."""
    return lambda values, factor: values * factor
