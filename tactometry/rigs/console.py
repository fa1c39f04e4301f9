"""A terminal that asks: for trying a protocol out, and for devices that a person works by hand."""

import math
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from typing import TextIO

from tactometry.answers import LARGEST_ANSWER
from tactometry.errors import Stopped
from tactometry.limits import Limits
from tactometry.request import (
    Adjust,
    Adjusted,
    Choose,
    Chosen,
    Done,
    Enter,
    Fill,
    Filled,
    Play,
    Played,
    Press,
    Question,
    Rate,
    Rated,
    Record,
    Show,
    Slide,
    Touched,
    Wait,
)
from tactometry.rigs.texts import Texts
from tactometry.signal import Signal, Stimulus
from tactometry.trial import Tally, Trial, tally

N_TRIES = 20
"""Lines that are no answer before a session is stopped: nobody types there."""


class Console:
    """Prints each request to `output` and reads the answers, a line each, from `source`.

    Stimuli are rendered, held against the limits and named by their digest; nothing is emitted. A line that is no
    answer is asked again, up to `N_TRIES` times; the end of the input stops the session.
    """

    def __init__(
        self,
        bank: Mapping[str, Stimulus],
        limits: Limits,
        texts: Texts,
        source: TextIO | None = None,
        output: TextIO | None = None,
    ) -> None:
        self._bank = bank
        self._limits = limits
        self._texts = texts
        self._source = sys.stdin if source is None else source
        self._output = sys.stdout if output is None else output
        self._zero_s = time.perf_counter()
        self._tally = Tally()

    def facts(self) -> dict[str, str | int | float | bool | None]:
        clock = time.get_clock_info("perf_counter")
        return {
            "rig": "console",
            "clock": clock.implementation,
            "clock_resolution_s": clock.resolution,
            "terminal": self._source.isatty(),
        }

    def resume(self, trials: Sequence[Trial], elapsed_s: float) -> None:
        self._tally = tally(trials)
        self._zero_s = time.perf_counter() - elapsed_s

    def close(self) -> None:
        pass

    def _now_s(self) -> float:
        return round(time.perf_counter() - self._zero_s, 6)

    def _say(self, text: str) -> None:
        print(text, file=self._output, flush=True)

    def _ask(self, prompt: str, read: Callable[[str], object]) -> tuple[object, float, float]:
        """An answer, the onset of its question and its latency."""
        onset_s = self._now_s()
        for _ in range(N_TRIES):
            print(prompt, end=" ", file=self._output, flush=True)
            line = self._source.readline()
            if not line:
                raise Stopped(
                    f"the input ended in trial {self._tally.n_trials + 1}: what was recorded before is safe "
                    f"({self._tally}); go on with --resume"
                )
            try:
                return read(line.strip()), onset_s, round(self._now_s() - onset_s, 6)
            except ValueError:
                self._say(f"found {line.strip()!r}, expected an answer to: {prompt}")
        raise Stopped(
            f"{N_TRIES} lines in trial {self._tally.n_trials + 1} were no answers: what was recorded before is safe "
            f"({self._tally}); go on with --resume"
        )

    def _signal(self, stimulus: str, level: float | None) -> Signal | None:
        if level is None:
            return None
        signal = self._bank[stimulus].at(level)
        self._limits.check(signal)
        return signal

    def _present(self, what: str, interval: int | None) -> None:
        self._say(f"[trial {self._tally.n_trials + 1}] {what}" + (f", interval {interval}" if interval else ""))

    def play(self, request: Play) -> Played:
        signal = self._signal(request.stimulus, request.level)
        self._present(f"play for {request.duration_s:g} s", request.interval)
        return Played(self._now_s(), request.level, "" if signal is None else signal.digest())

    def press(self, request: Press) -> Touched:
        return self._touch(request, f"press with {request.target_n:g} N for {request.duration_s:g} s")

    def slide(self, request: Slide) -> Touched:
        speed_mm_per_s = 1e3 * request.speed_m_per_s
        return self._touch(
            request,
            f"slide with {request.target_n:g} N at {speed_mm_per_s:g} mm/s for {request.duration_s:g} s",
        )

    def _touch(self, request: Press | Slide, what: str) -> Touched:
        signal = self._signal(request.stimulus, request.level)
        self._present(what, request.interval)
        return Touched(self._now_s(), request.level, None if signal is None else signal.digest())

    def choose(self, request: Choose) -> Chosen:
        labels = [self._texts.label(label) for label in request.labels]
        words = ", ".join(f"{n} = {label}" for n, label in zip(request.options, labels, strict=True))
        question = self._texts.message(request.question)
        prompt = f"[trial {self._tally.n_trials + 1}] {question} ({words}):"
        option, onset_s, latency_s = self._ask(prompt, lambda line: _option(line, request.options, labels))
        assert isinstance(option, int)
        return Chosen(option, onset_s, latency_s, datetime.now(UTC).isoformat(timespec="milliseconds"))

    def rate(self, request: Rate) -> Rated:
        prompt = f"{request.item} ({request.low:g} = {request.low_label}, {request.high:g} = {request.high_label}):"
        value, onset_s, latency_s = self._ask(prompt, lambda line: _within(line, request.low, request.high))
        assert isinstance(value, float)
        return Rated(value, onset_s, latency_s, datetime.now(UTC).isoformat(timespec="milliseconds"))

    def enter(self, request: Enter) -> Rated:
        most = "" if request.high is None else f" to {request.high:g}"
        prompt = f"{self._texts.message(request.question)} (a number from {request.low:g}{most}):"
        high = LARGEST_ANSWER if request.high is None else request.high
        value, onset_s, latency_s = self._ask(prompt, lambda line: _within(line, request.low, high))
        assert isinstance(value, float)
        return Rated(value, onset_s, latency_s, datetime.now(UTC).isoformat(timespec="milliseconds"))

    def fill(self, request: Fill) -> Filled:
        onset_s = self._now_s()
        values = tuple(self._fill_one(request, question) for question in request.questions)
        utc = datetime.now(UTC).isoformat(timespec="milliseconds")
        return Filled(values, onset_s, round(self._now_s() - onset_s, 6), utc)

    def _fill_one(self, request: Fill, question: Question) -> float | None:
        statement, left, right = self._texts.question(question)
        prompt = f"{statement} ({request.low:g} = {left}, {request.high:g} = {right}; - leaves it open):".lstrip()
        value, _, _ = self._ask(prompt, lambda line: None if line == "-" else _on_scale(line, request))
        assert value is None or isinstance(value, float)
        return value

    def adjust(self, request: Adjust) -> Adjusted:
        prompt = f"level of {request.stimulus} ({request.low:g} to {request.high:g}):"
        level, onset_s, latency_s = self._ask(prompt, lambda line: _within(line, request.low, request.high))
        assert isinstance(level, float)
        return Adjusted(level, onset_s, latency_s, datetime.now(UTC).isoformat(timespec="milliseconds"))

    def wait(self, request: Wait) -> Done:
        time.sleep(request.duration_s)
        return Done(self._now_s())

    def show(self, request: Show) -> Done:
        self._say(self._texts.page(request, math.ceil(request.duration_s or 0)).strip())
        return Done(self._now_s())

    def record(self, request: Record) -> Done:
        self._tally = self._tally.after(request.trial)
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
