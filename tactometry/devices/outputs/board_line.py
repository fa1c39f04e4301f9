"""A line to a board that never makes anybody wait: a named pipe, a device node or a file, written without blocking."""

import contextlib
import errno
import os
import select
import stat
import sys
import threading
import time
from pathlib import Path
from typing import Final

from ...errors import DeviceFailed

LOOK_S: Final = 0.005
"""A line that takes nothing is looked at this often."""
_NEVER: Final = threading.Event()


class BoardLine:
    """An open line; `take_back` and `was_read` know of pipes alone, others are taken to pass on what they took."""

    def __init__(self, path: Path, file: int) -> None:
        self.path, self._file = path, file
        self._is_pipe = stat.S_ISFIFO(os.fstat(file).st_mode)

    def write(self, stream: bytes, within_s: float, until: threading.Event = _NEVER) -> int:
        """How many bytes the line took in a time, or before `until` was set.

        Raises
        ------
        DeviceFailed
            If the board went away.
        """
        end_s, sent = time.monotonic() + within_s, 0
        while sent < len(stream) and not until.is_set():
            n_taken = self._write_some(memoryview(stream)[sent:])
            sent += n_taken
            if n_taken == 0:
                if time.monotonic() > end_s:
                    break
                self._wait()
        return sent

    def _write_some(self, rest: memoryview) -> int:
        try:
            return os.write(self._file, rest)
        except BlockingIOError:
            return 0
        except OSError as error:
            raise DeviceFailed(f"{self.path}: the board took no more ({error.strerror}); the output stopped") from None

    def _wait(self) -> None:
        if os.name == "posix":
            select.select([], [self._file], [], LOOK_S)
        else:
            time.sleep(LOOK_S)

    def was_read(self, within_s: float) -> bool:
        """Whether a pipe is empty within a time: its reader has all that was written."""
        end_s = time.monotonic() + within_s
        while self._is_pipe and _n_unread(self._file) > 0:
            if time.monotonic() > end_s:
                return False
            time.sleep(LOOK_S / 5)
        return True

    def take_back(self) -> None:
        """Empty a pipe of what its reader has not read."""
        if not self._is_pipe:
            return
        with contextlib.ExitStack() as last_first, contextlib.suppress(OSError):
            own_end = os.open(self.path, os.O_RDONLY | os.O_NONBLOCK)
            last_first.callback(os.close, own_end)
            # an empty pipe that may still be written to raises BlockingIOError, which is the way out
            while os.read(own_end, 2**16):
                pass

    def close(self) -> None:
        os.close(self._file)


class Sending:
    """A stream that is being sent in a thread of its own; `failure` is what went wrong, unless it was ended."""

    def __init__(self, line: BoardLine, stream: bytes, within_s: float) -> None:
        self._line, self._stream, self._within_s = line, stream, within_s
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._send, name=f"sender to {line.path}", daemon=True)
        self.n_sent = 0
        self.failure: DeviceFailed | None = None
        self._thread.start()

    def _send(self) -> None:
        try:
            self.n_sent = self._line.write(self._stream, self._within_s, self._ending)
        except DeviceFailed as error:
            self.failure = error
            return
        if self.n_sent < len(self._stream) and not self._ending.is_set():
            self.failure = DeviceFailed(
                f"{self._line.path}: the board took {self.n_sent} of {len(self._stream)} bytes within "
                f"{self._within_s:.3g} s, expected all; restart the board"
            )

    def end(self, within_s: float) -> bool:
        """Send no more: whether the whole stream was sent.

        Raises
        ------
        DeviceFailed
            If the driver of the board holds a write up.
        """
        self._ending.set()
        self._thread.join(within_s)
        if self._thread.is_alive():
            raise DeviceFailed(f"{self._line.path}: its driver holds a write up: switch the amplifier off")
        return self.n_sent == len(self._stream)


def open_line(path: Path, within_s: float) -> BoardLine:
    """A line for appending; a pipe that nobody reads is waited for.

    Raises
    ------
    DeviceFailed
        If it cannot be written, or nobody reads it within `within_s`.
    """
    # without O_NONBLOCK the opening of a pipe that nobody reads blocks; O_NOCTTY: a serial node does not become the
    # terminal whose hang-up ends this process; Windows knows neither
    not_blocking = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0)
    flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | not_blocking
    end_s = time.monotonic() + within_s
    while True:
        try:
            return BoardLine(path, os.open(path, flags, 0o666))
        except OSError as error:
            nobody_reads = error.errno == errno.ENXIO and path.is_fifo()
            if not nobody_reads:
                raise DeviceFailed(
                    f"{path}: cannot open the board ({error.strerror}), expected a device, a pipe or a file that may "
                    "be written; nothing was played"
                ) from None
        if time.monotonic() > end_s:
            raise DeviceFailed(
                f"{path}: found nobody who reads this pipe within {within_s:g} s, expected the board to; start it "
                "first; nothing was played"
            )
        time.sleep(LOOK_S)


def _n_unread(pipe: int) -> int:
    """Bytes of a pipe that its reader has not read."""
    import fcntl
    import termios

    return int.from_bytes(fcntl.ioctl(pipe, termios.FIONREAD, bytes(4)), sys.byteorder)
