"""What a scene gave: values with units, and all that they come from."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from tactometry.config.quantity import unit_suffix, units
from tactometry.errors import InvalidParameter
from tactometry.provenance import versions

from .plan import Plan

ABOVE_THRESHOLD = ("sensation_db", "channels_db")


@dataclass(frozen=True)
class Result:
    """Outputs of a plan, with the plan, what was given, the versions of the packages, and the time (s) of the run and
    of what never changes between runs.

    No stage draws at random, so that there is no seed.
    """

    values: Mapping[str, Any]
    plan: Plan
    given: Mapping[str, float]
    elapsed_s: float
    prepared_s: float = 0.0
    versions: Mapping[str, str] = field(default_factory=versions)

    def unit(self, name: str) -> str:
        """The unit of an output; its name says it.

        >>> Result({"peak_force_n": 1.0}, Plan((), (), ()), {}, 0.0).unit("peak_force_n")
        'N'
        """
        return unit_of(name)


def unit_of(name: str) -> str:
    """The unit in the name of a quantity, empty without one.

    Sensation levels (dB SL) are those above the threshold of detection.

    >>> unit_of("peak_m"), unit_of("sensation_db"), unit_of("field")
    ('m', 'dB SL', '')
    """
    if "_db" in name:
        return "dB(A)" if name.endswith("_dba") else "dB SL" if name.endswith(ABOVE_THRESHOLD) else "dB"
    suffix = unit_suffix(name)
    return units(suffix)[0] if suffix else ""


def compute(plan: Plan, given: Mapping[str, float]) -> Result:
    """A run of a plan, timed; what never changes between runs is computed before.

    Raises
    ------
    InvalidParameter
        If it does not fit into memory.
    """
    begin_s = time.perf_counter()
    try:
        plan.prepare()
        start_s = time.perf_counter()
        values = plan.run(given)
    except MemoryError as error:
        raise InvalidParameter(
            f"scene: found more than this memory holds ({error}), expected a scene that fits; loosen the accuracy, or "
            "lower its settings"
        ) from None
    return Result(values, plan, given, time.perf_counter() - start_s, start_s - begin_s)
