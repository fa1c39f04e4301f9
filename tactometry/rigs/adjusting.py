"""A level that the participant sets: what an answer changes, and what is felt meanwhile."""

import time
from collections.abc import Callable

from tactometry.request import Adjust
from tactometry.rigs import layout
from tactometry.rigs.emitter import Emitter
from tactometry.rigs.page import Answer


def stepped(request: Adjust, n_steps: int, answer: Answer) -> tuple[int, bool]:
    """The steps from the start that follow an answer, within the bounds, and whether it settles them.

    >>> request = Adjust("tone", start=5.0, step=2.0, low=0.0, high=6.0)
    >>> stepped(request, 0, layout.DOWN), stepped(request, 0, layout.UP), stepped(request, -1, layout.CONFIRM)
    ((-1, False), (0, False), (-1, True))
    """
    if answer == layout.CONFIRM:
        return n_steps, True
    wanted = n_steps + (1 if answer == layout.UP else -1)
    return (wanted if request.low <= request.level(wanted) <= request.high else n_steps), False


def repeated(request: Adjust, emitter: Emitter, look: Callable[[], None]) -> Callable[[int], None]:
    """Plays the level of so many steps again and again; another level begins at once. Each time after a `look`."""
    playing: int | None = None
    end_s = 0.0

    def keep_playing(n_steps: int) -> None:
        nonlocal playing, end_s
        look()
        if n_steps != playing or time.perf_counter() >= end_s:
            signal = emitter.final(request.stimulus, request.level(n_steps))
            emitter.stop()
            playing, end_s = n_steps, emitter.emit(signal) + signal.duration_s

    return keep_playing
