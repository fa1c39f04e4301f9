"""An output of packed one-bit streams: to a file, a named pipe, or the device node of a board."""

import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Final

import numpy as np

from ...arguments.require import positive, whole
from ...errors import DeviceFailed, InvalidParameter
from ...signal import Signal
from .bit_stream import decode, encode, stop_stream
from .board_line import BoardLine, Sending, open_line
from .gain import Gain, SignalChain, required_gain
from .output import Driver

OPEN_WITHIN_S: Final = 5.0
"""A board that does not read yet is waited for."""
AGAIN_WITHIN_S: Final = 0.5
"""The same, where it read before."""
SEND_BESIDE_S: Final = 1.0
"""A board takes a stream in the time that it lasts and this (unverified default)."""
STOP_WITHIN_S: Final = 0.25
"""A board that has not read a stop by then hangs (unverified default)."""


@dataclass(frozen=True)
class PackedSettings:
    """`path` is opened for appending; `rate_hz` and `n_channels` are the board's.

    `electrode` is the channel (from 0) that leads to an electrode, where one does; the others lead to transducers.
    With ``gain`` a bit of 1 is 1 unit: ``volts_per_unit * amplifier_gain`` is what a board's supply puts on a load.
    """

    connected: ClassVar[bool] = True
    path: str
    n_channels: int
    rate_hz: float
    electrode: int | None = None

    def __post_init__(self) -> None:
        positive("PackedSettings", n_channels=self.n_channels, rate_hz=self.rate_hz)
        if self.electrode is not None:
            whole("PackedSettings", lowest=0, highest=self.n_channels - 1, electrode=self.electrode)

    def driver(self, gain: Gain | None) -> "PackedOutput":
        return PackedOutput(self, required_gain(gain, "output.gain"))

    def chain(self) -> SignalChain:
        return SignalChain(f"packed {self.path}")


class PackedOutput(Driver):
    """Writes one stream per signal, and a stream of no samples to stop; the form is that of `devices.packed`.

    Streams are sent in a thread of their own, and nothing waits for a board that hangs: a stop ends what is being sent,
    and is over within twice `STOP_WITHIN_S`, whatever the board does. What it had not read is then taken back, and its
    line is closed, so that it finds the end of the file when it wakes up: no stream, and nothing to play.
    """

    connected = True
    one_bit = True

    def __init__(self, settings: PackedSettings, gain: Gain) -> None:
        self.name = f"packed {settings.path}"
        self.n_channels: int = settings.n_channels
        self.rate_hz: float = settings.rate_hz
        self.full_scale_v: float = gain.load_volts_per_unit
        self._path, self._gain = Path(settings.path), gain
        self._line: BoardLine | None = None
        self._is_open = False
        self._turn = threading.Lock()
        self._sending: Sending | None = None
        self._kept: tuple[Signal, bytes] | None = None
        self._n_bytes = 0

    def facts(self) -> dict[str, str | int | float | None]:
        return {"n_bytes": self._n_bytes + (0 if self._sending is None else self._sending.n_sent)}

    def open(self) -> None:
        """Wait for the board to read, and tell it to stop.

        Raises
        ------
        DeviceFailed
            If it cannot be opened, nobody reads within `OPEN_WITHIN_S`, or it does not take the stop.
        """
        self._line = open_line(self._path, OPEN_WITHIN_S)
        self._is_open = True
        self.stop()

    def final(self, signal: Signal) -> Signal:
        """What comes out of the bits again; every voltage is that of the supply, or 0 where a channel is off."""
        try:
            emitted = decode(self._stream_of(signal))
        except InvalidParameter as error:
            raise DeviceFailed(f"output {self.name!r}: {error}; nothing was played") from None
        supply_v = self._gain.load_volts_per_unit
        # a signal of no samples is "stop" and has no voltage; 1e-9: the supply is a product, the level may be another
        if signal.samples.size and abs(signal.peak - supply_v) > 1e-9 * supply_v:
            raise DeviceFailed(
                f"output {self.name!r}: found a signal of {signal.peak:.6g} V, expected the {supply_v:.6g} V of the "
                "supply, which one bit cannot scale; take foci or amplitude_modulated, whose level a bench makes by "
                "bursts and pulses; nothing was played"
            )
        return Signal(np.sign(emitted.samples) * supply_v, emitted.rate_hz, "V")

    def _stream_of(self, signal: Signal) -> bytes:
        """The stream of a signal; the last one is kept, so that `play` begins at once."""
        if self._kept is None or self._kept[0] is not signal:
            self._kept = signal, encode(signal)
        return self._kept[1]

    def play(self, signal: Signal) -> float:
        self.final(signal)  # for what it refuses
        if not self._is_open:
            raise DeviceFailed(f"output {self.name!r}: it is closed, nothing was played; open it first")
        with self._turn:
            self._finish()
            # a stop that the board did not read has let its line go
            self._line = self._line or open_line(self._path, AGAIN_WITHIN_S)
            onset_s = time.perf_counter()
            self._sending = Sending(self._line, self._stream_of(signal), signal.duration_s + SEND_BESIDE_S)
        return onset_s

    def _finish(self) -> None:
        """End what is being sent; a line with a torn stream is let go."""
        sending, self._sending = self._sending, None
        if sending is None:
            return
        whole = sending.end(STOP_WITHIN_S)
        self._n_bytes += sending.n_sent
        if not whole:
            self._let_go()
        if sending.failure is not None:
            raise sending.failure

    def stop(self) -> None:
        """Zero now, within twice `STOP_WITHIN_S`.

        Raises
        ------
        DeviceFailed
            If the board has not read the stop by then, or had not taken what was played before.
        """
        with self._turn:
            self._finish()
            if self._line is not None:
                self._stop_board(self._line)

    def _stop_board(self, line: BoardLine) -> None:
        stream = stop_stream(self.n_channels, self.rate_hz)
        n_sent = line.write(stream, STOP_WITHIN_S)
        self._n_bytes += n_sent
        if n_sent == len(stream) and line.was_read(STOP_WITHIN_S):
            return
        self._let_go()
        raise DeviceFailed(
            f"{self._path}: the board did not read a stop within {STOP_WITHIN_S:g} s: switch its amplifier off; "
            "what it had not read was taken back, and its line is closed"
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
            line, self._line = self._line, None
            if line is not None:
                line.close()
