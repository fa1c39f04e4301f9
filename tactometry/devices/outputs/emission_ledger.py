"""Ledger of emissions of each output across sessions and processes.

It is an SQLite database in the user's account, whose locks serve all processes. A row is written before its signal
begins, so that it counts even if the process is killed.
"""

import math
import os
import sqlite3
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from ...errors import DeviceFailed
from ...files.durable import make_folder, open_private
from ...safety.limits import LONGEST_WINDOW_S
from ..clock_map import boot_clock_s, boot_id

Emissions = tuple[tuple[float, float], ...]
"""Time since the beginning of each signal, and its duration, s."""
NAME: Final = "outputs.sqlite3"
LONGEST_WAIT_S: Final = 1.0
"""Longest wait for another process that writes (unverified default)."""
_TABLE: Final = (
    "CREATE TABLE IF NOT EXISTS emissions (id INTEGER PRIMARY KEY, output TEXT NOT NULL, opened TEXT NOT NULL, "
    "boot_id TEXT NOT NULL, boot_s REAL NOT NULL, utc_s REAL NOT NULL, duration_s REAL NOT NULL)"
)


def default_path() -> Path:
    """Return the path of the database in the account's state folder."""
    import platformdirs  # imported only if an output is opened

    return platformdirs.user_state_path("tactometry", appauthor=False) / NAME


@dataclass(frozen=True)
class Moment:
    """Time on the clock since boot and on the wall clock.

    >>> played = Moment("monday", boot_s=100.0, utc_s=1000.0)
    >>> played.ago_s(Moment("monday", boot_s=103.0, utc_s=5000.0))  # the wall clock was set ahead
    3.0
    >>> played.ago_s(Moment("tuesday", boot_s=20.0, utc_s=1060.0))  # the computer was restarted
    60.0
    >>> played.ago_s(Moment("tuesday", boot_s=20.0, utc_s=900.0))  # and its wall clock was set back
    20.0
    """

    boot_id: str
    boot_s: float
    utc_s: float

    @classmethod
    def now(cls) -> "Moment":
        return cls(boot_id(), boot_clock_s(), time.time())

    def ago_s(self, now: "Moment") -> float:
        """Return the time elapsed until `now`, s.

        It is measured on the clock since boot. After a restart it is the difference of the wall clocks, but at least
        the time since boot.
        """
        if self.boot_id == now.boot_id and self.boot_s <= now.boot_s:
            return now.boot_s - self.boot_s
        return max(now.utc_s - self.utc_s, now.boot_s)


class Ledger:
    """Ledger of one output, in the database at `path`."""

    def __init__(self, path: Path) -> None:
        self._path, self._output, self._opened = path, "", ""
        self._database: sqlite3.Connection | None = None
        self._turn = threading.Lock()
        self._last: tuple[int, Moment, float] | None = None

    def open(self, output: str) -> None:
        """Start counting for an output, and delete rows that no window includes."""
        make_folder(self._path.parent)
        self._output, self._opened, self._last = output, uuid.uuid4().hex, None
        with self._turn, self._connected() as database:
            database.execute(_TABLE)
            now = Moment.now()
            rows = _rows(database, "TRUE")
            old = [(row,) for row, begin, duration_s in rows if begin.ago_s(now) - duration_s > LONGEST_WINDOW_S]
            database.executemany("DELETE FROM emissions WHERE id = ?", old)

    @property
    def is_open(self) -> bool:
        return self._database is not None

    def add(self, duration_s: float, allow: Callable[[Emissions], None]) -> None:
        """Count a signal of `duration_s` that is about to begin.

        `allow` receives the emissions counted by other ledgers and processes. If it raises an error, nothing is
        counted. Raises `DeviceFailed` if the database cannot be written or is damaged.
        """
        with self._turn:
            with self._connected() as database:
                now = Moment.now()
                others = _rows(database, "output = ? AND opened != ?", self._output, self._opened)
                allow(tuple((begin.ago_s(now), lasted_s) for _, begin, lasted_s in others))
                self._shorten(database, now)  # the new signal replaces the last one
                row = (self._output, self._opened, now.boot_id, now.boot_s, now.utc_s, duration_s)
                columns = "output, opened, boot_id, boot_s, utc_s, duration_s"
                added = database.execute(f"INSERT INTO emissions ({columns}) VALUES (?, ?, ?, ?, ?, ?)", row)
            # set after the commit, as another process may reuse the number of an uncommitted row
            self._last = (added.lastrowid or 0, now, duration_s)

    def end(self, late_s: float) -> None:
        """Record that the last signal ends `late_s` from now.

        `late_s` is the duration of the device's buffer. If the database cannot be written, the whole signal counts.
        """
        with suppress(DeviceFailed), self._turn:
            if self._last is not None:
                with self._connected() as database:
                    self._shorten(database, Moment.now(), late_s)
                self._last = None

    def _shorten(self, database: sqlite3.Connection, now: Moment, late_s: float = 0.0) -> None:
        if self._last is not None:
            row, begin, duration_s = self._last
            played_s = min(begin.ago_s(now) + late_s, duration_s)
            database.execute("UPDATE emissions SET duration_s = ? WHERE id = ?", (played_s, row))

    def close(self) -> None:
        with self._turn:
            if self._database is not None:
                self._database.close()
            self._database = None

    @contextmanager
    def _connected(self) -> Iterator[sqlite3.Connection]:
        """Open one exclusive transaction."""
        try:
            if self._database is None:
                self._database = self._connect()
            self._database.execute("BEGIN IMMEDIATE")
            try:
                yield self._database
                self._database.execute("COMMIT")
            finally:
                if self._database.in_transaction:  # a full disk has already ended the transaction
                    self._database.execute("ROLLBACK")
        except sqlite3.Error as error:
            raise DeviceFailed(
                f"{self._path}: cannot store the playing times of outputs ({error}), expected a writable "
                "database; make it writable, or delete it after the longest duty_window_s; nothing was played"
            ) from None

    def _connect(self) -> sqlite3.Connection:
        os.close(open_private(self._path, os.O_RDWR))
        database = sqlite3.connect(self._path, LONGEST_WAIT_S, isolation_level=None, check_same_thread=False)
        # a killed process loses nothing; after a power failure nothing plays at once
        database.execute("PRAGMA synchronous = OFF")
        return database


def _rows(database: sqlite3.Connection, where: str, *values: str) -> list[tuple[int, Moment, float]]:
    """Return id, begin and duration of the rows that meet a condition.

    Raises `sqlite3.DatabaseError` unless all are finite numbers.
    """
    query = f"SELECT id, duration_s, boot_s, utc_s, boot_id FROM emissions WHERE {where}"
    rows = database.execute(query, values).fetchall()
    for row, *numbers, _ in rows:
        if not all(isinstance(number, float) and math.isfinite(number) for number in numbers) or numbers[0] < 0:
            raise sqlite3.DatabaseError(f"emissions, row {row}: found {numbers}, expected finite numbers")
    return [(row, Moment(name, boot_s, utc_s), duration_s) for row, duration_s, boot_s, utc_s, name in rows]
