"""Where the session stands, in one line, and what is to be said before a track is aborted."""

import math
from collections.abc import Sequence
from typing import Any

from ...errors import count_of
from ...session.event import Event
from ...session.progress import PartAhead, Progress
from ...session.request import Request
from ...trials.cells import cell
from .terminal import ExperimenterTerminal


def status_words(progress: Progress, parts: Sequence[PartAhead]) -> str:
    """The line, what matters most first: a narrow terminal cuts its end.

    >>> status_words(Progress(), [PartAhead(n_trials=20, lasts_s=100.0)])
    'trial 1 of 20 · 2 min left · 0 false alarms of 0 · 0 frames dropped · 0 gaps'
    """
    n_trials = sum(part.n_trials for part in parts)
    n_next = min(progress.n_valid() + 1, max(n_trials, 1))
    n_aborted = len(progress.aborted)
    phrases = [
        "over" if progress.over else f"trial {n_next} of {n_trials}",
        f"{math.ceil(progress.left_s(parts) / 60)} min left",
        f"{n_aborted} aborted" if n_aborted else "",
        ", ".join(f"{name} {cell(level)}" for name, level in progress.factors.items()),
        *_track_words(progress),
        f"{count_of(progress.n_false_alarms, 'false alarm')} of {progress.n_catch}",
        f"{count_of(progress.n_dropped_frames, 'frame')} dropped",
        count_of(progress.n_gaps, "gap"),
    ]
    return " · ".join(filter(None, phrases))


def _track_words(progress: Progress) -> list[str]:
    track, last = progress.track, progress.last
    if track is None or last is None:
        return []
    level = "blank" if last.level is None else f"{last.level:g} {last.level_unit}"
    return [] if last.is_form else [f"last {level}", count_of(len(track.reversals), "reversal")]


class StatusLine:
    """Follows a session, and shows on a terminal where it stands."""

    def __init__(self, terminal: ExperimenterTerminal, parts: Sequence[PartAhead]) -> None:
        self._terminal, self._parts, self._progress = terminal, parts, Progress()
        self._warned: str | None = None
        self._show(Progress())

    def hear(self, request: Request[Any], answer: object) -> None:
        self._show(self._progress.after(request, answer))

    def hear_event(self, event: Event) -> None:
        self._show(self._progress.after_event(event))

    def _show(self, progress: Progress) -> None:
        self._progress = progress
        self._terminal.status(status_words(progress, self._parts))
        warning = progress.warning(self._parts)
        if warning is not None and warning != self._warned:
            self._terminal.tell(f"! {warning}")
        self._warned = warning
