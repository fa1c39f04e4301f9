"""With what every touch of a rig is carried out, and whether the finger let go between two of them."""

import math
import threading
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...devices.sensors.reader import FloatArray
from ...devices.sensors.streamed import StreamedSensor
from ...gates.force import ForceGate
from ...safety.limits import FORCE_PEAK_N
from ..emitter import Emitter
from ..pages.presenter import Presenter


class Release:
    """Whether the finger let go between two touches: a sensor that is stuck in its band never does.

    It hears the force all the time; where none is `needed`, it is always given.

    Examples
    --------
    >>> release, gate = Release(), ForceGate(target_n=1.0, tolerance=0.2, hold_s=0.5)
    >>> release.hear(np.array([0.0, 0.1]), np.array([0.1, 1.0]))
    >>> release.given(gate), release.begin(), release.given(gate)
    (True, None, False)
    >>> release.hear(np.array([0.2]), np.array([1.1]))
    >>> release.given(gate)
    False
    """

    def __init__(self, *, needed: bool = True) -> None:
        self._needed = needed
        self._lock = threading.Lock()
        self._low_n, self._high_n = math.inf, -math.inf

    def hear(self, times_s: FloatArray, forces_n: FloatArray) -> None:
        del times_s
        known_n = forces_n[np.isfinite(forces_n)]
        if known_n.size:
            with self._lock:
                self._low_n = min(self._low_n, float(known_n.min()))
                self._high_n = max(self._high_n, float(known_n.max()))

    def begin(self) -> None:
        """A touch is over: what the force did before does not count."""
        with self._lock:
            self._low_n, self._high_n = math.inf, -math.inf

    def given(self, gate: ForceGate) -> bool:
        """Whether the force was out of the band of a gate since then."""
        with self._lock:
            heard = self._low_n <= self._high_n
            # where both extremes are in the band, so was all between them
            stayed = gate.holds(self._low_n) and gate.holds(self._high_n)
            return not self._needed or (heard and not stayed)


Pause = Callable[[str, Callable[[], bool]], None]
"""Pauses the session for a reason, until it is over."""


@dataclass(frozen=True)
class TouchSetup:
    """Screen, output and sensors of a rig; `say` tells the experimenter. Above `force_peak_n` nothing plays."""

    presenter: Presenter
    emitter: Emitter
    sensor: StreamedSensor | None
    position: StreamedSensor | None
    release: Release
    pause: Pause
    say: Callable[[str], None]
    force_peak_n: float = FORCE_PEAK_N
