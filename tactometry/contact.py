"""How a finger meets the surface."""

from dataclasses import dataclass

from .errors import InvalidParameter


@dataclass(frozen=True)
class Contact:
    """A finger that presses with `force_n` (N, at least 0) and slides at `speed_m_per_s` (m/s, 0 at rest)."""

    force_n: float
    speed_m_per_s: float = 0.0

    def __post_init__(self) -> None:
        for name in ("force_n", "speed_m_per_s"):
            value = getattr(self, name)
            if not 0 <= value < float("inf"):
                raise InvalidParameter(f"Contact.{name}: found {value}, expected a finite number, at least 0")
