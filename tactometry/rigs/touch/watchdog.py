"""Devices for touches, and supervision of stimuli without a force gate."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from ...devices.outputs.output import LONGEST_WORD_S
from ...devices.sensors.streamed import StreamedSensor
from ...session.answer import Played
from ...session.request import Adjust, Play
from ...signal import FloatArray, Signal
from ..emitter import Emitter
from ..pages.page import Page
from ..pages.presenter import Presenter
from .gated_samples import SILENT_S, Release, Trace
from .trigger import receiving

SILENT = "the force sensor is silent"

Pause = Callable[[str, Callable[[], bool]], None]
"""Function that pauses the session for a reason until a condition is true."""


@dataclass(frozen=True)
class TouchSetup:
    """Screen, output and sensors of a rig.

    - `say`: Prints a phrase, filled in with values, for the experimenter.
    - `force_peak_n`: Force above which nothing plays.
    - `keep_path`: Stores the positions that a texture followed.
    """

    presenter: Presenter
    emitter: Emitter
    sensor: StreamedSensor | None
    position: StreamedSensor | None
    release: Release
    pause: Pause
    say: Callable[..., None]
    force_peak_n: float
    keep_path: Callable[[str, bytes], None]


def silence(sensor: StreamedSensor | None) -> str:
    """Describe a silent force sensor."""
    failure = None if sensor is None else sensor.reader.failure
    return SILENT if failure is None else f"{SILENT} ({failure})"


@contextmanager
def watchdog(setup: TouchSetup) -> Iterator[Callable[[], None]]:
    """Stop the output if the sensor is silent or the force too high.

    This is done in the sensor's thread. Yields a function to call in each frame, which pauses the session until the
    fault is over.
    """
    sensor, force_peak_n = setup.sensor, setup.force_peak_n
    trace, lost, force_n = Trace(), False, 0.0

    def on_samples(times_s: FloatArray, forces_n: FloatArray) -> None:
        nonlocal force_n
        known = np.isfinite(forces_n)
        trace.on_samples(times_s[known], forces_n[known])
        force_n = float(forces_n[known][-1]) if known.any() else force_n

    def wrong() -> str | None:
        if trace.quiet(SILENT_S):
            return silence(sensor)
        return f"the force is above {force_peak_n:g} N" if force_n > force_peak_n else None

    def consider() -> None:
        nonlocal lost
        if wrong() is not None:
            lost = True
            setup.emitter.stop()

    def look() -> None:
        nonlocal lost
        if sensor is not None:
            consider()
        if lost:  # detected in the sensor's thread, paused in the screen's; the fault may be over by now
            setup.pause(wrong() or SILENT, lambda: wrong() is None)
            lost = False

    with receiving(sensor, on_samples, consider):
        yield look


def play_to_end(setup: TouchSetup, request: Play, page: Page, signal: Signal | None) -> Played:
    """Play under a watchdog, and play again after a pause."""
    presenter, emitter = setup.presenter, setup.emitter
    begin_s = presenter.screen.present(page)
    with watchdog(setup) as look:
        while True:
            onset_s = emitter.emit(signal)
            presenter.hold(onset_s + request.duration_s, page, each_frame=look)
            look()  # include events since the last frame
            if presenter.paused_until_s < begin_s:  # not paused since the stimulus began
                break
            begin_s = presenter.screen.present(page)
    digest = emitter.digest(signal) or ""
    return Played(onset_s, emitter.level_delivered(request.level), digest, emitter.n_gaps(signal))


class RepeatedStimulus:
    """Playback of one level again and again, calling `look` each time."""

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
        self._n_before = self.n_gaps(0.0)
        self._n_steps, self._signal = n_steps, signal
        self._end_s = self._emitter.emit(signal) + signal.duration_s

    def n_gaps(self, longest_wait_s: float = LONGEST_WORD_S) -> int | None:
        """Return the gaps in all that was played, or None if they are unknown."""
        now = self._emitter.n_gaps(self._signal, longest_wait_s)
        return self._n_before if now is None else (self._n_before or 0) + now
