"""State of a session, accumulated from the lines of its journal."""

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
    """State of a session, as shown on the page.

    - `name`: Name of the journal, or empty if none exists yet.
    - `heads`: Heads of the sittings (parts of the session).
    - `complete`, `halted`: True if the journal states that the session is over, or that its sitting was stopped.
    - `abandoned`: True if no process writes the journal any more, although the session neither ended nor was stopped.
    - `written_s`: Time of the last write to the journal (s since 1970).
    - `problem`: Reason why the journal cannot be read, or an empty text.
    - `parts`: Planned parts of the session, which the journal does not contain. Empty if unknown.
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
        """Return the state after more lines of the journal."""
        return reduce(_after, lines, self)

    @property
    def head(self) -> Head | None:
        """Head of the current sitting."""
        return self.heads[-1] if self.heads else None

    @property
    def state(self) -> str:
        """State of the session in words.

        >>> Sight().state, Sight("a", complete=True).state, Sight("a", halted=True).state
        ('no session yet', 'over', 'stopped')
        >>> Sight("a", abandoned=True).state
        'ended without closing'
        """
        states = {
            "cannot be read": bool(self.problem),
            "no session yet": not self.name,
            "over": self.complete,
            "stopped": self.halted,
            "ended without closing": self.abandoned,
            "paused": self.progress.paused is not None,
        }
        return next((state for state, applies in states.items() if applies), "running")


def _after(sight: Sight, line: Line) -> Sight:
    match line:
        case Head():
            return replace(sight, heads=(*sight.heads, line), halted=False)
        case Entry(request, answer):
            return replace(sight, progress=sight.progress.after(request, answer), halted=False)
        case Event():
            return replace(sight, progress=sight.progress.after_event(line), halted=line.kind == "stop" or sight.halted)
        case _:  # marks made while a page is shown
            return replace(sight, halted=False)


@dataclass(frozen=True)
class TouchDrawn:
    """Plots of the last touch, or the reason for their absence."""

    plots: "tuple[Plot, ...]" = ()
    problem: str = ""


@dataclass(frozen=True)
class Drawn:
    """Plots of the current condition's curve and of the last touch."""

    curve: "Plot | None" = None
    touch: TouchDrawn = field(default_factory=TouchDrawn)
