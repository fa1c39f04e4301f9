"""The experimenter's side: what is typed in the terminal while a session runs, and what is told there."""

import os
import queue
import threading
from dataclasses import dataclass
from typing import Final, Literal, TextIO

from ...errors import InvalidParameter, nearest
from ...session.intervention import Wanted
from ..texts import phrases_in

Wish = Literal["pause", "go", "repeat", "note", "stop", "help"] | Wanted
WORDS: Final[dict[str, Wish]] = {
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
    "pause": "pause",
    "go": "go",
    "repeat": "repeat",
    "invalidate": "invalidate",
    "skip": "skip",
    "rest": "rest",
    "end": "end",
    "note": "note",
    "stop": "stop",
    "help": "help",
}
OF_TRIALS: Final = "p pause   g go on   r repeat this trial   i invalidate the one before"
OF_SESSION: Final = "k skip this block   b rest   e end in good order   n TEXT remark   s stop"
HELP: Final = f"{OF_TRIALS}   (return)\n{OF_SESSION}"
"""On rows of less than 80 letters."""


@dataclass(frozen=True)
class Order:
    """What the experimenter wants; `text` of a note."""

    wish: Wish
    text: str = ""


def order_of(line: str) -> Order:
    """The order of a typed line.

    Raises `InvalidParameter` if it is none.

    >>> order_of("n moved the hand"), order_of(" P ")
    (Order(wish='note', text='moved the hand'), Order(wish='pause', text=''))
    """
    word, _, text = line.strip().partition(" ")
    wish = WORDS.get(word.casefold())
    if wish is None or bool(text.strip()) != (wish == "note"):
        raise InvalidParameter(
            f"found {line.strip()!r}, expected one of: {OF_TRIALS}   {OF_SESSION}{nearest(word, WORDS)}"
        )
    return Order(wish, text.strip())


class ExperimenterTerminal:
    """Reads orders from a terminal in a thread of its own, and writes to it; without terminals it is silent.

    Parameters
    ----------
    source, output : text file or None
        Used where they are terminals.
    language : str
        Of what is said of the touches of a trial and of pauses, its two letters.
    """

    def __init__(self, source: TextIO | None = None, output: TextIO | None = None, language: str = "en") -> None:
        self.phrases = phrases_in(language)
        self._output = output if output is not None and output.isatty() else None
        self._lines: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._fresh_line, self.standing = True, ""
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
        """What was typed since the last call; a line that is no order is answered with what would be one."""
        orders = []
        while not self._lines.empty():
            line = self._lines.get()
            try:
                orders.append(order_of(line))
            except InvalidParameter as error:
                self.tell(str(error))
        return orders

    def status(self, words: str) -> None:
        """Where the session stands: shown by a terminal on which a line can stand, told by the others when asked."""
        self.standing = words

    def add(self, words: str) -> None:
        """Some more words on the line of this trial."""
        self._write(words if self._fresh_line else f" | {words}")
        self._fresh_line = False

    def say(self, phrase: str, /, **values: str | float) -> None:
        """As `add`, by the name of the phrase."""
        self.add(self.phrases.of(phrase, **values))

    def end_line(self) -> None:
        """What follows stands on a new line."""
        self._write("" if self._fresh_line else "\n")
        self._fresh_line = True

    def tell(self, words: str) -> None:
        """A line of its own."""
        self.end_line()
        self._write(f"{words}\n")

    def close(self) -> None:
        """What follows is of others."""
        self.end_line()

    def _write(self, words: str) -> None:
        if self._output is None:
            return
        try:
            print(words, end="", file=self._output, flush=True)
        except OSError:  # the terminal is gone, the session is not
            self._output = None


def available(file: int) -> bytes:
    """What can be read of a file by its number, as soon as there is some; nothing at its end."""
    try:
        return os.read(file, 4096)
    except OSError:
        return b""
