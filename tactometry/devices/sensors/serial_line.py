"""A sensor on a serial line, in the frames of `devices.framing` (extra: serial)."""

import os
import select
from dataclasses import dataclass
from typing import Any

from ...arguments.annotations import Positive, PositiveWhole
from ...arguments.constraints import constrained
from ...errors import DeviceFailed, library_needed
from .counted_samples import CountedSamples
from .framing import Framing
from .reader import POLL_S, SampleBlock, SensorSettings, Source, now_s

LARGEST_READ = 65_536


@dataclass(frozen=True)
@constrained
class SerialSettings(SensorSettings):
    """A serial line: `port` such as ``/dev/ttyACM0`` or ``COM3``; `rate_hz` is what the device states.

    Parameters
    ----------
    port : str
        Such as ``/dev/ttyACM0`` or ``COM3``.
    rate_hz : float
        What the device states.
    n_channels : int
        How many values a sample has.
    baud : int
        Of the line.
    """

    port: str
    rate_hz: Positive
    n_channels: PositiveWhole = 1
    baud: PositiveWhole = 921_600

    def source(self) -> "SerialSource":
        return SerialSource(self)


class SerialSource(Source):
    """Frames from a line; a line that is unplugged raises `DeviceFailed`, and may be opened again."""

    def __init__(self, settings: SerialSettings) -> None:
        super().__init__(f"serial {settings.port}", settings.rate_hz, settings.n_channels)
        self._settings = settings
        self._framing, self._samples = Framing(self.n_channels), CountedSamples(1e-6, name=self.name)

    def facts(self) -> dict[str, str | int | float | None]:
        return {"n_bytes_skipped": self._framing.n_skipped, **self._samples.facts()}

    def open(self) -> None:
        serial = _library()
        try:
            line = serial.Serial()
            line.port, line.baudrate, line.timeout = self._settings.port, self._settings.baud, POLL_S
            line.exclusive = True
            line.open()
            line.reset_input_buffer()
        except (serial.SerialException, OSError, ValueError) as error:
            raise DeviceFailed(
                f"{self.name}: cannot open the line ({_reason(error)}), expected a device to read"
            ) from None
        self._framing, self._line = Framing(self.n_channels, n_skipped=self._framing.n_skipped), line
        self._opened.callback(line.close)
        self._samples.may_begin_anew()

    def receive(self) -> SampleBlock | None:
        serial = _library()
        try:
            data = _available(self._line, self._framing.n_missing)
        except (serial.SerialException, OSError, TypeError) as error:  # TypeError: pyserial's, of a line without a file
            raise DeviceFailed(f"{self.name}: the line went away ({' '.join(str(error).split())})") from None
        arrival_s = now_s()
        self._framing, frames = self._framing.after(data)
        return self._samples.block(frames, arrival_s) if frames else None


def _available(line: Any, n_missing: int) -> bytes:
    """What has come, after `POLL_S` at most, in as few calls as possible: each may wait for a thread that computes."""
    if os.name != "posix":
        return bytes(line.read(max(n_missing, line.in_waiting)))
    ready, _, _ = select.select([line.fd], [], [], POLL_S)
    data = os.read(line.fd, LARGEST_READ) if ready else b""
    if ready and not data:
        raise OSError("the device hung up")
    return data


def _reason(error: Exception) -> str:
    number = getattr(error, "errno", None)
    return os.strerror(number) if number else " ".join(str(error).split())


def _library() -> Any:
    with library_needed("serial line: found no pyserial; pip install 'tactometry[serial]'"):
        import serial
    return serial
