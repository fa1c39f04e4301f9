"""How a stimulus is felt: the conditions on the finger while it plays."""

from dataclasses import dataclass
from typing import Protocol

from tactometry.arguments.require import given, positive
from tactometry.errors import InvalidParameter
from tactometry.session.request import TRAJECTORY_M, Play, Press, Slide


class Touch(Protocol):
    """Makes the request in which a stimulus is felt; `level` None is a blank."""

    def request(self, stimulus: str, level: float | None, interval: int | None) -> Play | Press | Slide: ...


def fair_tolerance(force_n: float) -> float:
    """The relative tolerance that people can keep: 20 % from 0.5 N on, 30 % below (unverified default).

    >>> fair_tolerance(0.5), fair_tolerance(0.2)
    (0.2, 0.3)
    """
    return 0.2 if force_n >= 0.5 else 0.3


def _check(touch: "Pressing | Sliding", **more: float | None) -> None:
    owner = type(touch).__name__
    positive(owner, duration_s=touch.duration_s, force_n=touch.force_n)
    positive(owner, hold_s=touch.hold_s, timeout_s=touch.timeout_s)
    optional = {"tolerance": touch.tolerance, **more}
    positive(owner, **given(optional))
    if touch.hold_s >= touch.timeout_s:
        raise InvalidParameter(
            f"{owner}.hold_s: found {touch.hold_s:g} s, expected less than timeout_s ({touch.timeout_s:g} s): no touch "
            "could ever begin"
        )


@dataclass(frozen=True)
class Pressing:
    """A finger that rests and presses `force_n` within `tolerance` (relative; None: `fair_tolerance`)."""

    duration_s: float
    force_n: float
    hold_s: float
    timeout_s: float
    tolerance: float | None = None

    def __post_init__(self) -> None:
        _check(self)

    def request(self, stimulus: str, level: float | None, interval: int | None) -> Press:
        return Press(
            stimulus,
            level,
            self.duration_s,
            self.force_n,
            fair_tolerance(self.force_n) if self.tolerance is None else self.tolerance,
            self.hold_s,
            self.timeout_s,
            interval,
        )


@dataclass(frozen=True)
class Sliding:
    """A finger that follows a cursor out and back over `length_m` at `speed_m_per_s`, and presses `force_n`.

    Both are gated within a relative tolerance: `tolerance` of the force (None: `fair_tolerance`), `speed_tolerance` of
    the speed (None: not gated).
    """

    duration_s: float
    force_n: float
    hold_s: float
    timeout_s: float
    speed_m_per_s: float
    tolerance: float | None = None
    length_m: float = TRAJECTORY_M
    speed_tolerance: float | None = None

    def __post_init__(self) -> None:
        positive("Sliding", speed_m_per_s=self.speed_m_per_s, length_m=self.length_m)
        _check(self, speed_tolerance=self.speed_tolerance)

    def request(self, stimulus: str, level: float | None, interval: int | None) -> Slide:
        return Slide(
            stimulus,
            level,
            self.duration_s,
            self.force_n,
            fair_tolerance(self.force_n) if self.tolerance is None else self.tolerance,
            self.hold_s,
            self.timeout_s,
            self.speed_m_per_s,
            interval,
            self.length_m,
            self.speed_tolerance,
        )
