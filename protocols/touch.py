"""How a stimulus is felt: the conditions on the finger while it plays."""

from dataclasses import dataclass
from typing import Protocol

from tactometry.errors import InvalidParameter
from tactometry.request import Play, Press, Slide


class Touch(Protocol):
    """Makes the request in which a stimulus is felt; `level` None is a blank."""

    def request(self, stimulus: str, level: float | None, interval: int | None) -> Play | Press | Slide: ...


def _check(touch: object, names: tuple[str, ...]) -> None:
    for name in names:
        value = getattr(touch, name)
        if not 0 < value < float("inf"):
            raise InvalidParameter(f"{type(touch).__name__}.{name}: found {value}, expected a finite number above 0")


@dataclass(frozen=True)
class Pressing:
    """A finger that rests and presses `force_n` within `tolerance` (relative)."""

    duration_s: float
    force_n: float
    tolerance: float
    hold_s: float
    timeout_s: float

    def __post_init__(self) -> None:
        _check(self, ("duration_s", "force_n", "tolerance", "hold_s", "timeout_s"))

    def request(self, stimulus: str, level: float | None, interval: int | None) -> Press:
        return Press(
            stimulus,
            level,
            self.duration_s,
            self.force_n,
            self.tolerance,
            self.hold_s,
            self.timeout_s,
            interval,
        )


@dataclass(frozen=True)
class Sliding:
    """A finger that slides at `speed_m_per_s` and presses `force_n` within `tolerance` (relative)."""

    duration_s: float
    force_n: float
    tolerance: float
    hold_s: float
    timeout_s: float
    speed_m_per_s: float

    def __post_init__(self) -> None:
        _check(self, ("duration_s", "force_n", "tolerance", "hold_s", "timeout_s", "speed_m_per_s"))

    def request(self, stimulus: str, level: float | None, interval: int | None) -> Slide:
        return Slide(
            stimulus,
            level,
            self.duration_s,
            self.force_n,
            self.tolerance,
            self.hold_s,
            self.timeout_s,
            self.speed_m_per_s,
            interval,
        )
