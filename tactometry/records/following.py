"""Reader of a journal that another process writes: each line once.

A journal that is continued with ``--resume`` may be shorter than before, or another file. So the last line is read
again together with new lines: its checksum covers all lines before it.
"""

import os
from dataclasses import dataclass, field
from pathlib import Path

from ..errors import InvalidFile
from .journal import Line, Reached, decode_on

Stamp = tuple[int, int, int]
"""Identity, size and modification time of a file."""


@dataclass(frozen=True)
class News:
    """Lines since the last call.

    `anew` is True if they begin the journal, `complete` if the journal has ended.
    """

    lines: tuple[Line, ...]
    anew: bool
    complete: bool


@dataclass
class Follower:
    """Reader that reads a journal again and again."""

    path: Path
    _place: Reached = field(default_factory=Reached, init=False)
    _last: bytes = field(default=b"", init=False)
    _stamp: Stamp | None = field(default=None, init=False)

    def news(self) -> News | None:
        """Return the lines since the last call, or None.

        After an error the next call starts from the beginning. Raises `InvalidFile` if the journal cannot be read,
        or a line is damaged.
        """
        try:
            return self._look()
        except OSError as error:
            self._forget()
            raise InvalidFile(f"{self.path}: cannot be read ({error.strerror}), expected a journal") from None
        except InvalidFile:
            self._forget()
            raise

    def _look(self) -> News | None:
        with self.path.open("rb") as file:  # opened first, so that the checked file is the one that is read
            result = os.fstat(file.fileno())
            stamp = result.st_ino, result.st_size, result.st_mtime_ns
            if stamp == self._stamp:
                return None
            file.seek(self._place.n_bytes - len(self._last))
            content = file.read()
            if anew := not content.startswith(self._last):
                self._forget()
                file.seek(0)
                content = file.read()
        news = self._read(content.removeprefix(self._last), anew=anew or self._place.n_lines == 0)
        self._stamp = stamp
        return news if news.lines or news.anew or news.complete else None

    def _read(self, content: bytes, *, anew: bool) -> News:
        before = self._place
        lines, self._place = decode_on(content, self.path, before)
        n_bytes = self._place.n_bytes - before.n_bytes
        if n_bytes:
            self._last = content[content.rfind(b"\n", 0, n_bytes - 1) + 1 : n_bytes]
        return News(lines, anew, self._place.complete)

    def _forget(self) -> None:
        self._place, self._last, self._stamp = Reached(), b"", None
