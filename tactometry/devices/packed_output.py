"""An output of packed one-bit streams: to a file, a named pipe, or the device node of a board."""

import time
from dataclasses import dataclass
from pathlib import Path
from typing import IO, ClassVar

import numpy as np

from tactometry.devices.gain import Gain, SignalChain, stated
from tactometry.devices.packed import decode, encode, stop_stream
from tactometry.errors import DeviceFailed, InvalidParameter
from tactometry.require import positive
from tactometry.signal import Signal


@dataclass(frozen=True)
class PackedSettings:
    """`path` is opened for appending; `rate_hz` and `n_channels` are the board's.

    With ``gain`` a bit of 1 is 1 unit: ``volts_per_unit * amplifier_gain`` is what a board's supply puts on a load.
    """

    connected: ClassVar[bool] = True
    path: str
    n_channels: int
    rate_hz: float

    def __post_init__(self) -> None:
        positive("PackedSettings", n_channels=self.n_channels, rate_hz=self.rate_hz)

    def driver(self, gain: Gain | None) -> "PackedOutput":
        return PackedOutput(self, stated(gain, "output.gain"))

    def chain(self) -> SignalChain:
        return SignalChain(f"packed {self.path}")


class PackedOutput:
    """Writes one stream per signal, and a stream of no samples to stop; the form is that of `devices.packed`."""

    connected = True
    one_bit = True

    def __init__(self, settings: PackedSettings, gain: Gain) -> None:
        self.name = f"packed {settings.path}"
        self.n_channels: int = settings.n_channels
        self.rate_hz: float = settings.rate_hz
        self.limits = None
        self.full_scale_v: float = gain.load_volts_per_unit
        self._path, self._gain = Path(settings.path), gain
        self._sink: IO[bytes] | None = None
        self._n_bytes = 0

    def facts(self) -> dict[str, str | int | float | None]:
        return {"n_bytes": self._n_bytes}

    def open(self) -> None:
        try:
            self._sink = self._path.open("ab", buffering=0)
        except OSError as error:
            raise DeviceFailed(
                f"{self._path}: cannot open the board ({error.strerror}), expected a device, a pipe or a file that may "
                "be written; nothing was played"
            ) from None
        self.stop()

    def final(self, signal: Signal) -> Signal:
        """What comes out of the bits again; every voltage is that of the supply."""
        try:
            emitted = decode(encode(signal))
        except InvalidParameter as error:
            raise DeviceFailed(f"output {self.name!r}: {error}; nothing was played") from None
        supply_v = self._gain.load_volts_per_unit
        if signal.samples.size and abs(signal.peak - supply_v) > 1e-9 * supply_v:
            raise DeviceFailed(
                f"output {self.name!r}: found a signal of {signal.peak:.6g} V, expected the {supply_v:.6g} V of the "
                "supply, which one bit cannot scale; nothing was played"
            )
        return Signal(np.sign(emitted.samples) * supply_v, emitted.rate_hz, "V")

    def play(self, signal: Signal) -> float:
        self.final(signal)
        onset_s = time.perf_counter()
        self._write(encode(signal))
        return onset_s

    def stop(self) -> None:
        if self._sink is not None:
            self._write(stop_stream(self.n_channels, self.rate_hz))

    def close(self) -> None:
        try:
            self.stop()
        finally:
            sink, self._sink = self._sink, None
            if sink is not None:
                sink.close()

    def _write(self, stream: bytes) -> None:
        if self._sink is None:
            raise DeviceFailed(f"output {self.name!r}: it is closed, nothing was played; open it first")
        view = memoryview(stream)
        try:
            while view:
                view = view[self._sink.write(view) or 0 :]
        except OSError as error:
            raise DeviceFailed(f"{self._path}: the board took no more ({error.strerror}); the output stopped") from None
        self._n_bytes += len(stream)
