"""The bench: a participant at a screen, with an output under the finger.

Whatever goes wrong, or is stopped with Escape, the output is at zero before anything else is closed.
"""

import functools
import math
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace

from ..devices.outputs.guarded import Guarded
from ..devices.outputs.output import RAMP_S
from ..devices.sensors.force_sensor import ForceSensor
from ..devices.sensors.position_sensor import PositionSensor
from ..safety.limits import FORCE_PEAK_N, Limits
from ..session.answer import Adjusted, Chosen, Done, Filled, Played, Rated, Touched
from ..session.event import EventLog
from ..session.request import (
    A,
    Adjust,
    Choose,
    Enter,
    Fill,
    Play,
    Press,
    Rate,
    Record,
    Request,
    Show,
    Slide,
    Wait,
    value_at,
)
from ..signal import Stimulus
from ..trials.trial import Tally, Trial, outcome, tally
from . import adjustment
from .closing import safely
from .emitter import Emitter
from .experimenter.supervisor import Supervisor, utc_text
from .experimenter.terminal import ExperimenterTerminal
from .experimenter.trial_log import CLOCK, TrialLog
from .live_rig import LiveRig
from .pages import entry, form, layout
from .pages.page import Answer, Display, Page
from .pages.presenter import Dress, Presenter, as_it_is
from .texts import Texts
from .touch.playing import play_to_end
from .touch.release import Release
from .touch.setup import TouchSetup
from .touch.touch import TouchCourse, moving_cue
from .touch.trace import Trace
from .touch.watchdog import watchdog

Facts = dict[str, str | int | float | bool | None]

ASSUMED_DISPLAY_HEIGHT_M = 0.3
"""Of a 24-inch display; taken for the moving cue of a slide where nobody measured it (unverified default)."""


class Bench(LiveRig):
    """A rig with a person at it. It opens the devices, and closes all of them.

    Parameters
    ----------
    screen : Display
    output : Guarded
    bank : mapping of str to Stimulus
        The stimuli by the names that requests use.
    limits : Limits or None
        What the study allows, checked beside the limits of the output.
    texts : Texts
    sensor : ForceSensor, optional
        Without one, the force is not measured: its fields are None and every touch is valid.
    position : PositionSensor, optional
        Without one, the finger's speed is not measured.
    display_height_m : float, optional
        Measured height of the visible picture, m, for the moving cue of a `Slide`; without it
        `ASSUMED_DISPLAY_HEIGHT_M`, and the journal says that the height was not measured.
    ramp_s : float
        Ramps of signals that do not begin and end at rest; 0 for one-bit outputs.
    release : bool
        Whether the force must leave its band between touches.
    device_facts : callable
        What the head of the journal says of the devices, once they are open, and their clocks at any time.
    log : EventLog, optional
        Where pauses, remarks, clocks and the timing of each trial are kept.
    terminal : ExperimenterTerminal, optional
        The experimenter's.

    Raises
    ------
    DeviceFailed
        If a device does not open; all are closed then.
    """

    def __init__(
        self,
        screen: Display,
        output: Guarded,
        bank: Mapping[str, Stimulus],
        *,
        limits: Limits | None,
        texts: Texts,
        sensor: ForceSensor | None = None,
        position: PositionSensor | None = None,
        display_height_m: float | None = None,
        ramp_s: float = RAMP_S,
        release: bool = True,
        device_facts: Callable[[], Facts] = dict,
        log: EventLog | None = None,
        terminal: ExperimenterTerminal | None = None,
    ) -> None:
        self._screen, self._output, self._sensor, self._position = screen, output, sensor, position
        self._emitter = Emitter(bank, output, limits, ramp_s)
        self._device_facts, self._texts, self._display_height_m = device_facts, texts, display_height_m
        pausing = layout.message_page(texts.message("pause"), "", screen.aspect)
        self._terminal = ExperimenterTerminal() if terminal is None else terminal
        self._supervisor = Supervisor(screen, self._terminal, log, self._emitter.mute, pausing)
        output.tell(self._supervisor.emitted)
        self._presenter = Presenter(screen, self._supervisor.attend)
        self._trial_log = TrialLog(self._supervisor, screen, self._clocks)
        self._tally = Tally()
        self._limits, self._release = limits, Release(needed=release)
        force_peak_n = FORCE_PEAK_N if limits is None else limits.force_peak_n
        parts = (self._presenter, self._emitter, sensor, position, self._release, self._pause, self._terminal.add)
        self._setup = TouchSetup(*parts, force_peak_n)
        self.closed = False
        self._open()

    @safely
    def _open(self) -> None:
        self._output.open()
        for sensor in (self._sensor, self._position):
            if sensor is not None:
                sensor.open()
        if self._sensor is not None:
            self._sensor.listen(self._release.hear)
        # drawn now, so that the first page of a trial costs no frame when it is due
        for interval in (None, 1, 2):
            self._screen.prepare(layout.marker_page(interval, playing=True))
            self._screen.prepare(layout.marker_page(interval, playing=False))
        if not self._emitter.emits:
            self._terminal.tell(f"output {self._output.name}: nothing is played, and no level counts as delivered")

    def facts(self) -> Facts:
        """Display, keyboard, devices and clock, for the head of the journal."""
        return {
            "rig": "bench",
            **self._screen.facts(),
            "display_height_m": self._display_height_m,
            "output": self._output.name,
            "force_sensor": None if self._sensor is None else self._sensor.name,
            "position_sensor": None if self._position is None else self._position.name,
            **self._emitter.limit_facts(),
            **self._device_facts(),
            "clock": "time.perf_counter",
            "clock_resolution_s": time.get_clock_info("perf_counter").resolution,
            "utc_minus_clock_s": round(time.time() - time.perf_counter(), 6),
        }

    def _clocks(self) -> Facts:
        keyboard_s, utc_s = self._screen.clock_offset_s(), time.perf_counter() - time.time()
        return {**self._device_facts(), f"keyboard{CLOCK}": keyboard_s, f"utc{CLOCK}": utc_s}

    def resume(self, trials: Sequence[Trial], elapsed_s: float) -> None:
        self._tally = tally(trials)
        self._supervisor.zero_s = time.perf_counter() - elapsed_s

    @safely
    def answer(self, request: Request[A]) -> A:
        return super().answer(request)

    def turn(self) -> None:
        self._trial_log.turn()

    def close(self) -> None:
        if self.closed:
            return
        self.closed = True
        # the output is at zero before anything is closed that may fail or hang; whatever fails, the rest is closed too
        with ExitStack() as last_first:
            last_first.callback(self._terminal.end_line)
            last_first.callback(self._screen.close)
            for sensor in (self._position, self._sensor):
                if sensor is not None:
                    last_first.callback(sensor.close)
            last_first.callback(self._output.close)
            last_first.callback(self._output.stop)

    def _session_s(self, clock_s: float) -> float:
        return round(clock_s - self._supervisor.zero_s, 6)

    def _done(self) -> Done:
        return Done(self._session_s(time.perf_counter()))

    def _play(self, request: Play) -> Played:
        signal = self._emitter.fitting(request.stimulus, request.level, request.duration_s)
        answer = play_to_end(self._setup, request, layout.marker_page(request.interval, playing=True), signal)
        return replace(answer, onset_s=self._session_s(answer.onset_s))

    def _press(self, request: Press) -> Touched:
        return self._touch(request, "press", as_it_is, Trace())

    def _slide(self, request: Slide) -> Touched:
        height_m = ASSUMED_DISPLAY_HEIGHT_M if self._display_height_m is None else self._display_height_m
        places = Trace()
        return self._touch(request, "slide", moving_cue(request, height_m, places), places)

    def _touch(self, request: Press | Slide, words: str, dress: Dress, places: Trace) -> Touched:
        if self._limits is not None:
            self._limits.check_force(request.target_n, request.tolerance)
        self._supervisor.under_way = True
        level = "blank" if request.level is None else f"{request.level:g}"
        self._terminal.add(f"trial {self._tally.n_trials + 1}: {request.stimulus} {level}")
        signal = self._emitter.fitting(request.stimulus, request.level, request.duration_s)
        measured = self._texts.message(f"{words}_force" if self._sensor is not None else words)
        release = self._texts.message("release")
        felt = TouchCourse(request, self._setup, places, measured, release, dress).felt(signal)
        self._trial_log.decided(felt.gate_delay_s)
        touched = replace(felt.touched, onset_s=self._session_s(felt.touched.onset_s))
        if touched.valid and self._supervisor.repeat:
            return replace(touched, valid=False, invalid_reason="experimenter")
        return touched

    def _pause(self, by: str, over: Callable[[], bool]) -> None:
        self._supervisor.pause(by, over)
        self._presenter.paused()

    def _choose(self, request: Choose) -> Chosen:
        page = layout.question_page(
            self._texts.message(request.question),
            request.options,
            [self._texts.label(label) for label in request.labels],
            self._texts.message("hint_choose"),
            self._screen.aspect,
        )
        option, onset_s, end_s = self._presenter.converse(
            request.options[0], lambda option: page, lambda option, answer: (_option(answer), True)
        )
        return Chosen(option, *self._answered(onset_s, end_s), valid=self._counts)

    @property
    def _counts(self) -> bool:
        """Whether the answer that was given counts: the experimenter wants no repetition."""
        return not self._supervisor.repeat

    def _answered(self, onset_s: float, end_s: float) -> tuple[float, float, str]:
        """Onset in the session, latency and time of day of an answer."""
        self._trial_log.answered(end_s)
        self._terminal.add(f"answered in {end_s - onset_s:.2f} s")
        return self._session_s(onset_s), round(end_s - onset_s, 6), utc_text(end_s)

    def _rate(self, request: Rate) -> Rated:
        scale = self._scale(request)
        unmarked: int | None = None
        mark, onset_s, end_s = self._presenter.converse(
            unmarked, lambda mark: layout.scale_page(scale, mark, self._screen.aspect), scale.after
        )
        value = None if mark is None else scale.value(mark, request.low, request.high)
        return Rated(value, *self._answered(onset_s, end_s), valid=self._counts)

    def _enter(self, request: Enter) -> Rated:
        words, hint = self._texts.message(request.question), self._texts.message("hint_enter")
        low, high = request.low, request.high

        def view(typed: str) -> Page:
            ready = entry.value_of(typed, low, high) is not None
            return entry.entry_page(words, typed, hint, self._screen.aspect, ready=ready)

        typed, onset_s, end_s = self._presenter.converse(
            "", view, lambda typed, key: entry.after(typed, key, low, high)
        )
        value = entry.value_of(typed, low, high)
        return Rated(value, *self._answered(onset_s, end_s), valid=self._counts)

    def _fill(self, request: Fill) -> Filled:
        page = self._form(request)
        marks, onset_s, end_s = self._presenter.converse(
            form.Marks((None,) * len(page.rows)),
            lambda marks: form.form_page(page, marks, self._screen.aspect),
            functools.partial(form.after, page),
        )
        values = tuple(
            None if place is None else value_at(place, page.n_positions, request.low, request.high)
            for place in marks.places
        )
        return Filled(values, *self._answered(onset_s, end_s), valid=self._counts)

    def _form(self, request: Fill) -> form.Form:
        return form.Form(
            rows=tuple(self._texts.question(question) for question in request.questions),
            n_positions=layout.N_POSITIONS_CONTINUOUS if request.steps is None else request.steps,
            rings=request.steps is not None,
            hint=self._texts.message(form.hint_for(request.steps)),
            gaps=self._texts.message("hint_gaps"),
        )

    def _scale(self, request: Rate) -> layout.Scale:
        return layout.Scale(
            words=self._texts.messages.get(request.item, self._texts.message("rate")),
            low=self._texts.label(request.low_label),
            high=self._texts.label(request.high_label),
            hint=self._texts.message("hint_rate_continuous" if request.steps is None else "hint_rate"),
            n_positions=layout.N_POSITIONS_CONTINUOUS if request.steps is None else request.steps,
            rings=request.steps is not None,
        )

    def _adjust(self, request: Adjust) -> Adjusted:
        page = layout.adjust_page(
            self._texts.message("adjust"), self._texts.message("hint_adjust"), self._screen.aspect
        )
        self._supervisor.under_way = True
        with watchdog(self._setup) as look:
            stimulus = adjustment.RepeatedStimulus(request, self._emitter, look)
            n_steps, onset_s, end_s = self._presenter.converse(
                0, lambda n_steps: page, functools.partial(adjustment.stepped, request), stimulus.keep_playing
            )
            self._emitter.stop()
        valid = self._counts and not stimulus.n_gaps
        return Adjusted(request.level(n_steps), *self._answered(onset_s, end_s), valid=valid, n_gaps=stimulus.n_gaps)

    def _wait(self, request: Wait) -> Done:
        begin_s = self._presenter.present(layout.waiting_page())
        self._presenter.hold(begin_s + request.duration_s, layout.waiting_page())
        return self._done()

    def _show(self, request: Show) -> Done:
        self._terminal.tell(f"page: {request.message}")
        if request.duration_s is None:
            page = self._message(request, self._texts.message("hint_continue"))
            self._presenter.converse(None, lambda state: page, lambda state, answer: (state, True))
            return self._done()
        n_seconds = math.ceil(request.duration_s)
        for left_s in range(n_seconds, 0, -1):
            page = self._message(request, "", left_s)
            shown_s = request.duration_s - n_seconds + 1 if left_s == n_seconds else 1.0
            self._presenter.hold(self._presenter.present(page) + shown_s, page)
        return self._done()

    def _message(self, request: Show, hint: str, left_s: int = 0) -> Page:
        """A text with its progress; a page that ends by itself may say how many seconds are left."""
        block, n_blocks = (request.values.get(name) for name in ("block", "n_blocks"))
        progress = (block - 1) / n_blocks if isinstance(block, int) and isinstance(n_blocks, int) else None
        words = self._texts.page(request, left_s)
        return layout.message_page(words, hint, self._screen.aspect, progress)

    def _record(self, request: Record) -> Done:
        trial, self._supervisor.under_way, self._supervisor.repeat = request.trial, False, False
        before, self._tally = self._tally, self._tally.after(trial)
        if self._tally.n_trials > before.n_trials:  # not each item of a questionnaire
            response = "no answer, " if trial.response is None else f"{trial.response}, "
            self._terminal.add(f"{'' if trial.task == 'rating' else response}{outcome(trial, self._tally.n_trials)}")
        self._terminal.end_line()
        if request.aborted:
            self._terminal.tell(f"! {request.aborted}")
        self._trial_log.trial(trial)
        return self._done()


def _option(answer: Answer) -> int:
    assert isinstance(answer, int)
    return answer
