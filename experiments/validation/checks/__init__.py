"""Checks by name. Each is imported when requested."""

from collections.abc import Mapping
from typing import Final

from ...harness import item
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
"""Import target of each check."""


def check_of(name: str) -> Check:
    """Return a check by its name."""
    check: Check = item(CHECKS, name)
    return check
