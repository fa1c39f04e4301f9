"""With what every touch of a rig is carried out."""

from collections.abc import Callable
from dataclasses import dataclass

from ...devices.sensors.streamed import StreamedSensor
from ...safety.limits import FORCE_PEAK_N
from ..emitter import Emitter
from ..pages.presenter import Presenter
from .release import Release

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
