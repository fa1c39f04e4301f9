"""Contact of a finger with the surface."""

from dataclasses import dataclass

from .arguments.constraints import NotNegative, constrained


@dataclass(frozen=True)
@constrained
class Contact:
    """Finger with a normal force and a sliding speed."""

    force_n: NotNegative
    speed_m_per_s: NotNegative = 0.0
