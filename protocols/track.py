"""A track: a procedure on a condition."""

from collections.abc import Mapping
from dataclasses import dataclass

from tactometry.session.run import Course

from .procedures.procedure import Procedure
from .tasks.task import Alternative
from .tasks.touch import Touch


@dataclass(frozen=True)
class Condition:
    """What stays the same in a track: its factors, the stimulus (by name) and how it is touched."""

    factors: Mapping[str, float | str]
    stimulus: str
    level_unit: str
    touch: Touch
    speed_m_per_s: float | None = None
    alternatives: tuple[Alternative, ...] = ()


@dataclass(frozen=True)
class Track:
    """A procedure on a condition, at the beginning of a block or at its end; `name` tells interleaved ones apart.

    One whose block the session had no time for is not `begun`.
    """

    condition: Condition
    procedure: Procedure
    name: str | None = None
    aborted: bool = False
    begun: bool = True

    @property
    def ending(self) -> str | None:
        if not self.begun:
            return "not begun"
        return "aborted" if self.aborted else self.procedure.ending


PartCourse = Course[tuple[tuple[Track, ...], int]]
"""The course of a part of a session: how its tracks end, and the number of the next trial."""
