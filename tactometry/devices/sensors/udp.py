"""Network force sensor that sends records by UDP, like the sensors of ATI.

A request has 8 bytes, big-endian: ``12 34``, a command (u16: 2 begins, 0 ends), and a number of samples (u32: 0 means
unlimited).
A record has 36 bytes: sequence number of the record (u32), sequence number of the sensor's sample (u32), status (u32, 0
means no error), then six values (i32): forces along x, y, z and torques about them, in counts. A datagram contains one
or more records. The format is that of the published manual. It was tested with an emulator, not with a sensor.
"""

import contextlib
import socket
import struct
from dataclasses import dataclass
from typing import Final

from ...arguments.constraints import Positive, constrained
from ...arguments.require import expect
from ...errors import DeviceFailed, attempt
from .counted_samples import CountedSamples
from .reader import POLL_S, SampleBlock, SensorSettings, Source, now_s

BEGIN: Final = struct.pack(">HHI", 0x1234, 2, 0)
END: Final = struct.pack(">HHI", 0x1234, 0, 0)
RECORD: Final = struct.Struct(">III6i")
RECEIVED_BYTES = 2**22
"""Requested size of the system's receive buffer, bytes."""
SILENT_S = 0.5
"""Silence after which the request is sent again, because the sensor may have been off."""


@dataclass(frozen=True)
@constrained
class UdpSettings(SensorSettings):
    """Sensor that sends datagrams, by its address.

    - `address`: Network address of the sensor.
    - `rate_hz`: Rate of the samples that it sends.
    - `sensor_rate_hz`: Internal sampling rate of the sensor. It may send only every n-th sample.
    - `port`: UDP port of the sensor.
    """

    address: str
    rate_hz: Positive
    sensor_rate_hz: Positive = 7000.0
    port: int = 49_152

    def __post_init__(self) -> None:
        expect(0 < self.port < 2**16, "UdpSettings.port", self.port, f"from 1 to {2**16 - 1}")

    def source(self) -> "UdpSource":
        return UdpSource(self)


def records(datagram: bytes) -> list[tuple[int, int, int, tuple[int, ...]]]:
    """Return (sequence, ticks, status, counts) of each complete record.

    >>> records(RECORD.pack(1, 7, 0, 1, -2, 3, 4, 5, 6))
    [(1, 7, 0, (1, -2, 3, 4, 5, 6))]
    >>> records(b"something else")
    []
    """
    if len(datagram) % RECORD.size:
        return []
    return [(a, b, c, tuple(values)) for a, b, c, *values in RECORD.iter_unpack(datagram)]


class UdpSource(Source):
    """Source of datagrams from the sensor's address."""

    def __init__(self, settings: UdpSettings) -> None:
        super().__init__(f"udp {settings.address}:{settings.port}", settings.rate_hz, n_channels=6)
        self._settings = settings
        self._samples = CountedSamples(1 / settings.sensor_rate_hz, name=self.name)
        self._n_refused = 0

    def facts(self) -> dict[str, str | int | float | None]:
        return {**self._samples.facts(), "n_refused": self._n_refused}

    def open(self) -> None:
        self._socket = self._opened.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        self._opened.callback(self._end)
        with attempt(self.name, "the sensor cannot be reached", "its address"):
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVED_BYTES)
            self._socket.settimeout(POLL_S)
            self._socket.connect((self._settings.address, self._settings.port))
        self._heard_s = now_s() - SILENT_S  # so that the first `receive` sends a request at once

    def receive(self) -> SampleBlock | None:
        try:
            if now_s() - self._heard_s >= SILENT_S:
                self._socket.send(BEGIN)
                self._samples.may_begin_anew()
                self._heard_s = now_s()
            datagram = self._socket.recv(65_536)
        except (TimeoutError, ConnectionRefusedError):  # refused because the port is closed, as while a sensor starts
            return None
        except OSError as error:
            raise DeviceFailed(f"{self.name}: the network failed ({error})") from None
        self._heard_s = arrival_s = now_s()
        received = records(datagram)
        sound = [(sequence, ticks, values) for sequence, ticks, status, values in received if status == 0]
        self._n_refused += len(received) - len(sound) if received else 1  # another format counts as one record
        return self._samples.block(sound, arrival_s) if sound else None

    def _end(self) -> None:
        with contextlib.suppress(OSError):  # the sensor may already be off
            self._socket.send(END)
