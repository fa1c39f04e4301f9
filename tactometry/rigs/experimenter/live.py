"""Terminal with a status area: current trial, session status, typed line.

Messages are printed above the status area as whole lines. Keys are read singly and displayed here, because the
terminal's echo would appear at the cursor.
"""

import atexit
import codecs
import os
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from typing import Final, TextIO

from .terminal import ExperimenterTerminal, available

PROMPT: Final = "> "
ERASE_BELOW, REVERSE, USUAL = "\x1b[J", "\x1b[7m", "\x1b[0m"
BACK: Final = frozenset("\x7f\b")
CLEARS: Final = frozenset("\x15\x17")
"""Ctrl-U and Ctrl-W delete the whole line."""
USUAL_WIDTH: Final = 80


@dataclass(frozen=True)
class Typed:
    """Typed text, and whether an escape sequence (arrow key) is being skipped."""

    text: str = ""
    in_sequence: bool = False

    def after(self, key: str) -> tuple["Typed", str | None]:
        """Add a character. Return also the line if the character completes it."""
        if self.in_sequence and key not in "\r\n":
            return replace(self, in_sequence=not (key.isalpha() or key == "~")), None
        if key in "\r\n":
            return Typed(), self.text
        if key in BACK:
            return Typed(self.text[:-1]), None
        if key in CLEARS:
            return Typed(), None
        if key == "\x1b":
            return replace(self, in_sequence=True), None
        return (Typed(self.text + key) if key.isprintable() else self), None


def rows(trial: str, status: str, typed: str, width: int) -> tuple[str, ...]:
    """Return the bottom rows, cut to the width of the terminal."""
    room = max(width - 2, 1)  # a full row might wrap
    begun = status if len(status) <= room else f"{status[: room - 1]}…"
    upper = [_end(trial, room) if trial else "", f"{REVERSE}{begun}{USUAL}" if status else ""]
    return (*filter(None, upper), _end(f"{PROMPT}{typed}", room))


def _end(words: str, room: int) -> str:
    return words if len(words) <= room else f"…{words[-room + 1 :]}"


def has_status_area(source: TextIO | None, output: TextIO | None) -> bool:
    """Return True if the terminals have cursor control and single-key input."""
    if source is None or output is None or not (source.isatty() and output.isatty()):
        return False
    return sys.platform != "win32" and os.environ.get("TERM", "dumb") not in ("", "dumb")


def experimenter_terminal(source: TextIO, output: TextIO) -> ExperimenterTerminal:
    """Return the terminal of these files, with a status area if possible."""
    if not has_status_area(source, output):
        return ExperimenterTerminal(source, output)
    return LiveTerminal(source, output, [file for file in (1, 2) if os.isatty(file)])


class LiveTerminal(ExperimenterTerminal):
    """Terminal with a status area. Requires `has_status_area`."""

    def __init__(self, source: TextIO, output: TextIO, redirected_files: Sequence[int] = ()) -> None:
        self._drawing, self._n_rows, self._width = threading.RLock(), 0, USUAL_WIDTH
        self._trial, self._typed, self._opened = "", Typed(), ExitStack()
        self._decode = codecs.getincrementaldecoder("utf-8")("replace")
        self._kept_file = os.dup(output.fileno())  # keep the original files, as libraries' output is redirected below
        self._opened.callback(os.close, self._kept_file)
        self._opened.callback(one_by_one(source.fileno()))
        atexit.register(self.close)
        super().__init__(source, output)
        self._opened.callback(self._leave)
        for file in redirected_files:
            self._opened.enter_context(redirected(file, self.tell))  # until the last redirected output, before closing

    def _read(self, file: int) -> None:
        while data := available(file):
            for key in self._decode.decode(data):
                self._typed, line = self._typed.after(key)
                if line is not None:
                    self._lines.put(line)
            self._draw()

    def status(self, words: str) -> None:
        if words != self.status_text:
            super().status(words)
            self._draw()

    def add(self, words: str) -> None:
        self._trial = f"{self._trial} | {words}" if self._trial else words
        self._draw()

    def end_line(self) -> None:
        trial, self._trial = self._trial, ""
        if trial:
            self._draw(trial)

    def tell(self, words: str) -> None:
        self._draw(words)

    def _leave(self) -> None:
        with self._drawing:
            if self._output is not None:
                self._put(self._erased())
            self._output = None

    def _erased(self) -> str:
        return f"\r\x1b[{self._n_rows - 1}A{ERASE_BELOW}" if self._n_rows > 1 else f"\r{ERASE_BELOW}"

    def _draw(self, above: str | None = None) -> None:
        """Redraw the status area, and print a line above it."""
        with self._drawing:
            if self._output is None:
                return
            message = "" if above is None else f"{above}\n"
            try:
                width = os.get_terminal_size(self._kept_file).columns or USUAL_WIDTH
            except OSError:
                width = USUAL_WIDTH
            shown = rows(self._trial, self.status_text, self._typed.text, width)
            drawn = f"{self._erased()}{message}" + "\n".join(shown)
            self._n_rows = len(shown)
            self._put(drawn)

    def _put(self, words: str) -> None:
        data = words.encode("utf-8", "replace")
        try:
            while data:
                data = data[os.write(self._kept_file, data) :]
        except OSError:  # the terminal is gone, but the session goes on
            self._output = None

    def close(self) -> None:
        """Restore the terminal below the messages."""
        atexit.unregister(self.close)
        self.end_line()
        self._opened.close()


def one_by_one(file: int) -> Callable[[], None]:
    """Read single keys without echo. Return a function that restores the terminal."""
    import termios
    import tty

    before = termios.tcgetattr(file)
    tty.setcbreak(file, termios.TCSANOW)

    def restore() -> None:
        try:
            termios.tcsetattr(file, termios.TCSANOW, before)
        except (termios.error, OSError):  # the terminal is gone
            return

    return restore


@contextmanager
def redirected(file: int, tell: Callable[[str], None]) -> Iterator[None]:
    """Pass each line written to a file descriptor to `tell`."""
    before, (source, sink) = os.dup(file), os.pipe()
    listener = threading.Thread(target=_listen, args=(source, tell), name=f"messages {file}", daemon=True)
    os.dup2(sink, file)
    os.close(sink)
    listener.start()
    try:
        yield
    finally:
        os.dup2(before, file)  # closes the last writing end of the pipe, so that the reader ends
        os.close(before)
        listener.join(1.0)
        os.close(source)


def _listen(source: int, tell: Callable[[str], None]) -> None:
    rest = b""
    while data := available(source):
        *lines, rest = (rest + data).split(b"\n")
        for line in lines:
            _tell(line, tell)
    _tell(rest, tell)


def _tell(line: bytes, tell: Callable[[str], None]) -> None:
    words = "".join(letter for letter in line.decode("utf-8", "replace") if letter.isprintable() or letter == "\t")
    if words.strip():
        tell(words.rstrip())
