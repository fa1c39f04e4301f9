"""Packed one-bit streams to a file, a pipe or the device of a board.

The data are written without blocking, in a separate thread.
"""

import contextlib
import errno
import functools
import os
import select
import stat
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar, Final

import numpy as np
from annotated_types import Interval

from ...arguments.constraints import Positive, constrained
from ...arguments.require import expect, whole
from ...errors import DeviceFailed, InvalidParameter
from ...safety.limits import STOP_WITHIN_S
from ...signal import Signal
from .bit_stream import MOST_CHANNELS, decode, encode, stop_stream
from .gain import Gain, SignalChain, required_gain
from .output import LONGEST_WORD_S, AmplifiedDriver

OPEN_WITHIN_S: Final = 5.0
"""Longest wait for a board to begin reading."""
AGAIN_WITHIN_S: Final = 0.5
"""Longest wait for a board that has read before."""
SEND_EXTRA_S: Final = 1.0
"""Time limit for sending a stream, in addition to its duration (unverified default)."""
TAKE_EXTRA_S: Final = 0.5
"""A board that has not read a complete stream this long after its end has not played it (unverified default)."""
LOOK_S: Final = 0.005
"""Polling interval of a full line."""
READ_WITHIN_S: Final = STOP_WITHIN_S - 2 * LOOK_S
"""Time limit for a board to read a stop. It allows one more poll each for earlier data and for the stop."""
_NEVER: Final = threading.Event()


class BoardLine:
    """Open line to a board. Only pipes report unread data and can be emptied."""

    def __init__(self, path: Path, file: int) -> None:
        self.path, self._file = path, file
        self._is_pipe = stat.S_ISFIFO(os.fstat(file).st_mode)

    def write(self, stream: bytes, within_s: float, until: threading.Event = _NEVER) -> int:
        """Return the bytes accepted within a time, or before `until` was set.

        Raises `DeviceFailed` if the board no longer accepts data.
        """
        end_s, sent = time.monotonic() + within_s, 0
        while sent < len(stream) and not until.is_set():
            n_taken = self._write_some(memoryview(stream)[sent:])
            sent += n_taken
            if n_taken == 0:
                if time.monotonic() > end_s:
                    break
                if os.name == "posix":
                    select.select([], [self._file], [], LOOK_S)
                else:
                    time.sleep(LOOK_S)
        return sent

    def _write_some(self, rest: memoryview) -> int:
        try:
            return os.write(self._file, rest)
        except BlockingIOError:
            return 0
        except OSError as error:
            raise DeviceFailed(
                f"{self.path}: the board accepts no more data ({error.strerror}); the output stopped"
            ) from None

    def was_read(self, within_s: float) -> bool:
        """Return True once a pipe is empty, False after `within_s`."""
        end_s = time.monotonic() + within_s
        while self._is_pipe and _n_unread(self._file) > 0:
            if time.monotonic() > end_s:
                return False
            time.sleep(LOOK_S / 5)
        return True

    def take_back(self) -> None:
        """Remove unread data from a pipe."""
        if not self._is_pipe:
            return
        with contextlib.ExitStack() as last_first, contextlib.suppress(OSError):
            own_end = os.open(self.path, os.O_RDONLY | os.O_NONBLOCK)
            last_first.callback(os.close, own_end)
            # an empty pipe with a writer raises BlockingIOError, which ends the loop
            while os.read(own_end, 2**16):
                pass

    def close(self) -> None:
        os.close(self._file)


class Sending:
    """Stream that is sent in a thread, and its `failure`."""

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
                f"{self._line.path}: the board accepted {self.n_sent} of {len(self._stream)} bytes within "
                f"{self._within_s:.3g} s, expected all; restart the board"
            )

    def is_whole(self, within_s: float) -> bool:
        self._thread.join(within_s)
        return self.n_sent == len(self._stream)

    def end(self, within_s: float) -> bool:
        """Stop sending. Return True if the whole stream was sent.

        Raises `DeviceFailed` if the driver of the board blocks a write.
        """
        self._ending.set()
        self._thread.join(within_s)
        if self._thread.is_alive():
            raise DeviceFailed(f"{self._line.path}: the driver of the board blocks a write; switch the amplifier off")
        return self.n_sent == len(self._stream)


def open_line(path: Path, within_s: float) -> BoardLine:
    """Open a line for appending. Waits for the reader of a pipe.

    Raises `DeviceFailed` if the path cannot be written, or has no reader within `within_s`.
    """
    # without O_NONBLOCK, opening a pipe without a reader blocks; with O_NOCTTY, a serial node does not become the
    # terminal whose hang-up ends this process; Windows has neither
    not_blocking = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0)
    flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | not_blocking
    end_s = time.monotonic() + within_s
    while True:
        try:
            file = os.open(path, flags, 0o666)
            # raw mode, as a terminal would add carriage returns to line feeds
            if os.name == "posix" and os.isatty(file):
                import tty

                tty.setraw(file)
            return BoardLine(path, file)
        except OSError as error:
            has_no_reader = error.errno == errno.ENXIO and path.is_fifo()
            if not has_no_reader:
                raise DeviceFailed(
                    f"{path}: cannot open the board ({error.strerror}), expected a writable device, "
                    "pipe or file; nothing was played"
                ) from None
        if time.monotonic() > end_s:
            raise DeviceFailed(
                f"{path}: found no reader of this pipe within {within_s:g} s, expected the board; start it first; "
                "nothing was played"
            )
        time.sleep(LOOK_S)


def _n_unread(pipe: int) -> int:
    import fcntl
    import termios

    return int.from_bytes(fcntl.ioctl(pipe, termios.FIONREAD, bytes(4)), sys.byteorder)


@dataclass(frozen=True)
@constrained
class PackedSettings:
    """Settings of a one-bit board.

    With ``gain`` a bit of 1 is 1 unit: the supply of the board applies ``volts_per_unit * amplifier_gain`` to a load.

    - `path`: Device node, named pipe or file, opened for appending.
    - `n_channels`: Number of channels of the board.
    - `rate_hz`: Clock rate of the board, and therefore of the stimulus.
    - `electrode`: Channel, from 0, that is connected to an electrode. The other channels are connected to transducers.
    - `lowest_supply_v`: Lowest supply voltage that the board can set for a stream. Without it the supply is fixed.
    """

    connected: ClassVar[bool] = True
    path: str
    n_channels: Annotated[int, Interval(ge=1, le=MOST_CHANNELS)]
    rate_hz: Positive
    electrode: int | None = None
    lowest_supply_v: Positive | None = None

    def __post_init__(self) -> None:
        if self.electrode is not None:
            whole("PackedSettings", lowest=0, highest=self.n_channels - 1, electrode=self.electrode)

    def driver(self, gain: Gain | None) -> "PackedOutput":
        return PackedOutput(self, required_gain(gain, "output.gain"))

    def chain(self) -> SignalChain:
        return SignalChain(f"packed {self.path}")


class PackedOutput(AmplifiedDriver):
    """Output that writes a stream per signal, and an empty one to stop.

    A stop aborts the sending of a stream and returns within `STOP_WITHIN_S`, whatever the board does. Unread data
    are then removed and the line is closed, so that a board that recovers finds nothing to play.
    """

    one_bit = True

    def __init__(self, settings: PackedSettings, gain: Gain) -> None:
        super().__init__(f"packed {settings.path}", settings.n_channels, settings.rate_hz, gain)
        self._lowest_v = self.full_scale_v if settings.lowest_supply_v is None else settings.lowest_supply_v
        supply = f"at most the {self.full_scale_v:.6g} V of the supply"
        expect(self._lowest_v <= self.full_scale_v, "output.lowest_supply_v", f"{self._lowest_v:.6g} V", supply)
        self._path = Path(settings.path)
        self._line: BoardLine | None = None
        self._is_open = False
        self._turn = threading.Lock()
        self._sending: Sending | None = None
        self._stream_of = functools.lru_cache(maxsize=1)(encode)
        """Stream of a signal, cached for the last one, so that `play` begins at once."""
        self._n_bytes, self._over_s, self._is_torn = 0, 0.0, False

    @property
    def identity(self) -> str:
        return f"packed {self._path.resolve()}"

    def facts(self) -> dict[str, str | int | float | None]:
        return {"n_bytes": self._n_bytes + (0 if self._sending is None else self._sending.n_sent)}

    @property
    def stop_delay_s(self) -> float:
        return STOP_WITHIN_S

    def open(self) -> None:
        """Wait for the board to read, and stop it.

        Raises `DeviceFailed` if the board cannot be opened, does not read within `OPEN_WITHIN_S`, or does not accept
        the stop.
        """
        self._line = open_line(self._path, OPEN_WITHIN_S)
        self._is_open = True
        self.stop()

    def final(self, signal: Signal) -> Signal:
        """Return the decoded bits at the voltage of the supply."""
        try:
            emitted = decode(self._stream_of(signal))
        except InvalidParameter as error:
            raise DeviceFailed(f"output {self.name!r}: {error}; nothing was played") from None
        if signal.samples.size:  # a signal without samples means "stop" and has no voltage
            self._check_supply(signal.peak)
        supply_v = min(max(signal.peak, self._lowest_v), self.full_scale_v)
        return Signal(np.sign(emitted.samples) * supply_v, emitted.rate_hz, "V")

    def _check_supply(self, peak_v: float) -> None:
        # 1e-9 allows for rounding in the products of supply and level
        if self._lowest_v * (1 - 1e-9) <= peak_v <= self.full_scale_v * (1 + 1e-9):
            return
        fixed = self._lowest_v == self.full_scale_v
        supply = f"{self.full_scale_v:.6g} V" if fixed else f"{self._lowest_v:.6g} to {self.full_scale_v:.6g} V"
        raise DeviceFailed(
            f"output {self.name!r}: found a signal of {peak_v:.6g} V, expected the {supply} of the supply, because "
            "one-bit samples cannot be scaled; use foci or amplitude_modulated; nothing was played"
        )

    def play(self, signal: Signal) -> float:
        self.final(signal)  # raises for refused signals
        if not self._is_open:
            raise DeviceFailed(f"output {self.name!r}: found a closed output, expected an open one; nothing was played")
        with self._turn:
            self._end_whole()
            # the line is closed if the board did not read the last stop
            self._line = self._line or open_line(self._path, AGAIN_WITHIN_S)
            onset_s = time.perf_counter()
            self._over_s, self._is_torn = onset_s + signal.duration_s, False
            self._sending = Sending(self._line, self._stream_of(signal), signal.duration_s + SEND_EXTRA_S)
        return onset_s

    def _end_whole(self) -> None:
        """Finish the last stream before another. Unread data were not played."""
        before, is_over = self._sending, time.perf_counter() >= self._over_s
        self._finish(READ_WITHIN_S)
        if before is None:
            return
        if is_over and self._line is not None and not self._line.was_read(TAKE_EXTRA_S):
            self._is_torn = True
            self._let_go()
        if self._is_torn:
            raise DeviceFailed(
                f"{self._path}: the board had not read a whole stream when the next stream began, so that it "
                "was not played; restart the board"
            )

    def _finish(self, within_s: float) -> None:
        """Stop sending. Close the line if the stream is incomplete."""
        sending, self._sending = self._sending, None
        if sending is None:
            return
        whole = sending.end(within_s)
        self._n_bytes += sending.n_sent
        self._is_torn = not whole and time.perf_counter() >= self._over_s
        if not whole:
            self._let_go()
        if sending.failure is not None:
            raise sending.failure

    def n_gaps(self, longest_wait_s: float = LONGEST_WORD_S) -> int | None:
        """Return 1 if the board did not read its stream in time."""
        sending, line = self._sending, self._line
        if sending is not None and line is not None and time.perf_counter() >= self._over_s:
            within_s = max(longest_wait_s, TAKE_EXTRA_S)
            self._is_torn = not (sending.is_whole(within_s) and line.was_read(within_s))
        return int(self._is_torn)

    def stop(self) -> None:
        """Stop within `STOP_WITHIN_S`.

        Raises `DeviceFailed` if the board has not read the stop by then, or has not accepted the last stream.
        """
        end_s = time.monotonic() + READ_WITHIN_S
        with self._turn:
            self._finish(end_s - time.monotonic())
            if self._line is not None:
                self._stop_board(self._line, end_s)

    def _stop_board(self, line: BoardLine, end_s: float) -> None:
        stream = stop_stream(self.n_channels, self.rate_hz)
        n_sent = line.write(stream, end_s - time.monotonic())
        self._n_bytes += n_sent
        if n_sent == len(stream) and line.was_read(end_s - time.monotonic()):
            return
        self._let_go()
        raise DeviceFailed(
            f"{self._path}: the board did not read the stop command within {READ_WITHIN_S:g} s; "
            "switch its amplifier off. Its unread data were discarded and the connection is closed"
        )

    def _let_go(self) -> None:
        line, self._line = self._line, None
        if line is not None:
            line.take_back()
            line.close()

    def close(self) -> None:
        try:
            self.stop()
        finally:
            self._is_open = False
            self._let_go()
