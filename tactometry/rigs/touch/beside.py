"""A stimulus that plays while somebody else draws and looks at the time."""

import time
from collections.abc import Callable
from contextlib import ExitStack

from ...session.answer import Played
from ...session.request import Play
from ...signal import Signal
from .watchdog import TouchSetup, watchdog


class Beside:
    """Begins with the object, under the eyes of the force sensor.

    Parameters
    ----------
    setup : TouchSetup
    request : Play
    signal : Signal or None
        None for a blank.
    give_back : callable
        Gives the screen back after a page that a pause needs.
    """

    def __init__(self, setup: TouchSetup, request: Play, signal: Signal | None, give_back: Callable[[], None]) -> None:
        self._setup, self._request, self._signal, self._give_back = setup, request, signal, give_back
        self._watched = ExitStack()
        self._look = self._watched.enter_context(watchdog(setup))
        self._onset_s = setup.emitter.emit(signal)

    @property
    def cut(self) -> bool:
        """Whether a pause cut it short; nothing plays again by itself."""
        return self._setup.presenter.paused_until_s > self._onset_s

    def look(self) -> bool:
        """In each frame: whether it plays on. What the sensor must not say (silence, too much force) pauses here."""
        try:
            self._look()
        finally:
            self._give_back()
        return not self.cut and time.perf_counter() < self._onset_s + self._request.duration_s

    def end(self) -> Played:
        """Zero now, and what was played (its onset on `time.perf_counter`)."""
        emitter = self._setup.emitter
        n_gaps = emitter.n_gaps(self._signal)
        emitter.stop()
        self._watched.close()
        delivered = None if self.cut else emitter.level_delivered(self._request.level)
        return Played(self._onset_s, delivered, emitter.digest(self._signal) or "", n_gaps)
