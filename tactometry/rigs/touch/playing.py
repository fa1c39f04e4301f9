"""A stimulus that only plays, without a condition on the finger."""

from collections.abc import Callable
from dataclasses import dataclass

from ...devices.sensors.force_sensor import ForceSensor
from ...session.answer import Played
from ...session.request import Play
from ...signal import Signal
from ..emitter import Emitter
from ..pages.page import Page
from ..pages.presenter import Presenter
from .watchdog import Pause, vigil


@dataclass(frozen=True)
class Playing:
    """What carries it out: a silent force sensor, or one that says too much, stops it and pauses the session."""

    stage: Presenter
    emitter: Emitter
    page: Page
    sensor: ForceSensor | None
    pause: Pause
    force_peak_n: float
    session_s: Callable[[float], float]
    """The time of the session at a moment on `time.perf_counter`."""

    def played(self, request: Play, signal: Signal | None) -> Played:
        """Play to the end; after a pause it begins anew."""
        begin_s = self.stage.present(self.page)
        with vigil(self.sensor, self.emitter.stop, self.pause, self.force_peak_n) as look:
            while True:
                onset_s = self.emitter.emit(signal)
                self.stage.hold(onset_s + request.duration_s, self.page, each_frame=look)
                look()  # what happened since the last frame counts too
                if self.stage.paused_until_s < begin_s:  # no pause since it began
                    break
                begin_s = self.stage.present(self.page)
        digest = self.emitter.digest(signal) or ""
        level = self.emitter.delivered(request.level)
        return Played(self.session_s(onset_s), level, digest, self.emitter.n_gaps(signal))
