"""A journal that somebody else writes, followed as it grows: read-only, and each line is read once.

A journal that goes on with ``--resume`` may be shorter than it was, or another file under its name. What was read last
is read again with what is new: its checksum is that of all lines before it, so that nothing is taken for a continuation
that is none.
"""

import os
from dataclasses import dataclass, field
from pathlib import Path

from ..errors import InvalidFile
from .journal import Line, Reached, decode_on

Stamp = tuple[int, int, int]
"""Which file it is, how long, and when it was written last."""


@dataclass(frozen=True)
class News:
    """What came since the last look: its lines, whether they begin the journal `anew`, and whether it is `complete`."""

    lines: tuple[Line, ...]
    anew: bool
    complete: bool


@dataclass
class Follower:
    """Looks into a journal again and again.

    >>> Follower(Path("nowhere.jsonl")).news()
    Traceback (most recent call last):
    ...
    tactometry.errors.InvalidFile: nowhere.jsonl: cannot be read (No such file or directory), expected a journal
    """

    path: Path
    _place: Reached = field(default_factory=Reached, init=False)
    _last: bytes = field(default=b"", init=False)
    _stamp: Stamp | None = field(default=None, init=False)

    def news(self) -> News | None:
        """What is new since the last call; None where nothing is. After an error the next call begins anew.

        Raises `InvalidFile` if the journal cannot be read, or a line is damaged, with its number.
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
        with self.path.open("rb") as file:  # opened first: what is looked at is what is read, whatever has its name
            found = os.fstat(file.fileno())
            stamp = found.st_ino, found.st_size, found.st_mtime_ns
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
