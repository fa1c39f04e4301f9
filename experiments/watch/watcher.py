"""Read-only follower of a data set's newest journal."""

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import reduce
from pathlib import Path
from typing import TYPE_CHECKING

from tactometry.errors import InvalidFile, TactometryError
from tactometry.files.durable import read_file
from tactometry.records.data_set import keys_of, sessions
from tactometry.records.following import Follower
from tactometry.records.head import Head
from tactometry.records.journal import Entry, Line
from tactometry.records.open_journal import is_written
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


LOOK_AROUND_S = 3.0
"""Interval (s) between searches for a newer journal."""
QUIET_S = 10.0
"""Time (s) after a write during which a journal counts as being recorded."""
TRY_AGAIN_S = 15.0
"""Delay (s) before an unreadable journal is read again from its start, which is slow."""


class Watcher:
    """Follower of a data set's newest journal, or that of one session.

    The folder `root` need not exist yet. `clock` returns monotonic time (s).
    """

    def __init__(
        self,
        root: Path,
        participant: str | None = None,
        session: int | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.root, self._clock = root, clock
        requested = {"participant": participant, "session": None if session is None else str(session)}
        self._wanted = {key: value for key, value in requested.items() if value is not None}
        self._follower: Follower | None = None
        self._sight = Sight()
        self._around_s = self._again_s = self._alive_s = -float("inf")

    def look(self) -> Sight:
        """Return the current state, the same object until something changes."""
        now_s = self._clock()
        if now_s >= self._around_s:
            self._around_s = now_s + LOOK_AROUND_S
            self._choose()
        if self._follower is not None and now_s >= self._again_s:
            self._read(self._follower, now_s)
        if self._follower is not None and now_s >= self._alive_s:
            self._alive_s = now_s + LOOK_AROUND_S
            sight = self._sight
            is_quiet = time.time() - sight.written_s > QUIET_S
            ended = sight.complete or sight.halted or not sight.name
            abandoned = not ended and is_quiet and not is_written(self._follower.path)
            if abandoned != sight.abandoned:
                self._sight = replace(sight, abandoned=abandoned)
        return self._sight

    @property
    def finds(self) -> bool:
        """Return True if there is a session to follow."""
        return bool(self._journals())

    def _journals(self) -> list[Path]:
        try:
            return [path for path in sessions(self.root) if self._wanted.items() <= keys_of(path.stem).items()]
        except InvalidFile:  # a later search may succeed
            return []

    def _choose(self) -> None:
        newest = max(self._journals(), key=_written_s, default=None)
        if newest is not None and (self._follower is None or newest != self._follower.path):
            self._follower, self._sight, self._again_s = Follower(newest), Sight(newest.stem), -float("inf")

    def _read(self, follower: Follower, now_s: float) -> None:
        try:
            news = follower.news()
        except InvalidFile as error:
            self._again_s = now_s + TRY_AGAIN_S
            self._sight = replace(self._sight, problem=str(error))
            return
        if news is None:
            return
        before = Sight(self._sight.name) if news.anew else self._sight
        seen = before.after(news.lines)
        parts = before.parts or _parts(self.root, seen.head)
        written_s = _written_s(follower.path)
        self._sight = replace(seen, complete=news.complete, abandoned=False, written_s=written_s, parts=parts)


def _written_s(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except OSError:  # the file was removed meanwhile
        return 0.0


def _parts(root: Path, head: Head | None) -> tuple[PartAhead, ...]:
    """Return the planned parts of a session.

    Empty if the study cannot be wired, so that the page can still show the rest.
    """
    if head is None:
        return ()
    from ..study.dry_run import parts_ahead
    from ..study.experiment import wire
    from ..study.study_file import parse

    path = root / "study.toml"
    try:
        experiment = wire(parse(read_file(path, "the study that ran"), str(path)), str(path), plays=False)
        return parts_ahead(experiment, head.number, head.session, head.seed)
    except TactometryError:
        return ()
