"""A level that the participant sets: what an answer changes, and what is felt meanwhile."""

import time
from collections.abc import Callable

from ..devices.outputs.output import LONGEST_WORD_S
from ..session.request import Adjust
from ..signal import Signal
from .emitter import Emitter
from .pages import layout
from .pages.page import Answer


def after(request: Adjust, n_steps: int, answer: Answer) -> tuple[int, bool]:
    """The steps from the start that follow an answer, within the bounds, and whether it settles them.

    >>> request = Adjust("tone", start=5.0, step=2.0, low=0.0, high=6.0)
    >>> after(request, 0, layout.DOWN), after(request, 0, layout.UP), after(request, -1, layout.CONFIRM)
    ((-1, False), (0, False), (-1, True))
    """
    if answer == layout.CONFIRM:
        return n_steps, True
    wanted = n_steps + (1 if answer == layout.UP else -1)
    return (wanted if request.low <= request.level(wanted) <= request.high else n_steps), False


class RepeatedStimulus:
    """Plays the level of so many steps again and again; another level begins at once. Each time after a `look`."""

    def __init__(self, request: Adjust, emitter: Emitter, look: Callable[[], None]) -> None:
        self._request, self._emitter, self._look = request, emitter, look
        self._signal: Signal | None = None
        self._n_steps: int | None = None
        self._n_before: int | None = None
        self._end_s = 0.0

    def keep_playing(self, n_steps: int) -> None:
        self._look()
        if n_steps == self._n_steps and time.perf_counter() < self._end_s:
            return
        signal = self._emitter.final(self._request.stimulus, self._request.level(n_steps))
        self._emitter.stop()
        self._n_before = self._counted(0.0)
        self._n_steps, self._signal = n_steps, signal
        self._end_s = self._emitter.emit(signal) + signal.duration_s

    def _counted(self, longest_wait_s: float) -> int | None:
        """Gaps up to now; those of the signal that plays are the output's."""
        now = self._emitter.n_gaps(self._signal, longest_wait_s)
        return self._n_before if now is None else (self._n_before or 0) + now

    @property
    def n_gaps(self) -> int | None:
        """Gaps in all that was played; None where the output cannot tell."""
        return self._counted(LONGEST_WORD_S)
