"""Sensor on a serial line, with checksummed frames (extra: serial).

A frame, all little-endian:

======  ====  ===========================================================
offset  type  what
======  ====  ===========================================================
0       2s    ``A5 5A``
2       u8    n_channels, 1 to 32
3       u8    0
4       u32   counter, one more for each frame, modulo 2**32
8       u32   time of the sample on the device's clock, us, modulo 2**32
12      i32   value of each channel, counts
...     u32   CRC-32 (zlib's) of all bytes of the frame before it
======  ====  ===========================================================
"""

import os
import select
import struct
import zlib
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

from ...arguments.constraints import Positive, PositiveWhole, constrained
from ...errors import DeviceFailed, library_needed, reason
from .counted_samples import CountedSamples
from .reader import POLL_S, SampleBlock, SensorSettings, Source, now_s

LARGEST_READ = 65_536


@dataclass(frozen=True)
@constrained
class SerialSettings(SensorSettings):
    """Settings of a sensor on a serial line.

    - `port`: Name of the port, such as ``/dev/ttyACM0`` or ``COM3``.
    - `rate_hz`: Nominal sampling rate of the device.
    - `n_channels`: Number of values in a sample.
    - `baud`: Symbol rate of the serial line.
    """

    port: str
    rate_hz: Positive
    n_channels: PositiveWhole = 1
    baud: PositiveWhole = 921_600

    def source(self) -> "SerialSource":
        return SerialSource(self)


class SerialSource(Source):
    """Source of frames from a serial line, which can be reopened."""

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
            number = getattr(error, "errno", None)
            why = os.strerror(number) if number else reason(error)
            raise DeviceFailed(f"{self.name}: cannot open the line ({why}), expected a readable device") from None
        self._framing, self._line = Framing(self.n_channels, n_skipped=self._framing.n_skipped), line
        self._opened.callback(line.close)
        self._samples.may_begin_anew()

    def receive(self) -> SampleBlock | None:
        serial = _library()
        try:
            data = _available(self._line, self._framing.n_missing)
        except (serial.SerialException, OSError, TypeError) as error:  # pyserial raises TypeError for a closed line
            words = " ".join(str(error).split())
            raise DeviceFailed(f"{self.name}: the line was disconnected ({words})") from None
        arrival_s = now_s()
        self._framing, frames = self._framing.after(data)
        return self._samples.block(frames, arrival_s) if frames else None


def _available(line: Any, n_missing: int) -> bytes:
    """Return the bytes received within `POLL_S`, in few calls."""
    if os.name != "posix":
        return bytes(line.read(max(n_missing, line.in_waiting)))
    ready, _, _ = select.select([line.fd], [], [], POLL_S)
    data = os.read(line.fd, LARGEST_READ) if ready else b""
    if ready and not data:
        raise OSError("the device hung up")
    return data


def _library() -> Any:
    with library_needed("serial line: found no pyserial; pip install 'tactometry[serial]'"):
        import serial
    return serial


SYNC: Final = b"\xa5\x5a"
MOST_CHANNELS: Final = 32
_HEAD: Final = struct.Struct("<2sBBII")
_CHECKSUM: Final = struct.Struct("<I")


class Frame(NamedTuple):
    """One sample of all channels, with the time of the device."""

    counter: int
    time_us: int
    values: tuple[int, ...]


def frame_bytes(n_channels: int) -> int:
    """Return the length of a frame.

    >>> frame_bytes(1), frame_bytes(3)
    (20, 28)
    """
    return _HEAD.size + 4 * n_channels + _CHECKSUM.size


@dataclass(frozen=True)
class Framing:
    """Parser state: the bytes after the last complete frame.

    A complete frame is found in any noise. A damaged frame is accepted with a probability of 1 in 2**32.

    - `n_channels`: Number of channels in every frame of this device.
    - `rest`: Bytes that do not form a complete frame yet.
    - `n_skipped`: Number of bytes that did not belong to a frame.

    >>> body = bytes.fromhex("a55a 0100 07000000 e8030000 fbffffff")
    >>> sent = body + zlib.crc32(body).to_bytes(4, "little")
    >>> framing, frames = Framing(n_channels=1).after(b"noise" + sent[:9])
    >>> framing.after(sent[9:])[1]
    [Frame(counter=7, time_us=1000, values=(-5,))]
    """

    n_channels: int
    rest: bytes = b""
    n_skipped: int = 0

    @property
    def n_missing(self) -> int:
        """Bytes until the next frame can be complete, at least 1.

        >>> Framing(n_channels=1).n_missing, Framing(n_channels=1, rest=SYNC).n_missing
        (20, 18)
        """
        return frame_bytes(self.n_channels) - len(self.rest)

    def after(self, data: bytes) -> tuple["Framing", list[Frame]]:
        """Add bytes. Return the new state and the complete frames."""
        stream = self.rest + data
        at, n_skipped, frames = 0, self.n_skipped, []
        n_frame = frame_bytes(self.n_channels)
        while (begin := self._candidate(stream, at)) + n_frame <= len(stream):
            n_skipped += begin - at
            frame = _decode(stream[begin : begin + n_frame])
            if frame is None:
                # a false start may contain a frame, or be part of one: skip only its first byte
                at = begin + 1
                n_skipped += 1
            else:
                at = begin + n_frame
                frames.append(frame)
        return Framing(self.n_channels, stream[begin:], n_skipped + begin - at), frames

    def _candidate(self, stream: bytes, at: int) -> int:
        """Return the position where the next frame may begin."""
        opening = SYNC + bytes([self.n_channels, 0])
        begin = stream.find(opening, at)
        if begin >= 0:
            return begin
        kept = next((n for n in (3, 2, 1) if stream.endswith(opening[:n])), 0)
        return max(at, len(stream) - kept)


def _decode(frame: bytes) -> Frame | None:
    body = frame[: -_CHECKSUM.size]
    if zlib.crc32(body) != _CHECKSUM.unpack(frame[-_CHECKSUM.size :])[0]:
        return None
    _, n, _, counter, time_us = _HEAD.unpack_from(body)
    return Frame(counter, time_us, struct.unpack_from(f"<{n}i", body, _HEAD.size))
