"""What a study asks for, held against its limits before anything is made of it."""

from contextlib import AbstractContextManager
from typing import TYPE_CHECKING

from tactometry.arguments.require import at_most, expect
from tactometry.errors import rewording
from tactometry.safety.limits import Limits
from tactometry.session.request import Play

if TYPE_CHECKING:
    from .experiment import Experiment, Strongest

MOST_SAMPLES = 100_000_000
"""What a stimulus may hold: 800 MB."""


def check_forces(experiment: "Experiment") -> None:
    """Refuse a force that is asked for beyond its limit."""
    for condition in experiment.conditions:
        request = condition.touch.request(condition.stimulus, None, None)
        if isinstance(request, Play):
            continue
        with _within_limits(f"touch.force_n: found {request.target_n:g} N"):
            experiment.study.limits.check_force(request.target_n, request.tolerance)


def check_signal(limits: Limits, strongest: "Strongest") -> None:
    """Refuse a signal beyond the limits; its length before its samples, which may be too many to make."""
    stimulus = strongest.stimulus
    duration_s = getattr(stimulus, "duration_s", 0.0)
    longest = f"at most limits.duration_s, {limits.longest_s:g} s; shorten the stimulus, or raise the limit"
    expect(duration_s <= limits.longest_s, "stimulus.duration_s", f"{duration_s:g} s", longest)
    n_samples = duration_s * getattr(stimulus, "rate_hz", 0.0)
    at_most("stimulus.duration_s times the rate, in samples", n_samples, MOST_SAMPLES)
    with _within_limits(f"{strongest.where}: found the highest level {strongest.level:g}"):
        limits.check(strongest.signal)


def _within_limits(finding: str) -> AbstractContextManager[None]:
    return rewording(lambda words: f"{finding}, expected one within the limits ({words})")
