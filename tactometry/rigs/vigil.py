"""What plays without a gate of force, under the eyes of the force sensor all the same."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from tactometry.devices.force_sensor import ForceSensor
from tactometry.devices.reader import FloatArray
from tactometry.rigs.grip import SILENT_S
from tactometry.rigs.trace import Trace
from tactometry.rigs.trigger import hearing

SILENT = "the force sensor is silent"
Pause = Callable[[str, Callable[[], bool]], None]
"""Pauses the session for a reason, until it is over."""


@contextmanager
def vigil(sensor: ForceSensor | None, stop: Callable[[], None], pause: Pause) -> Iterator[Callable[[], None]]:
    """Until the block ends, `stop` is called in the sensor's thread when that has said nothing for `SILENT_S`.

    The value is for each frame: it pauses the session where that happened, until the sensor speaks again.
    """
    trace, lost = Trace(), False

    def hear(times_s: FloatArray, forces_n: FloatArray) -> None:
        known = np.isfinite(forces_n)
        trace.hear(times_s[known], forces_n[known])

    def consider() -> None:
        nonlocal lost
        if trace.quiet(SILENT_S):
            lost = True
            stop()

    def look() -> None:
        nonlocal lost
        if sensor is not None:
            consider()
        if lost:
            pause(SILENT, lambda: not trace.quiet(SILENT_S))
            lost = False

    with hearing(sensor, hear, consider):
        yield look
