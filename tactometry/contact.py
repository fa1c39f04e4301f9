"""Contact of a finger with the surface."""

from dataclasses import dataclass

from .arguments.constraints import NotNegative, constrained


@dataclass(frozen=True)
@constrained
class Contact:
    """A finger that presses with `force_n` (N, at least 0) and slides at `speed_m_per_s` (m/s, 0 at rest)."""

    force_n: NotNegative
    speed_m_per_s: NotNegative = 0.0
