"""One touch of the finger while a stimulus plays, with and without a force sensor."""

import math
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field, replace

from tactometry.devices.force_sensor import ForceSensor
from tactometry.devices.position_sensor import PositionSensor
from tactometry.force_gate import VALID_PART, ForceGate
from tactometry.request import Press, Slide, Touched
from tactometry.rigs import layout
from tactometry.rigs.emitter import Emitter
from tactometry.rigs.glide import MOVING_S, Glide
from tactometry.rigs.grip import Grip
from tactometry.rigs.page import Page
from tactometry.rigs.stage import Dress, Stage
from tactometry.rigs.trace import Trace, speed_m_per_s
from tactometry.rigs.trigger import Trigger, hearing, quick_turns
from tactometry.rigs.vigil import SILENT, Pause
from tactometry.signal import Signal
from tactometry.speed_gate import SpeedGate

TOLD_EVERY_S = 1.0


def moving_cue(request: Slide, display_height_m: float, places: Trace) -> Dress:
    """Adds a cue that goes out and back along the path of a slide, at its speed, and the measured finger."""
    begin_s = time.perf_counter()
    length = request.length_m / display_height_m

    def dressed(page: Page, now_s: float) -> Page:
        phase = (now_s - begin_s) * request.speed_m_per_s / request.length_m
        return layout.track_page(page, layout.sweep(phase), length, _finger(places, request.length_m))

    return dressed


def _finger(places: Trace, length_m: float) -> float | None:
    """The place of the finger on its path (-1..1), whose beginning is position 0 on the sensor's first axis."""
    place_m = None if places.last is None else float(places.last[0])
    return None if place_m is None or not math.isfinite(place_m) else 2 * place_m / length_m - 1


class Held:
    """What the sensors of one held touch say: force, and speed where it is gated."""

    def __init__(self, request: Press | Slide, *, moving: bool) -> None:
        self.grip = Grip(ForceGate(request.target_n, request.tolerance, request.hold_s))
        self.glide: Glide | None = None
        if moving and isinstance(request, Slide) and request.speed_tolerance is not None:
            self.glide = Glide(SpeedGate(request.speed_m_per_s, request.speed_tolerance, MOVING_S))

    @property
    def open(self) -> bool:
        return self.grip.open and (self.glide is None or self.glide.open)

    @property
    def opened_s(self) -> float:
        """The stamp of the sample that opened the last gate."""
        stamps_s = (self.grip.opened_s, None if self.glide is None else self.glide.opened_s)
        return max(stamp_s for stamp_s in stamps_s if stamp_s is not None)

    @property
    def lost(self) -> bool:
        """Whether a sensor is silent, or the finger has left or stopped."""
        return self.grip.lost or (self.glide is not None and self.glide.stopped)

    def kept_speed(self, begin_s: float, end_s: float) -> bool:
        if self.glide is None:
            return True
        in_band = self.glide.in_band(begin_s, end_s)
        return in_band is not None and in_band >= VALID_PART


@dataclass(frozen=True)
class Felt:
    """What came of a touch (its onset on `time.perf_counter`), and how late the gate's decision was, s."""

    touched: Touched
    gate_delay_s: float | None = None


@dataclass(frozen=True)
class Touch:
    """A request to press or slide, with what carries it out.

    `pause` is called with a reason and what tells that it is over; `say` tells the experimenter.
    """

    request: Press | Slide
    stage: Stage
    emitter: Emitter
    words: str
    dress: Dress
    sensor: ForceSensor | None
    position: PositionSensor | None
    pause: Pause
    say: Callable[[str], None]
    places: Trace = field(default_factory=Trace)

    def felt(self, signal: Signal | None) -> Felt:
        """Carry out the request; a touch whose stimulus was cut short by a pause is not valid."""
        with hearing(self.position, self.places.hear):
            felt = self._unmeasured(signal) if self.sensor is None else self._held(signal, self.sensor)
        touched = felt.touched
        speed = speed_m_per_s(self.places, touched.onset_s, touched.onset_s + self.request.duration_s)
        return replace(felt, touched=replace(touched, speed_mean_m_per_s=speed))

    def _unmeasured(self, signal: Signal | None) -> Felt:
        """Trust the finger: show when to be ready for `hold_s`, then play."""
        ready, playing = (
            layout.marker_page(self.request.interval, playing=on, words=self.words) for on in (False, True)
        )
        begin_s = self._present(ready)
        self.stage.hold(begin_s + self.request.hold_s, ready, self.dress)
        begin_s = self._present(playing)
        onset_s = self.emitter.emit(signal)
        self.stage.hold(onset_s + self.request.duration_s, playing, self.dress)
        whole = self.stage.paused_until_s < begin_s
        return Felt(Touched(onset_s, self.request.level, _digest(signal), valid=whole))

    def _held(self, signal: Signal | None, sensor: ForceSensor) -> Felt:
        """Play once the force is held in motion, and stop when the finger stops or leaves, or a sensor is lost.

        The threads of the sensors decide; here it is shown what they hear.
        """
        held = Held(self.request, moving=self.position is not None)
        trigger = Trigger(
            lambda: held.open, lambda: held.lost, lambda: self.emitter.emit_if_allowed(signal), self.emitter.stop
        )
        with ExitStack() as last_first:
            last_first.enter_context(quick_turns())
            last_first.enter_context(hearing(sensor, held.grip.hear, trigger.consider))
            if held.glide is not None:
                last_first.enter_context(hearing(self.position, held.glide.hear, trigger.consider))
            last_first.callback(trigger.disarm)
            begun = self._begun(held, trigger)
            if begun is None:
                return Felt(Touched(time.perf_counter(), None, None, valid=False))
            whole = self._whole(held, trigger, *begun)
        self.emitter.stop()
        decided_s, onset_s = begun
        touched = self._judged(signal, held, onset_s, whole=whole)
        mean = "no force" if touched.force_mean_n is None else f"{touched.force_mean_n:.2f} N"
        self.say(f"played, {mean}{'' if touched.valid else ', not valid'}")
        return Felt(touched, decided_s - held.opened_s)

    def _begun(self, held: Held, trigger: Trigger) -> tuple[float, float] | None:
        """Show the force until the stimulus begins: when that was decided, and the onset; None if it came too late.

        A silent sensor pauses the session; no time counts in a pause.
        """
        begin_s = said_s = self._present(self._bar(held, playing=False))
        while trigger.begun is None:
            said_s = self._said(held, said_s)
            if held.grip.silent:
                self.pause(SILENT, lambda: not held.grip.silent)
            if time.perf_counter() > max(begin_s, self.stage.paused_until_s) + self.request.timeout_s:
                trigger.disarm()
                break
            self._frame(held, playing=False)
        return trigger.begun

    def _said(self, held: Held, said_s: float) -> float:
        """Tell the experimenter the force, once in a while: when it was told last."""
        now_s, force_n = time.perf_counter(), held.grip.force_n
        if now_s < said_s + TOLD_EVERY_S or force_n is None:
            return said_s
        self.say(f"{force_n:.2f} N")
        return now_s

    def _whole(self, held: Held, trigger: Trigger, decided_s: float, onset_s: float) -> bool:
        """Show the force while the stimulus plays: whether it played to its end."""
        self._present(self._bar(held, playing=True))
        while time.perf_counter() < onset_s + self.request.duration_s:
            trigger.consider()
            if trigger.broken or self.stage.paused_until_s > decided_s:
                return False
            self._frame(held, playing=True)
        return not trigger.broken and self.stage.paused_until_s < decided_s

    def _frame(self, held: Held, *, playing: bool) -> None:
        self.stage.frame(self.dress(self._bar(held, playing=playing), time.perf_counter()))

    def _present(self, page: Page) -> float:
        return self.stage.present(self.dress(page, time.perf_counter()))

    def _bar(self, held: Held, *, playing: bool) -> Page:
        request = self.request
        marker = layout.marker_page(request.interval, playing=playing, words=self.words)
        return layout.force_page(marker, held.grip.force_n, request.target_n, request.tolerance)

    def _judged(self, signal: Signal | None, held: Held, onset_s: float, *, whole: bool) -> Touched:
        during_s = onset_s, onset_s + self.request.duration_s
        kept = held.grip.compliance(*during_s)
        return Touched(
            onset_s=onset_s,
            level_delivered=self.request.level,
            digest=_digest(signal),
            force_mean_n=None if kept is None else kept.mean_n,
            force_sd_n=None if kept is None else kept.sd_n,
            force_in_band=None if kept is None else kept.in_band,
            valid=whole and kept is not None and kept.in_band >= VALID_PART and held.kept_speed(*during_s),
        )


def _digest(signal: Signal | None) -> str | None:
    return None if signal is None else signal.digest()
