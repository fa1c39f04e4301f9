"""A terminal that asks: for trying a protocol out, and for sessions without a screen."""

import math
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import Final, TextIO, TypeVar

from ..devices.outputs.guarded import Guarded, GuardedSignal
from ..devices.outputs.output import RAMP_S, NullOutput
from ..devices.sensors.force_sensor import ForceSensor
from ..devices.sensors.position_sensor import PositionSensor
from ..errors import InvalidParameter, Stopped
from ..safety.limits import Limits
from ..session.answer import Adjusted, Chosen, Done, Filled, Played, Rated, Touched
from ..session.event import Event, EventLog, Fact, Kind
from ..session.request import Adjust, Choose, Enter, Fill, Play, Press, Question, Rate, Record, Show, Slide, Wait
from ..signal import Stimulus
from ..trials.trial import Tally, Trial, outcome, tally
from .blind import Blind
from .emitter import Emitter
from .experimenter.supervisor import SAFE, utc_text
from .live_rig import LiveRig
from .pages import layout
from .pages.presenter import Presenter
from .texts import Texts
from .touch.playing import play_to_end
from .touch.release import Release
from .touch.setup import TouchSetup
from .touch.touch import TouchCourse
from .touch.trace import Trace

T = TypeVar("T")

N_TRIES = 20
"""Lines that are no answer before a session is stopped: nobody types there."""
ESCAPE: Final = "\x1b"
STOPPING: Final = "Ctrl-C stops (or, at a question, Ctrl-D; or Escape and return); what was recorded is safe"
SILENT_OUTPUT: Final = (
    "This terminal plays nothing: stimuli are checked and left out, and the rows hold no delivered level. It is for "
    "trying a study out; with --bench, stimuli play through the output of the bench file."
)
Facts = dict[str, str | int | float | bool | None]


class Console(LiveRig):
    """Prints each request to `output` and reads the answers, a line each, from `source`.

    Without a `device` stimuli are rendered and held against the limits, and nothing is emitted or delivered; with one
    they play through its guard, under the conditions of the sensors, as on a bench. A line that is no answer is asked
    again, up to `N_TRIES` times; Escape and the end of the input stop the session.
    """

    def __init__(
        self,
        bank: Mapping[str, Stimulus],
        limits: Limits,
        texts: Texts,
        source: TextIO | None = None,
        output: TextIO | None = None,
        *,
        device: Guarded | None = None,
        sensor: ForceSensor | None = None,
        position: PositionSensor | None = None,
        ramp_s: float = RAMP_S,
        release: bool = True,
        device_facts: Callable[[], Facts] = dict,
        log: EventLog | None = None,
    ) -> None:
        self._limits, self._texts = limits, replace(texts, stop="ctrl_c")
        self._source = sys.stdin if source is None else source
        self._output = sys.stdout if output is None else output
        self._device = Guarded(NullOutput(), limits) if device is None else device
        self._sensor, self._position, self._release = sensor, position, Release(needed=release)
        self._emitter, self._presenter = Emitter(bank, self._device, limits, ramp_s), Presenter(Blind())
        parts = (self._presenter, self._emitter, sensor, position, self._release, self._pause, self._say)
        self._setup = TouchSetup(*parts, limits.force_peak_n)
        self._device_facts, self._log = device_facts, log
        self._zero_s = time.perf_counter()
        self._tally = Tally()
        self._opened = ExitStack()
        self._open()
        self._say(f"Stimuli play through {self._device.name}." if self._emitter.emits else SILENT_OUTPUT)
        self._say(f"{STOPPING}.")

    def _open(self) -> None:
        """Open the devices: what is open is closed if one of them cannot be opened."""
        self._device.tell(self._emitted)
        with ExitStack() as opened:
            for part in (self._position, self._sensor, self._device):
                if part is not None:
                    part.open()
                    opened.callback(part.close)
            if self._sensor is not None:
                self._sensor.listen(self._release.hear)
            self._opened = opened.pop_all()

    def facts(self) -> Facts:
        clock = time.get_clock_info("perf_counter")
        return {
            "rig": "console",
            "output": self._device.name,
            "force_sensor": None if self._sensor is None else self._sensor.name,
            "position_sensor": None if self._position is None else self._position.name,
            **self._emitter.limit_facts(),
            **self._device_facts(),
            "clock": clock.implementation,
            "clock_resolution_s": clock.resolution,
            "terminal": self._source.isatty(),
        }

    def resume(self, trials: Sequence[Trial], elapsed_s: float) -> None:
        self._tally = tally(trials)
        self._zero_s = time.perf_counter() - elapsed_s

    def close(self) -> None:
        self._emitter.stop()  # zero before anything is closed that may fail or hang
        self._opened.close()

    def _session_s(self, clock_s: float) -> float:
        return round(clock_s - self._zero_s, 6)

    def _now_s(self) -> float:
        return self._session_s(time.perf_counter())

    def _say(self, text: str) -> None:
        print(text, file=self._output, flush=True)

    def _note(self, kind: Kind, clock_s: float, facts: Mapping[str, Fact], duration_s: float | None = None) -> None:
        if self._log is not None:
            self._log.note(Event(kind, self._session_s(clock_s), utc_text(clock_s), facts, duration_s))

    def _emitted(self, emission: GuardedSignal) -> None:
        self._note("stimulus", emission.onset_s, {"charge_c": emission.charge_c}, emission.duration_s)

    def _stopped(self, why: str) -> Stopped:
        self._emitter.stop()
        self._note("stop", time.perf_counter(), {"text": why})
        return Stopped(f"{why}; {SAFE} ({self._tally})")

    def _pause(self, by: str, over: Callable[[], bool]) -> None:
        """The output is at zero until it is over."""
        self._emitter.mute(on=True)
        self._note("pause", time.perf_counter(), {"text": by})
        self._say(f"paused: {by}")
        while not over():
            time.sleep(self._presenter.screen.period_s)
        self._note("resume", time.perf_counter(), {"text": by})
        self._say("it goes on")
        self._emitter.mute(on=False)
        self._presenter.paused()

    def _ask(self, prompt: str, read: Callable[[str], T]) -> tuple[T, float, float, str]:
        """An answer, the onset of its question, its latency, and the time of day when it was given."""
        onset_s = self._now_s()
        for _ in range(N_TRIES):
            print(prompt, end=" ", file=self._output, flush=True)
            line = self._source.readline()
            if not line:
                raise self._stopped("the input ended")
            if ESCAPE in line:
                raise self._stopped("Escape was typed")
            try:
                return read(line.strip()), *self._answered(onset_s)
            except ValueError:
                self._say(f"found {line.strip()!r}, expected an answer to: {prompt}")
        raise self._stopped(f"{N_TRIES} lines were no answers")

    def _answered(self, onset_s: float) -> tuple[float, float, str]:
        return onset_s, round(self._now_s() - onset_s, 6), utc_text(time.perf_counter())

    def _present(self, what: str, interval: int | None) -> None:
        self._say(f"[trial {self._tally.n_trials + 1}] {what}" + (f", interval {interval}" if interval else ""))

    def _play(self, request: Play) -> Played:
        signal = self._emitter.fitting(request.stimulus, request.level, request.duration_s)
        self._present(f"play for {request.duration_s:g} s", request.interval)
        if not self._emitter.emits:
            return Played(self._now_s(), None, "")
        answer = play_to_end(self._setup, request, layout.waiting_page(), signal)
        return replace(answer, onset_s=self._session_s(answer.onset_s))

    def _press(self, request: Press) -> Touched:
        return self._touch(request, f"press with {request.target_n:g} N for {request.duration_s:g} s")

    def _slide(self, request: Slide) -> Touched:
        speed_mm_per_s = 1e3 * request.speed_m_per_s
        return self._touch(
            request,
            f"slide with {request.target_n:g} N at {speed_mm_per_s:g} mm/s for {request.duration_s:g} s",
        )

    def _touch(self, request: Press | Slide, what: str) -> Touched:
        self._limits.check_force(request.target_n, request.tolerance)
        signal = self._emitter.fitting(request.stimulus, request.level, request.duration_s)
        lift = " (lift the finger first)" if self._sensor is not None and self._emitter.emits else ""
        self._present(f"{what}{lift}", request.interval)
        if not self._emitter.emits:
            return Touched(self._now_s(), None, None)
        touched = TouchCourse(request, self._setup, Trace()).felt(signal).touched
        return replace(touched, onset_s=self._session_s(touched.onset_s))

    def _choose(self, request: Choose) -> Chosen:
        labels = [self._texts.label(label) for label in request.labels]
        words = ", ".join(f"{n} = {label}" for n, label in zip(request.options, labels, strict=True))
        question = self._texts.message(request.question)
        prompt = f"[trial {self._tally.n_trials + 1}] {question} ({words}):"
        return Chosen(*self._ask(prompt, lambda line: _option(line, request.options, labels)))

    def _rate(self, request: Rate) -> Rated:
        prompt = f"{request.item} ({request.low:g} = {request.low_label}, {request.high:g} = {request.high_label}):"
        return Rated(*self._ask(prompt, lambda line: _within(line, request.low, request.high)))

    def _enter(self, request: Enter) -> Rated:
        most = "" if request.high is None else f" to {request.high:g}"
        prompt = f"{self._texts.message(request.question)} (a number from {request.low:g}{most}):"
        high = math.inf if request.high is None else request.high
        return Rated(*self._ask(prompt, lambda line: _within(line, request.low, high)))

    def _fill(self, request: Fill) -> Filled:
        onset_s = self._now_s()
        values = tuple(self._fill_one(request, question) for question in request.questions)
        return Filled(values, *self._answered(onset_s))

    def _fill_one(self, request: Fill, question: Question) -> float | None:
        statement, left, right = self._texts.question(question)
        step = (request.high - request.low) / (request.steps - 1) if request.steps else 1.0
        by = "" if step == 1 else f", in steps of {step:g}"
        prompt = f"{statement} ({request.low:g} = {left}, {request.high:g} = {right}{by}; - leaves it open):".lstrip()
        return self._ask(prompt, lambda line: None if line == "-" else _on_scale(line, request))[0]

    def _adjust(self, request: Adjust) -> Adjusted:
        if self._emitter.emits:
            raise InvalidParameter(
                "console: found an adjustment, whose level plays while it is set, expected a task without one; use "
                "--rig bench"
            )
        prompt = f"level of {request.stimulus} ({request.low:g} to {request.high:g}):"
        return Adjusted(*self._ask(prompt, lambda line: _within(line, request.low, request.high)))

    def _wait(self, request: Wait) -> Done:
        time.sleep(request.duration_s)
        return Done(self._now_s())

    def _show(self, request: Show) -> Done:
        self._say(self._texts.page(request, math.ceil(request.duration_s or 0)).strip())
        return Done(self._now_s())

    def _record(self, request: Record) -> Done:
        before, self._tally = self._tally, self._tally.after(request.trial)
        if self._tally.n_invalid > before.n_invalid:
            self._say(f"[trial {self._tally.n_trials}] {outcome(request.trial, self._tally.n_trials)}")
        if request.aborted:
            self._say(f"! {request.aborted}")
        return Done(self._now_s())


def _option(line: str, options: Sequence[int], labels: Sequence[str]) -> int:
    """The option whose number or word was typed."""
    words = [label.casefold() for label in labels]
    number = options[words.index(line.casefold())] if line.casefold() in words else int(line)
    if number not in options:
        raise ValueError(line)
    return number


def _on_scale(line: str, request: Fill) -> float:
    value = _within(line, request.low, request.high)
    place = (value - request.low) / (request.high - request.low) * ((request.steps or 2) - 1)
    if request.steps is not None and not math.isclose(place, round(place), abs_tol=1e-9):
        raise ValueError(line)
    return value


def _within(line: str, low: float, high: float) -> float:
    value = float(line)
    if not (math.isfinite(value) and low <= value <= high):
        raise ValueError(line)
    return value
