"""Check the limits and places of a wired study."""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass

from tactometry.arguments.require import at_most, expect
from tactometry.errors import count_of, rewording
from tactometry.protocols.block_state import Condition
from tactometry.protocols.tasks.task import Place
from tactometry.safety.limits import Limits
from tactometry.session.request import Play
from tactometry.signal import Signal, Stimulus

from .cells import WiredCell
from .session_plan import Key, places_of

MOST_SAMPLES = 100_000_000
"""Largest number of samples in a stimulus (800 MB)."""


@dataclass(frozen=True)
class Strongest:
    """Stimulus at its highest level, and the table that sets this level."""

    name: str
    where: str
    level: float
    stimulus: Stimulus

    @property
    def signal(self) -> Signal:
        return self.stimulus.at(self.level)


def check_forces(limits: Limits, conditions: Iterable[Condition]) -> None:
    """Reject a requested force above its limit."""
    for condition in conditions:
        request = condition.touch.request(condition.stimulus, None, None)
        if isinstance(request, Play):
            continue
        with _within_limits(f"touch.force_n: found {request.target_n:g} N"):
            limits.check_force(request.target_n, request.tolerance)


def check_signal(limits: Limits, strongest: Strongest) -> None:
    """Reject a signal that exceeds the limits. Checks its length first."""
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


def check_places(over: str | None, cells: Mapping[Key, WiredCell]) -> None:
    """Reject alternatives of a trial that have the same place."""
    together: dict[Key, list[frozenset[Place]]] = defaultdict(list)
    for key, cell in cells.items():
        rest = tuple(item for item in key if item[0] != over)
        together[rest].extend(filter(None, [frozenset(places_of(cell.stimulus))]))
    for alternatives in together.values() if over else ():
        n, n_apart = len(alternatives), len(set(alternatives))
        found = f"{n} alternatives of {over!r} at {count_of(n_apart, 'place')}"
        expect(n == n_apart, "task.over", found, "a separate place for each alternative")
