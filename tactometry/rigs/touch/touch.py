"""Touches during a stimulus, with or without a force sensor."""

import math
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...devices.sensors.streamed import StreamedSensor
from ...gates import VALID_PART, ForceGate, SpeedGate
from ...position_dependent import HELD_S, PlayedPath, path_lines
from ...provenance import digest_of
from ...safety.limits import FORCE_PEAK_N
from ...session.answer import Played, Touched
from ...session.request import Play, Press, Slide
from ...signal import Signal
from ...trials.trial import Reason
from ..pages import layout
from ..pages.page import Page
from ..pages.presenter import Dress, as_it_is
from ..touch_validity import broken_condition, compliance_fields
from .gated_samples import MOVING_S, AppliedForce, FingerMotion, Release, Trace
from .trigger import Trigger, quick_turns, receiving
from .watchdog import TouchSetup, silence, watchdog

TOLD_EVERY_S = 1.0


def moving_cue(request: Slide, display_height_m: float, places: Trace) -> Dress:
    """Add a cue that moves like the requested slide, and the measured finger."""
    begin_s = time.perf_counter()
    length = request.length_m / display_height_m

    def with_track(page: Page, now_s: float) -> Page:
        phase = (now_s - begin_s) * request.speed_m_per_s / request.length_m
        place_m = math.nan if places.last is None else float(places.last[0])  # the path begins at 0
        finger = 2 * place_m / request.length_m - 1 if math.isfinite(place_m) else None
        return layout.track_page(page, layout.sweep(phase), length, finger)

    return with_track


class Held:
    """State of the sensors during a touch: force, and speed if gated."""

    def __init__(
        self,
        request: Press | Slide,
        *,
        moving: bool,
        force_peak_n: float = FORCE_PEAK_N,
        release: Release | None = None,
    ) -> None:
        self.applied_force = AppliedForce(ForceGate(request.target_n, request.tolerance, request.hold_s), force_peak_n)
        self.release = Release(needed=False) if release is None else release
        self.finger_motion: FingerMotion | None = None
        self.let_through_s = 0.0
        """Time stamp of the sample that opened the last gate when the stimulus began."""
        self.loss: Reason | None = None
        if moving and isinstance(request, Slide) and request.speed_tolerance is not None:
            self.finger_motion = FingerMotion(SpeedGate(request.speed_m_per_s, request.speed_tolerance, MOVING_S))
        self._gated = [samples for samples in (self.applied_force, self.finger_motion) if samples is not None]

    @property
    def open(self) -> bool:
        return all(samples.open for samples in self._gated) and self.released

    @property
    def released(self) -> bool:
        return self.release.happened(self.applied_force.gate)

    @property
    def opened_s(self) -> float:
        return max(samples.opened_s for samples in self._gated if samples.opened_s is not None)

    @property
    def missed(self) -> Reason:
        """Return the reason for a timeout.

        A missing position while the force is in its band counts as a lost sensor.
        """
        placeless = self.finger_motion is not None and self.finger_motion.silent and self.applied_force.gate.open
        return "sensor_lost" if placeless else "timeout"

    def fire(self, fire: Callable[[], float | None]) -> float | None:
        """Begin playback and store the time stamp that opened the gate."""
        self.let_through_s = self.opened_s
        return fire()

    def breaks(self) -> bool:
        """Return True if playback must stop, and set `loss` to the reason."""
        self.loss = next((samples.loss for samples in self._gated if samples.loss), None)
        return self.loss is not None

    def delay_s(self, decided_s: float) -> float:
        """Return the time from the sample that opened the gate to the decision."""
        return max(0.0, decided_s - self.let_through_s)


@dataclass(frozen=True)
class TouchRun:
    """Procedure that carries out a request to press or slide.

    `places` receives the positions. `why` is the message that explains why the last touch was invalid. A pause or
    the sensors may cut a stimulus short.
    """

    request: Press | Slide
    setup: TouchSetup
    places: Trace
    words: str = ""
    release_words: str = ""
    dress: Dress = as_it_is
    why: str = ""

    def carry_out(self, signal: Signal | None) -> tuple[Touched, float | None]:
        """Return the answer (onset on `time.perf_counter`) and the gate's delay, s."""
        sensor = self.setup.sensor
        with receiving(self.setup.position, self.places.on_samples):
            touched, delay_s = (
                (self._play_ungated(signal), None) if sensor is None else self._play_gated(signal, sensor)
            )
        speed = self.places.mean_speed_m_per_s(touched.onset_s, touched.onset_s + self.request.duration_s)
        return replace(touched, speed_mean_m_per_s=None if speed is None else round(speed, 6)), delay_s

    def _play_ungated(self, signal: Signal | None) -> Touched:
        """Announce the stimulus for `hold_s`, then play it without a force condition."""
        ready, playing = (
            layout.marker_page(self.request.interval, playing=on, words=self.words, why="" if on else self.why)
            for on in (False, True)
        )
        begin_s = self._present(ready)
        self.setup.presenter.hold(begin_s + self.request.hold_s, ready, self.dress)
        begin_s = self._present(playing)
        onset_s = self.setup.emitter.emit(signal)
        self.setup.presenter.hold(onset_s + self.request.duration_s, playing, self.dress)
        n_gaps = self.setup.emitter.n_gaps(signal)
        reason: Reason | None = "output_gap" if n_gaps else None
        if self.setup.presenter.paused_until_s >= begin_s:
            reason = "experimenter"
        return self._answer(signal, onset_s, reason, n_gaps)

    def _answer(
        self, signal: Signal | None, onset_s: float, reason: Reason | None, n_gaps: int | None, **kept: Any
    ) -> Touched:
        path = self.setup.emitter.played_path(signal)
        if path is not None and path.unknown > 1 - VALID_PART:
            reason = reason or "sensor_lost"
        return Touched(
            onset_s,
            self.setup.emitter.level_delivered(self.request.level),
            self.setup.emitter.digest(signal),
            valid=reason is None,
            invalid_reason=reason,
            n_gaps=n_gaps,
            positions_digest=None if path is None else self._positions_digest(onset_s, path),
            positions_late=None if path is None else round(path.late, 6),
            **kept,
        )

    def _positions_digest(self, onset_s: float, path: PlayedPath) -> str:
        """Store the positions that a texture followed and return their digest."""
        begin_s = onset_s - path.latency_s
        times_s, positions_m = self.places.between(begin_s - HELD_S, begin_s + path.signal.duration_s)
        new = np.diff(times_s, prepend=-np.inf) > 0  # the first sample of each time stamp, as the texture used it
        along_m = positions_m[:, 0] if positions_m.ndim == 2 else positions_m
        lines = path_lines(times_s[new] - begin_s, along_m[new])
        digest = digest_of(lines)
        self.setup.keep_path(digest, lines)
        return digest

    def _play_gated(self, signal: Signal | None, sensor: StreamedSensor) -> tuple[Touched, float | None]:
        """Play once the force and motion of the finger are in their bands.

        Playback stops when the finger stops or leaves, or a sensor is lost. The sensors' threads decide this; this
        thread only draws.
        """
        setup, moving = self.setup, self.setup.position is not None
        held = Held(self.request, moving=moving, force_peak_n=setup.force_peak_n, release=setup.release)
        trigger = Trigger(
            lambda: held.open,
            held.breaks,
            lambda: held.fire(lambda: self.setup.emitter.emit_if_allowed(signal)),
            self.setup.emitter.stop,
        )
        with ExitStack() as last_first:
            last_first.enter_context(quick_turns())
            last_first.enter_context(receiving(sensor, held.applied_force.on_samples, trigger.consider))
            if held.finger_motion is not None:
                last_first.enter_context(
                    receiving(self.setup.position, held.finger_motion.on_samples, trigger.consider)
                )
            last_first.callback(trigger.disarm)  # disarmed first on any exit, so that nothing starts afterwards
            begun = self._await_begin(held, trigger, sensor)
            if begun is None:
                self.setup.say("not_played")
                return Touched(time.perf_counter(), None, None, valid=False, invalid_reason=held.missed), None
            cut_by = self._interruption(held, trigger, *begun)
        self.setup.emitter.stop()
        self.setup.release.begin()
        decided_s, onset_s = begun
        touched = replace(self._judgement(signal, held, onset_s, cut_by), gate_s=held.let_through_s)
        if touched.force_mean_n is None:
            self.setup.say("played_unmeasured")
        else:
            self.setup.say("played", force_n=touched.force_mean_n)
        return touched, held.delay_s(decided_s)

    def _await_begin(self, held: Held, trigger: Trigger, sensor: StreamedSensor) -> tuple[float, float] | None:
        """Show the force until the stimulus begins.

        Returns decision time and onset, or None after a timeout. A silent sensor pauses the session; pauses do not
        count.
        """
        begin_s = said_s = self._present(self._bar(held, playing=False))
        while trigger.begun is None:
            said_s = self._tell_force(held, said_s)
            if (silent := self._silence(held, sensor)) is not None:
                self.setup.pause(silent, lambda: self._silence(held, sensor) is None)
            if time.perf_counter() > max(begin_s, self.setup.presenter.paused_until_s) + self.request.timeout_s:
                trigger.disarm()
                break
            self._frame(held, playing=False)
        return trigger.begun  # read after disarming, as the stimulus may have begun just before

    def _silence(self, held: Held, sensor: StreamedSensor) -> str | None:
        """Describe a silent sensor.

        A position sensor is silent only if it failed, because a lifted finger has no position.
        """
        if held.applied_force.silent:
            return silence(sensor)
        position = self.setup.position
        failure = None if held.finger_motion is None or position is None else position.reader.failure
        return None if failure is None else f"the position sensor is silent ({failure})"

    def _tell_force(self, held: Held, said_s: float) -> float:
        """Print the force about once a second and return the time of the last print."""
        now_s, force_n = time.perf_counter(), held.applied_force.force_n
        if now_s < said_s + TOLD_EVERY_S or force_n is None:
            return said_s
        self.setup.say("force" if held.released else "not_released", force_n=force_n)
        return now_s

    def _interruption(self, held: Held, trigger: Trigger, decided_s: float, onset_s: float) -> Reason | None:
        """Show the force during playback; return what cut it short, or None."""
        self._present(self._bar(held, playing=True))
        while time.perf_counter() < onset_s + self.request.duration_s:
            trigger.consider()
            if trigger.broken or self.setup.presenter.paused_until_s > decided_s:
                break
            self._frame(held, playing=True)
        if trigger.broken:
            return held.loss
        return "experimenter" if self.setup.presenter.paused_until_s > decided_s else None

    def _frame(self, held: Held, *, playing: bool) -> None:
        self.setup.presenter.frame(self.dress(self._bar(held, playing=playing), time.perf_counter()))

    def _present(self, page: Page) -> float:
        return self.setup.presenter.screen.present(self.dress(page, time.perf_counter()))

    def _bar(self, held: Held, *, playing: bool) -> Page:
        request = self.request
        words = self.words if playing or held.released else self.release_words
        why = "" if playing else self.why
        marker = layout.marker_page(request.interval, playing=playing, words=words, why=why)
        return layout.force_page(marker, held.applied_force.force_n, request.target_n, request.tolerance)

    def _judgement(self, signal: Signal | None, held: Held, onset_s: float, cut_by: Reason | None) -> Touched:
        during_s = onset_s, onset_s + self.request.duration_s
        force = held.applied_force.compliance(*during_s)
        speed = None if held.finger_motion is None else held.finger_motion.motion(*during_s)
        n_gaps = self.setup.emitter.n_gaps(signal)
        reason = cut_by or ("output_gap" if n_gaps else None)
        speed_is_lost = held.finger_motion is not None and speed is None
        if reason is None:
            reason = "sensor_lost" if force is None or speed_is_lost else broken_condition(self.request, force, speed)
        return self._answer(signal, onset_s, reason, n_gaps, **compliance_fields(force, speed))


class ConcurrentPlay:
    """Playback while other code draws, supervised by the force sensor.

    - `signal`: None for a blank.
    - `give_back`: Returns the screen after the page of a pause.
    """

    def __init__(self, setup: TouchSetup, request: Play, signal: Signal | None, give_back: Callable[[], None]) -> None:
        self._setup, self._request, self._signal, self._give_back = setup, request, signal, give_back
        self._watched = ExitStack()
        self._look = self._watched.enter_context(watchdog(setup))
        self._onset_s = setup.emitter.emit(signal)

    @property
    def cut(self) -> bool:
        """True if a pause cut the stimulus short. Nothing is then played again."""
        return self._setup.presenter.paused_until_s > self._onset_s

    def look(self) -> bool:
        """Supervise one frame and return True while the stimulus plays.

        A silent sensor or excessive force pauses the session.
        """
        try:
            self._look()
        finally:
            self._give_back()
        return not self.cut and time.perf_counter() < self._onset_s + self._request.duration_s

    def end(self) -> Played:
        """Stop and return what was played (onset on `time.perf_counter`)."""
        emitter = self._setup.emitter
        n_gaps = emitter.n_gaps(self._signal)
        emitter.stop()
        self._watched.close()
        delivered = None if self.cut else emitter.level_delivered(self._request.level)
        return Played(self._onset_s, delivered, emitter.digest(self._signal) or "", n_gaps)
