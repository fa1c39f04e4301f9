"""How a finger meets the surface."""

from dataclasses import dataclass

from .arguments.require import not_negative


@dataclass(frozen=True)
class Contact:
    """A finger that presses with `force_n` (N, at least 0) and slides at `speed_m_per_s` (m/s, 0 at rest)."""

    force_n: float
    speed_m_per_s: float = 0.0

    def __post_init__(self) -> None:
        not_negative("Contact", force_n=self.force_n, speed_m_per_s=self.speed_m_per_s)
