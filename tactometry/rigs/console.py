"""Console rig, to try a protocol or to run one without a screen."""

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
from ..session.request import (
    CONSENT,
    MISSED_PRACTICE,
    Adjust,
    Choose,
    Enter,
    Facts,
    Fill,
    Play,
    Press,
    Question,
    Record,
    Show,
    Slide,
    Wait,
)
from .device_rig import DeviceRig, Equipment
from .experimenter.terminal import ExperimenterTerminal
from .pages import layout
from .pages.page import Display
from .texts import Texts
from .touch.gated_samples import Trace
from .touch.touch import TouchRun
from .touch.watchdog import play_to_end

T = TypeVar("T")

N_TRIES = 20
"""Number of consecutive invalid lines after which the session stops: the input is probably not typed by a user."""
ESCAPE: Final = "\x1b"
WAYS: Final[Mapping[str, tuple[int, float | None]]] = {"-": (1, None), "<": (-1, None)}
"""Inputs that leave a question unanswered or return to the previous question."""


class Lines(ExperimenterTerminal):
    """Printer of all messages to a file, for participant and experimenter."""

    def __init__(self, output: TextIO, language: str) -> None:
        super().__init__(language=language)
        self._file = output

    def add(self, words: str) -> None:
        self.tell(words)

    def _write(self, words: str) -> None:
        print(words, end="", file=self._file, flush=True)


class Console(DeviceRig):
    """Rig that prints each request to `output` and reads lines from `source`.

    With a null output, stimuli are rendered and checked but not delivered. Other outputs play under the same safety
    checks and sensor conditions as on a bench. After an invalid line the question is repeated, up to `N_TRIES`
    times. Escape or the end of the input stops the session. Pages wait for Return only if the input is a terminal.
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
        terminal = Lines(self._output, texts.language)
        self._phrase = terminal.phrase
        super().__init__(Display(), equipment, texts, terminal=terminal, log=log)

    def _open(self) -> None:
        super()._open()
        output = self._equipment.output
        plays = self._phrase("plays", output=output.name) if output.emits else self._phrase("silent").strip()
        self._terminal.tell(plays)
        self._terminal.tell(self._phrase("stopping"))

    def facts(self) -> Facts:
        clock = time.get_clock_info("perf_counter")
        return {
            "rig": "console",
            **self._device_facts(),
            "clock": clock.implementation,
            "clock_resolution_s": clock.resolution,
            "terminal": self._source.isatty(),
        }

    def _ask(self, prompt: str, read: Callable[[str], T], expected: str = "") -> tuple[T, float, float, str]:
        """Ask a question; return answer, onset, latency and time of day.

        If `read` refuses a line, print the `expected` answer and repeat the question.
        """
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
                self._terminal.tell(self._phrase("no_answer", expected=expected, line=repr(line.strip())))
        raise self._stop(f"{N_TRIES} invalid answers in a row")

    def _pause(self, by: str, over: Callable[[], bool]) -> None:
        self._tell_page(Show("pause"))
        super()._pause(by, over)

    def _tell_page(self, request: Show) -> None:
        self._terminal.tell(self._texts.page(request, math.ceil(request.duration_s or 0)).strip())

    def _stop(self, why: str) -> Stopped:
        self._tell_page(Show("stopped"))
        return self._supervisor.stop(why, f" ({self._tally})")

    def _present(self, what: str, interval: int | None) -> None:
        self._terminal.tell(f"{self._next()} {what}{self._phrase('interval', n=interval) if interval else ''}")

    def _next(self) -> str:
        return self._phrase("trial", n=self._tally.n_presented + 1)

    def _play(self, request: Play) -> Played:
        signal = self._signal(request)
        self._present(self._phrase("play", duration_s=request.duration_s), request.interval)
        if not self._equipment.output.emits:
            return Played(self._done().at_s, None, "")
        return self._in_session(play_to_end(self._setup, request, layout.waiting_page(), signal))

    def _feel(self, request: Press | Slide) -> Touched:
        how = {"force_n": request.target_n, "duration_s": request.duration_s}
        if isinstance(request, Slide):
            what = self._phrase("slide", speed_mm_per_s=1e3 * request.speed_m_per_s, **how)
        else:
            what = self._phrase("press", **how)
        signal = self._signal(request)
        lifts = self._setup.sensor is not None and self._equipment.output.emits
        self._present(f"{what}{self._phrase('lift') if lifts else ''}", request.interval)
        if not self._equipment.output.emits:
            return Touched(self._done().at_s, None, None)
        return self._touched_in_session(TouchRun(request, self._setup, Trace()).carry_out(signal)[0])

    def _choose(self, request: Choose) -> Chosen:
        labels = [self._texts.label(label) for label in request.labels]
        words = ", ".join(f"{n} = {label}" for n, label in zip(request.options, labels, strict=True))
        question = self._texts.message(request.question)
        of_trial = "" if request.question in (CONSENT, MISSED_PRACTICE) else f"{self._next()} "
        prompt = f"{of_trial}{question} ({words}):"
        *others, last = map(str, request.options)
        expected = self._phrase("either", options=", ".join(others), last=last) if others else last
        return Chosen(*self._ask(prompt, lambda line: _option(line, request.options, labels), expected))

    def _number(self, low: float, high: float) -> str:
        return self._phrase("number_from" if high == math.inf else "number", low=low, high=high)

    def _enter(self, request: Enter) -> Rated:
        low, high = request.low, math.inf if request.high is None else request.high
        expected = self._number(low, high)
        prompt = f"{self._texts.message(request.question)} ({expected}):"
        return Rated(*self._ask(prompt, lambda line: _within(line, low, high), expected))

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
        """Return the number of questions to move by, and the answer."""
        statement, left, right = self._texts.question(question)
        step = (request.high - request.low) / (request.steps - 1) if request.steps else 1.0
        by = "" if step == 1 else self._phrase("steps", step=step)
        ends = f"{request.low:g} = {left}, {request.high:g} = {right}{by}"
        ways = self._phrase("ways")
        prompt = f"{statement} ({ends}; {ways}):".lstrip()
        expected = f"{self._number(request.low, request.high)}{by} ({ways})"
        return self._ask(prompt, lambda line: WAYS.get(line) or (1, _on_scale(line, request)), expected)[0]

    def _adjust(self, request: Adjust) -> Adjusted:
        adjustment = "an adjustment task, which plays its level continuously"
        expect(not self._equipment.output.emits, "console", adjustment, "another task; use --rig bench")
        prompt = self._phrase("level", stimulus=request.stimulus, low=request.low, high=request.high)
        expected = self._number(request.low, request.high)
        return Adjusted(*self._ask(prompt, lambda line: _within(line, request.low, request.high), expected))

    def _wait(self, request: Wait) -> Done:
        time.sleep(request.duration_s)
        return self._done()

    def _show(self, request: Show) -> Done:
        self._tell_page(request)
        if self._source.isatty() and request.message != "end":
            # at a terminal, wait for the page's duration or a key
            if request.duration_s is None:
                self._ask(self._phrase("go_on"), str)
            else:
                time.sleep(request.duration_s)
        return self._done_between()

    def _record(self, request: Record) -> Done:
        self._supervisor.end_trial(request.trial)
        before, self._tally = self._tally, self._tally.after(request.trial)
        if self._tally.n_invalid > before.n_invalid:
            n = self._tally.n_presented
            self._terminal.tell(f"{self._phrase('trial', n=n)} {self._terminal.outcome(request.trial, n)}")
        if request.aborted:
            self._terminal.tell(f"! {request.aborted}")
        return self._done_between()


def _option(line: str, options: Sequence[int], labels: Sequence[str]) -> int:
    """Return the option whose number or label was typed."""
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
    value = float(line.replace(",", "."))
    if not (math.isfinite(value) and low <= value <= high):
        raise ValueError(line)
    return value
