"""The experimenter's terminal: typed orders and printed messages."""

import math
import os
import queue
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, TextIO

from ...errors import InvalidParameter, count_of, nearest
from ...session.answer import Wanted
from ...session.event import Event
from ...session.progress import PartAhead, Progress
from ...session.request import Request
from ...trials.cells import cell
from ...trials.trial import Trial
from ..texts import phrases_in

Wish = Literal["pause", "go", "repeat", "note", "stop", "help"] | Wanted
KEYS: Final[dict[str, Wish]] = {
    "p": "pause",
    "g": "go",
    "r": "repeat",
    "i": "invalidate",
    "k": "skip",
    "b": "rest",
    "e": "end",
    "n": "note",
    "s": "stop",
    "?": "help",
}
WORDS: Final[dict[str, Wish]] = KEYS | {wish: wish for wish in KEYS.values()}
OF_TRIALS: Final = "p pause   g go on   r repeat this trial   i invalidate the last trial"
OF_SESSION: Final = "k skip this block   b rest   e end the session   n TEXT remark   s stop"
HELP: Final = f"{OF_TRIALS}   (return)\n{OF_SESSION}"
"""Help text, in lines shorter than 80 characters."""


@dataclass(frozen=True)
class Order:
    """Order of the experimenter. `text` is the text of a note."""

    wish: Wish
    text: str = ""


def order_of(line: str) -> Order:
    """Parse a typed line."""
    word, _, text = line.strip().partition(" ")
    wish = WORDS.get(word.casefold())
    if wish is None or bool(text.strip()) != (wish == "note"):
        raise InvalidParameter(
            f"found {line.strip()!r}, expected one of: {OF_TRIALS}   {OF_SESSION}{nearest(word, WORDS)}"
        )
    return Order(wish, text.strip())


class ExperimenterTerminal:
    """Reader of orders in a thread, and writer of messages.

    Without terminals it prints and reads nothing. `language` (two letters) applies to messages on touches and
    pauses.
    """

    def __init__(self, source: TextIO | None = None, output: TextIO | None = None, language: str = "en") -> None:
        self._phrases = phrases_in(language)
        self._output = output if output is not None and output.isatty() else None
        self._lines: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._fresh_line, self.status_text = True, ""
        if self._output is not None and source is not None and source.isatty():
            threading.Thread(target=self._read, args=(source.fileno(),), name="terminal", daemon=True).start()
            self.tell(HELP)

    def _read(self, file: int) -> None:
        rest = b""
        while data := available(file):
            *lines, rest = (rest + data).split(b"\n")
            for line in lines:
                self._lines.put(line.decode("utf-8", "replace"))

    def orders(self) -> list[Order]:
        """Return the orders typed since the last call. Answer other lines with a hint."""
        orders = []
        while not self._lines.empty():
            line = self._lines.get()
            try:
                orders.append(order_of(line))
            except InvalidParameter as error:
                self.tell(str(error))
        return orders

    def status(self, words: str) -> None:
        """Set the session status, displayed in a status area or on request."""
        self.status_text = words

    def add(self, words: str) -> None:
        self._write(words if self._fresh_line else f" | {words}")
        self._fresh_line = False

    def phrase(self, name: str, /, **values: str | float) -> str:
        """Return a text in this terminal's language, filled with `values`."""
        return self._phrases[name].format(**values)

    def say(self, phrase: str, /, **values: str | float) -> None:
        self.add(self.phrase(phrase, **values))

    def outcome(self, trial: Trial, n_announced: int) -> str:
        """Describe whether a trial counts.

        States the trial's number in the table if it differs from the announced number.
        """
        reason = trial.invalid_reason
        if trial.valid:
            text = self.phrase("valid")
        else:
            text = self.phrase("not_valid_why", reason=self.phrase(reason)) if reason else self.phrase("not_valid")
        if trial.trial == n_announced:
            return text
        return text + self.phrase(
            "place_again" if trial.attempt > 1 else "place", trial=trial.trial, attempt=trial.attempt
        )

    def end_line(self) -> None:
        self._write("" if self._fresh_line else "\n")
        self._fresh_line = True

    def tell(self, words: str) -> None:
        self.end_line()
        self._write(f"{words}\n")

    def close(self) -> None:
        self.end_line()

    def _write(self, words: str) -> None:
        if self._output is None:
            return
        try:
            print(words, end="", file=self._output, flush=True)
        except OSError:  # the terminal is gone, but the session goes on
            self._output = None


def available(file: int) -> bytes:
    """Wait for input on a file descriptor and return it; empty at its end."""
    try:
        return os.read(file, 4096)
    except OSError:
        return b""


def status_words(progress: Progress, parts: Sequence[PartAhead]) -> str:
    """Format the status line, most important part first.

    >>> status_words(Progress(), [PartAhead(n_trials=20, lasts_s=100.0)])
    'trial 1 of 20 · 2 min left · 0 false alarms of 0 · 0 frames dropped · 0 gaps'
    """
    n_trials = sum(part.n_trials for part in parts)
    n_next = min(progress.n_valid() + 1, max(n_trials, 1))
    n_aborted = len(progress.aborted)
    phrases = [
        "over" if progress.over else f"trial {n_next} of {n_trials}",
        f"{math.ceil(progress.left_s(parts) / 60)} min left",
        f"{n_aborted} aborted" if n_aborted else "",
        ", ".join(f"{name} {cell(level)}" for name, level in progress.factors.items()),
        *_track_words(progress),
        f"{count_of(progress.n_false_alarms, 'false alarm')} of {progress.n_catch}",
        f"{count_of(progress.n_dropped_frames, 'frame')} dropped",
        count_of(progress.n_gaps, "gap"),
    ]
    return " · ".join(filter(None, phrases))


def _track_words(progress: Progress) -> list[str]:
    track, last = progress.track, progress.last
    if track is None or last is None:
        return []
    level = "blank" if last.level is None else f"{last.level:g} {last.level_unit}"
    return [] if last.is_form else [f"last {level}", count_of(len(track.reversals), "reversal")]


class StatusLine:
    """Status of a session, followed and displayed on a terminal."""

    def __init__(self, terminal: ExperimenterTerminal, parts: Sequence[PartAhead]) -> None:
        self._terminal, self._parts, self._progress = terminal, parts, Progress()
        self._warned: str | None = None
        self._show(Progress())

    def on_request(self, request: Request[Any], answer: object) -> None:
        self._show(self._progress.after(request, answer))

    def on_event(self, event: Event) -> None:
        self._show(self._progress.after_event(event))

    def _show(self, progress: Progress) -> None:
        self._progress = progress
        self._terminal.status(status_words(progress, self._parts))
        warning = progress.warning(self._parts)
        if warning is not None and warning != self._warned:
            self._terminal.tell(f"! {warning}")
        self._warned = warning
