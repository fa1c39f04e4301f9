"""Reasons why a touch is invalid, from its force and speed."""

from typing import Any, Final

from ..gates import VALID_PART, Compliance, SpeedCompliance
from ..session.request import Press, Slide
from ..trials.trial import Reason

STANDING_PART: Final = 0.1
"""Below this fraction of the target speed a finger has stopped (unverified default)."""


def broken_condition(request: Press | Slide, force: Compliance, speed: SpeedCompliance | None) -> Reason | None:
    """Return the condition that a touch violated; `speed` None is not checked."""
    if force.in_band < VALID_PART:
        return "too_light" if force.mean_n < request.target_n else "too_heavy"
    if speed is None or speed.in_band >= VALID_PART or isinstance(request, Press):
        return None
    return fault_of_speed(speed.mean_m_per_s, request.speed_m_per_s)


def fault_of_speed(speed_m_per_s: float, target_m_per_s: float) -> Reason:
    """Return the reason why a speed is outside its band.

    >>> fault_of_speed(0.001, 0.05), fault_of_speed(0.03, 0.05), fault_of_speed(0.08, 0.05)
    ('stopped', 'too_slow', 'too_fast')
    """
    if speed_m_per_s < STANDING_PART * target_m_per_s:
        return "stopped"
    return "too_slow" if speed_m_per_s < target_m_per_s else "too_fast"


def compliance_fields(force: Compliance | None, speed: SpeedCompliance | None) -> dict[str, Any]:
    """Return the compliance of force and speed, None if not measured."""
    names = ("force_mean_n", "force_sd_n", "force_in_band")
    of_force = [None] * len(names) if force is None else [round(value, 6) for value in force]
    speed_in_band = None if speed is None else round(speed.in_band, 6)
    return {**dict(zip(names, of_force, strict=True)), "speed_in_band": speed_in_band}
