"""A terminal that asks: for trying a protocol out, and for sessions without a screen."""

import math
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Final, TextIO, TypeVar

from ..arguments.require import expect
from ..errors import Stopped
from ..session.answer import Adjusted, Chosen, Done, Filled, Marked, Played, Rated, Touched
from ..session.event import EventLog
from ..session.request import Adjust, Choose, Enter, Facts, Fill, Play, Press, Question, Rate, Record, Show, Slide, Wait
from ..trials.trial import outcome
from .device_rig import DeviceRig, Equipment
from .experimenter.terminal import ExperimenterTerminal
from .pages import layout
from .pages.page import Display
from .texts import Texts
from .touch.gated_samples import Trace
from .touch.touch import TouchCourse
from .touch.watchdog import play_to_end

T = TypeVar("T")

N_TRIES = 20
"""Lines that are no answer before a session is stopped: nobody types there."""
ESCAPE: Final = "\x1b"
STOPPING: Final = "Ctrl-C stops (or, at a question, Ctrl-D; or Escape and return); what was recorded is safe"
WAYS: Final[Mapping[str, tuple[int, float | None]]] = {"-": (1, None), "<": (-1, None)}
"""What leaves a question open, and what goes back to the one before."""
SILENT_OUTPUT: Final = (
    "This terminal plays nothing: stimuli are checked and left out, and the rows hold no delivered level. It is for "
    "trying a study out; with --bench, stimuli play through the output of the bench file."
)


class Lines(ExperimenterTerminal):
    """A line for whatever is told, in any file: participant and experimenter read the same."""

    def __init__(self, output: TextIO) -> None:
        super().__init__()
        self._file = output

    def add(self, words: str) -> None:
        self.tell(words)

    def _write(self, words: str) -> None:
        print(words, end="", file=self._file, flush=True)


class Console(DeviceRig):
    """Prints each request to `output` and reads the answers, a line each, from `source`.

    Where the output of the `equipment` is a null output, stimuli are rendered and held against the limits, and nothing
    is emitted or delivered; with another they play through its guard, under the conditions of the sensors, as on a
    bench. A line that is no answer is asked again, up to `N_TRIES` times; Escape and the end of the input stop the
    session.
    """

    def __init__(
        self,
        equipment: Equipment,
        texts: Texts,
        source: TextIO | None = None,
        output: TextIO | None = None,
        *,
        log: EventLog | None = None,
    ) -> None:
        self._source, self._output = source or sys.stdin, output or sys.stdout
        texts = replace(texts, stop="ctrl_c")
        super().__init__(Display(), equipment, texts, terminal=Lines(self._output), log=log)

    def _open(self) -> None:
        super()._open()
        output = self._equipment.output
        self._terminal.tell(f"Stimuli play through {output.name}." if output.emits else SILENT_OUTPUT)
        self._terminal.tell(f"{STOPPING}.")

    def facts(self) -> Facts:
        clock = time.get_clock_info("perf_counter")
        return {
            "rig": "console",
            **self._device_facts(),
            "clock": clock.implementation,
            "clock_resolution_s": clock.resolution,
            "terminal": self._source.isatty(),
        }

    def _ask(self, prompt: str, read: Callable[[str], T]) -> tuple[T, float, float, str]:
        """An answer, the onset of its question, its latency, and the time of day when it was given."""
        onset_s = time.perf_counter()
        for _ in range(N_TRIES):
            print(prompt, end=" ", file=self._output, flush=True)
            line = self._source.readline()
            if not line:
                raise self._stop("the input ended")
            if ESCAPE in line:
                raise self._stop("Escape was typed")
            try:
                return read(line.strip()), *self._times(onset_s, time.perf_counter())
            except ValueError:
                self._terminal.tell(f"found {line.strip()!r}, expected an answer to: {prompt}")
        raise self._stop(f"{N_TRIES} lines were no answers")

    def _stop(self, why: str) -> Stopped:
        return self._supervisor.stop(why, f" ({self._tally})")

    def _present(self, what: str, interval: int | None) -> None:
        self._terminal.tell(
            f"[trial {self._tally.n_presented + 1}] {what}" + (f", interval {interval}" if interval else "")
        )

    def _play(self, request: Play) -> Played:
        signal = self._signal(request)
        self._present(f"play for {request.duration_s:g} s", request.interval)
        if not self._equipment.output.emits:
            return Played(self._done().at_s, None, "")
        return self._in_session(play_to_end(self._setup, request, layout.waiting_page(), signal))

    def _press(self, request: Press) -> Touched:
        return self._touch(request, f"press with {request.target_n:g} N for {request.duration_s:g} s")

    def _slide(self, request: Slide) -> Touched:
        speed_mm_per_s = 1e3 * request.speed_m_per_s
        at = f"at {speed_mm_per_s:g} mm/s for {request.duration_s:g} s"
        return self._touch(request, f"slide with {request.target_n:g} N {at}")

    def _touch(self, request: Press | Slide, what: str) -> Touched:
        signal = self._signal(request)
        lift = " (lift the finger first)" if self._setup.sensor is not None and self._equipment.output.emits else ""
        self._present(f"{what}{lift}", request.interval)
        if not self._equipment.output.emits:
            return Touched(self._done().at_s, None, None)
        return self._touched_in_session(TouchCourse(request, self._setup, Trace()).carry_out(signal)[0])

    def _choose(self, request: Choose) -> Chosen:
        labels = [self._texts.label(label) for label in request.labels]
        words = ", ".join(f"{n} = {label}" for n, label in zip(request.options, labels, strict=True))
        question = self._texts.message(request.question)
        prompt = f"[trial {self._tally.n_presented + 1}] {question} ({words}):"
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
        onset_s = time.perf_counter()
        if request.stem:
            self._terminal.tell(self._texts.in_language(request.stem))
        values = list(request.given or [None] * len(request.questions))
        at = values.index(None) if None in values else len(values) - 1
        lowest = 0 if request.page == 1 else -1
        while 0 <= at < len(values):
            step, value = self._fill_one(request, request.questions[at])
            if step > 0:
                values[at] = value
                self._keep_marks(Marked(request.form, tuple(values), self._done().at_s))
            at = max(at + step, lowest)
        return Filled(tuple(values), *self._times(onset_s, time.perf_counter()), back=at < 0)

    def _fill_one(self, request: Fill, question: Question) -> tuple[int, float | None]:
        """By how many questions it goes on, and the answer."""
        statement, left, right = self._texts.question(question)
        step = (request.high - request.low) / (request.steps - 1) if request.steps else 1.0
        by = "" if step == 1 else f", in steps of {step:g}"
        ends = f"{request.low:g} = {left}, {request.high:g} = {right}{by}"
        prompt = f"{statement} ({ends}; - leaves it open, < goes back):".lstrip()
        return self._ask(prompt, lambda line: WAYS.get(line) or (1, _on_scale(line, request)))[0]

    def _adjust(self, request: Adjust) -> Adjusted:
        adjustment = "an adjustment, whose level plays while it is set"
        expect(not self._equipment.output.emits, "console", adjustment, "a task without one; use --rig bench")
        prompt = f"level of {request.stimulus} ({request.low:g} to {request.high:g}):"
        return Adjusted(*self._ask(prompt, lambda line: _within(line, request.low, request.high)))

    def _wait(self, request: Wait) -> Done:
        time.sleep(request.duration_s)
        return self._done()

    def _show(self, request: Show) -> Done:
        self._terminal.tell(self._texts.page(request, math.ceil(request.duration_s or 0)).strip())
        return self._done_between()

    def _record(self, request: Record) -> Done:
        self._supervisor.end_trial(request.trial)
        before, self._tally = self._tally, self._tally.after(request.trial)
        if self._tally.n_invalid > before.n_invalid:
            self._terminal.tell(f"[trial {self._tally.n_presented}] {outcome(request.trial, self._tally.n_presented)}")
        if request.aborted:
            self._terminal.tell(f"! {request.aborted}")
        return self._done_between()


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
