"""Conditions on the finger during a stimulus, and sequences of stimuli."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

from tactometry.arguments.constraints import Positive, constrained
from tactometry.arguments.require import expect
from tactometry.session.answer import Touched
from tactometry.session.request import TRAJECTORY_M, Play, Press, Slide
from tactometry.session.run import Course


class Touch(Protocol):
    """Conditions of a touch, from which the request of a stimulus is created."""

    def request(self, stimulus: str, level: float | None, interval: int | None) -> Play | Press | Slide: ...


def fair_tolerance(force_n: float) -> float:
    """Return the relative tolerance: 20 %, below 0.5 N 30 % (unverified).

    >>> fair_tolerance(0.5), fair_tolerance(0.2)
    (0.2, 0.3)
    """
    return 0.2 if force_n >= 0.5 else 0.3


@dataclass(frozen=True)
@constrained
class GatedTouch:
    """Finger that presses with a force.

    The force must be `force_n` within `tolerance` (relative; None: `fair_tolerance`) for `hold_s` before the stimulus
    begins, and while the stimulus plays. The wait for the stimulus lasts at most `timeout_s`.

    - `duration_s`: Duration of the stimulus.
    - `force_n`: Force that the participant is asked to apply.
    - `hold_s`: Duration for which the force must be held before the stimulus begins.
    - `timeout_s`: Time limit for the stimulus to begin. A later touch does not count.
    - `tolerance`: Largest relative deviation of the force. The default is 0.2, and 0.3 below 0.5 N.
    """

    duration_s: Positive
    force_n: Positive
    hold_s: Positive
    timeout_s: Positive
    tolerance: Positive | None = None

    def __post_init__(self) -> None:
        longest = f"less than timeout_s ({self.timeout_s:g} s), as no touch could begin otherwise"
        expect(self.hold_s < self.timeout_s, f"{type(self).__name__}.hold_s", f"{self.hold_s:g} s", longest)

    @property
    def gate_tolerance(self) -> float:
        """Relative tolerance of the force."""
        return fair_tolerance(self.force_n) if self.tolerance is None else self.tolerance

    @property
    def _gate(self) -> tuple[float, float, float, float, float]:
        """Return the conditions in the argument order of a request."""
        return self.duration_s, self.force_n, self.gate_tolerance, self.hold_s, self.timeout_s


@dataclass(frozen=True)
class Pressing(GatedTouch):
    """Finger that rests."""

    def request(self, stimulus: str, level: float | None, interval: int | None) -> Press:
        return Press(stimulus, level, *self._gate, interval)


@dataclass(frozen=True)
class Sliding(GatedTouch):
    """Finger that follows a cursor.

    The cursor moves out and back over `length_m` at `speed_m_per_s`. The speed is gated within `speed_tolerance`
    (relative; None: not gated).

    - `speed_m_per_s`: Speed that the participant is asked to keep.
    - `length_m`: Length of the path, out and back.
    - `speed_tolerance`: Largest relative deviation of the speed. Without it the speed is not gated.
    """

    speed_m_per_s: Positive = field(kw_only=True)
    length_m: Positive = TRAJECTORY_M
    speed_tolerance: Positive | None = None

    def request(self, stimulus: str, level: float | None, interval: int | None) -> Slide:
        path = self.speed_m_per_s, interval, self.length_m, self.speed_tolerance
        return Slide(stimulus, level, *self._gate, *path)


def feel_in_turn(touch: Touch, stimuli: Sequence[str], levels: Sequence[float | None]) -> Course[tuple[Touched, ...]]:
    """Return the touches of intervals 1, 2, ..., up to the first invalid one."""
    touches: list[Touched] = []
    for interval, (stimulus, level) in enumerate(zip(stimuli, levels, strict=True), 1):
        touches.append((yield touch.request(stimulus, level, interval)))
        if not touches[-1].valid:
            break
    return tuple(touches)


def nth(touches: Sequence[Touched], interval: int) -> Touched | None:
    """Return the touch of an interval, or None if there was none."""
    return touches[interval - 1] if interval <= len(touches) else None
