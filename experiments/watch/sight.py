"""State of a session, folded over the lines of its journal.

The study supplies what the journal does not contain.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import reduce
from typing import TYPE_CHECKING

from tactometry.records.head import Head
from tactometry.records.journal import Entry, Line
from tactometry.session.event import Event
from tactometry.session.progress import PartAhead, Progress

if TYPE_CHECKING:
    from .plots import Plot


@dataclass(frozen=True)
class Sight:
    """A session as it is seen.

    Parameters
    ----------
    name : str
        Of the journal; empty: there is none yet.
    heads : tuple of Head
        Those of its sittings.
    progress : Progress
    complete : bool
        Whether the journal says that the session is over.
    halted : bool
        Whether its sitting was stopped, and nothing was asked since.
    abandoned : bool
        Whether no process writes the journal any more, though it neither ended nor was stopped.
    written_s : float
        When the journal was written last, s since 1970.
    problem : str
        Why it cannot be read; empty where it can.
    parts : tuple of PartAhead
        What its study plans; empty where that is not known.
    """

    name: str = ""
    heads: tuple[Head, ...] = ()
    progress: Progress = field(default_factory=Progress)
    complete: bool = False
    halted: bool = False
    abandoned: bool = False
    written_s: float = 0.0
    problem: str = ""
    parts: tuple[PartAhead, ...] = ()

    def after(self, lines: Iterable[Line]) -> "Sight":
        """With more lines of the journal."""
        return reduce(_after, lines, self)

    @property
    def head(self) -> Head | None:
        """Head of the present sitting."""
        return self.heads[-1] if self.heads else None

    @property
    def state(self) -> str:
        """State of the session in words.

        >>> Sight().state, Sight("a", complete=True).state, Sight("a", halted=True).state
        ('no session yet', 'over', 'stopped')
        >>> Sight("a", abandoned=True).state
        'ended without closing'
        """
        if self.problem or not self.name:
            return "cannot be read" if self.problem else "no session yet"
        if self.complete:
            return "over"
        if self.halted:
            return "stopped"
        if self.abandoned:
            return "ended without closing"
        return "running" if self.progress.paused is None else "paused"

    @property
    def warning(self) -> str | None:
        """Warning for the experimenter, None once the session is complete."""
        return None if self.complete else self.progress.warning(self.parts)


def _after(sight: Sight, line: Line) -> Sight:
    match line:
        case Head():
            return replace(sight, heads=(*sight.heads, line), halted=False)
        case Entry(request, answer):
            return replace(sight, progress=sight.progress.after(request, answer), halted=False)
        case Event():
            return replace(sight, progress=sight.progress.after_event(line), halted=line.kind == "stop" or sight.halted)
        case _:  # marks on a page that nobody has left yet
            return replace(sight, halted=False)


@dataclass(frozen=True)
class TouchDrawn:
    """The samples of the last touch, or why they can't be read."""

    plots: "tuple[Plot, ...]" = ()
    problem: str = ""


@dataclass(frozen=True)
class Drawn:
    """The curve of the present condition, and the last touch."""

    curve: "Plot | None" = None
    touch: TouchDrawn = field(default_factory=TouchDrawn)
