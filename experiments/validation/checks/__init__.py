"""The checks, each in a file of its own; none is imported unless it is asked for."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from tactometry.loading import resolve

from ..check import Check

_HERE: Final = "tactometry.experiments.validation.checks"
CHECKS: Final[Mapping[str, str]] = {
    "thresholds": f"{_HERE}.thresholds:CHECK",
    "comparisons": f"{_HERE}.comparisons:CHECK",
    "calibration": f"{_HERE}.calibration:CHECK",
    "false-alarms": f"{_HERE}.values:FALSE_ALARMS",
    "effects": f"{_HERE}.values:EFFECTS",
    "false-alarms-of-answers": f"{_HERE}.answers:FALSE_ALARMS",
    "effects-of-answers": f"{_HERE}.answers:EFFECTS",
    "false-alarms-of-ratings": f"{_HERE}.ratings:FALSE_ALARMS",
    "effects-of-ratings": f"{_HERE}.ratings:EFFECTS",
}
"""The name of each check, and where it is."""


def check_of(name: str) -> Check:
    """A check by its name."""
    check: Check = resolve(CHECKS[name])
    return replace(check, name=name)
