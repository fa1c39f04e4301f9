"""One touch of the finger while a stimulus plays, with and without a force sensor."""

import time
from dataclasses import dataclass

from tactometry.devices.force_sensor import ForceSensor
from tactometry.force_gate import VALID_PART, ForceGate
from tactometry.request import Press, Slide, Touched
from tactometry.rigs import layout
from tactometry.rigs.emitter import Emitter
from tactometry.rigs.glide import Glide
from tactometry.rigs.grip import Grip
from tactometry.rigs.page import Page
from tactometry.rigs.stage import Dress, Stage
from tactometry.signal import Signal


def moving_cue(request: Slide, display_height_m: float) -> Dress:
    """Adds a cue that goes out and back along the path of a slide, at its speed."""
    begin_s = time.perf_counter()
    length = request.length_m / display_height_m

    def dressed(page: Page, now_s: float) -> Page:
        phase = (now_s - begin_s) * request.speed_m_per_s / request.length_m
        return layout.track_page(page, layout.sweep(phase), length)

    return dressed


@dataclass(frozen=True)
class Touch:
    """A request to press or slide, with what carries it out; `onset_s` is on `time.perf_counter`."""

    request: Press | Slide
    stage: Stage
    emitter: Emitter
    words: str
    dress: Dress
    glide: Glide | None = None

    def unmeasured(self, signal: Signal | None) -> Touched:
        """Trust the finger: show when to be ready for `hold_s`, then play."""
        ready, playing = (
            layout.marker_page(self.request.interval, playing=on, words=self.words) for on in (False, True)
        )
        begin_s = self._present(ready)
        self.stage.hold(begin_s + self.request.hold_s, ready, self.dress)
        self._present(playing)
        onset_s = self.emitter.emit(signal)
        self.stage.hold(onset_s + self.request.duration_s, playing, self.dress)
        return Touched(onset_s, self.request.level, _digest(signal))

    def held(self, signal: Signal | None, sensor: ForceSensor) -> Touched:
        """Play once the force is held in motion, and stop at once when the finger stops or leaves, or a sensor is lost.

        A sensor that says nothing before the stimulus is waited for: the time limit counts while it speaks.
        """
        request = self.request
        gate = ForceGate(request.target_n, request.tolerance, request.hold_s)
        begin_s = time.perf_counter()
        grip = Grip(sensor, gate, begin_s)
        self._present(self._bar(grip, playing=False))
        while not (grip.open and self._moving):
            now_s = time.perf_counter()
            begin_s = now_s if grip.silent(now_s) else begin_s
            if now_s > begin_s + request.timeout_s:
                return Touched(now_s, None, None, valid=False)
            self._watch(grip, playing=False)
        self._present(self._bar(grip, playing=True))
        onset_s = self.emitter.emit(signal)
        lost = self._lost_before(onset_s + request.duration_s, grip)
        self.emitter.stop()
        return self._judged(signal, grip, onset_s, lost=lost)

    def _lost_before(self, end_s: float, grip: Grip) -> bool:
        while time.perf_counter() < end_s:
            self._watch(grip, playing=True)
            if grip.lost(time.perf_counter()) or self._stopped:
                return True
        return False

    @property
    def _moving(self) -> bool:
        return self.glide is None or self.glide.open

    @property
    def _stopped(self) -> bool:
        return self.glide is not None and self.glide.stopped(time.perf_counter())

    def _kept_speed(self, onset_s: float) -> bool:
        if self.glide is None:
            return True
        self.glide.read()
        in_band = self.glide.in_band(onset_s, onset_s + self.request.duration_s)
        return in_band is not None and in_band >= VALID_PART

    def _watch(self, grip: Grip, *, playing: bool) -> None:
        self.stage.frame(self.dress(self._bar(grip, playing=playing), time.perf_counter()))
        grip.read()
        if self.glide is not None:
            self.glide.read()

    def _present(self, page: Page) -> float:
        return self.stage.present(self.dress(page, time.perf_counter()))

    def _bar(self, grip: Grip, *, playing: bool) -> Page:
        request = self.request
        marker = layout.marker_page(request.interval, playing=playing, words=self.words)
        return layout.force_page(marker, grip.force_n, request.target_n, request.tolerance)

    def _judged(self, signal: Signal | None, grip: Grip, onset_s: float, *, lost: bool) -> Touched:
        held = grip.compliance(onset_s, onset_s + self.request.duration_s)
        return Touched(
            onset_s=onset_s,
            level_delivered=self.request.level,
            digest=_digest(signal),
            force_mean_n=None if held is None else held.mean_n,
            force_sd_n=None if held is None else held.sd_n,
            force_in_band=None if held is None else held.in_band,
            valid=not lost and held is not None and held.in_band >= VALID_PART and self._kept_speed(onset_s),
        )


def _digest(signal: Signal | None) -> str | None:
    return None if signal is None else signal.digest()
