"""File output, which writes each signal exactly as it would be played."""

import time
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np

from ...errors import DeviceFailed, InvalidParameter, attempt
from ...files.durable import read_file
from ...files.samples import Npz, wav_of
from ...signal import Signal
from .gain import Gain, SignalChain
from .output import UnconnectedDriver


@dataclass(frozen=True)
class FileSettings:
    """Output to one numbered file per signal instead of a device.

    Files are 0001.npz and so on, with ``samples`` in V, ``rate_hz``, ``unit`` and ``digest``, or 0001.wav. A WAV file
    contains the same samples as 64-bit numbers in volt, and its rate must be a whole number.

    - `folder`: Folder of the files, one for each signal.
    - `format`: NumPy archives, or sound files of 64-bit numbers in volt.
    - `n_channels`: Number of channels of each signal. The default accepts any number.
    - `rate_hz`: Sampling rate of each signal. The default accepts any rate.
    """

    connected: ClassVar[bool] = False
    folder: str
    format: Literal["npz", "wav"] = "npz"
    n_channels: int | None = None
    rate_hz: float | None = None

    def driver(self, gain: Gain | None) -> "FileOutput":
        del gain
        return FileOutput(self)

    def chain(self) -> SignalChain:
        return SignalChain(f"file {self.folder}")


class FileOutput(UnconnectedDriver):
    """Output that writes each signal to a new file."""

    def __init__(self, settings: FileSettings) -> None:
        self.name = f"file {settings.folder}"
        self.n_channels, self.rate_hz = settings.n_channels, settings.rate_hz
        self._folder, self._format = Path(settings.folder), settings.format
        self._n_written = 0

    @property
    def identity(self) -> str:
        return f"file {self._folder.resolve()}"

    def facts(self) -> dict[str, str | int | float | None]:
        return {"n_files": self._n_written}

    def open(self) -> None:
        with attempt(self._folder, "cannot write", "a writable folder; nothing was played"):
            self._folder.mkdir(parents=True, exist_ok=True)
        self._n_written = sum(1 for _ in self._folder.glob(f"[0-9]*.{self._format}"))

    def final(self, signal: Signal) -> Signal:
        if self._format == "wav" and signal.rate_hz != round(signal.rate_hz):
            raise DeviceFailed(
                f"{self.name}: found a rate of {signal.rate_hz} Hz, expected a whole number for WAV; use npz instead"
            )
        return signal

    def play(self, signal: Signal) -> float:
        onset_s = time.perf_counter()
        path = self._folder / f"{self._n_written + 1:04d}.{self._format}"
        signal = self.final(signal)
        with attempt(path, "cannot write", "a new file"), path.open("xb") as file:
            if self._format == "wav":
                from scipy.io import wavfile

                wavfile.write(file, round(signal.rate_hz), np.ascontiguousarray(signal.samples.T))
            else:
                np.savez(file, samples=signal.samples, rate_hz=signal.rate_hz, unit=signal.unit, digest=signal.digest())
        self._n_written += 1
        return onset_s


def read_signal(path: Path) -> Signal:
    """Read a file written by a file output.

    Raises `InvalidFile` if the file is missing, `InvalidParameter` if it is not an NPZ or WAV file with samples.
    """
    content = read_file(path, "an NPZ or WAV file")
    try:
        if path.suffix == ".npz":
            file = Npz(content)
            return Signal(file["samples"], file.number("rate_hz"), file.words("unit"))
        rate_hz, frames = wav_of(content)
        return Signal(frames.T, rate_hz, "V")
    except (ValueError, TypeError) as error:
        raise InvalidParameter(f"{path}: cannot be read as a signal ({error}), expected an NPZ or WAV file") from None
