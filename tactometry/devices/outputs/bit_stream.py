"""One-bit streams for boards that drive many channels, such as an FPGA before switching amplifiers.

A stream is a header of 48 bytes and its payload, all little-endian:

======  ====  ===================================================================================
offset  type  what
======  ====  ===================================================================================
0       8s    magic, ``TACT1BIT``
8       u16   version, 1
10      u16   bytes of the header, 48
12      u32   n_channels, 1 to 65535
16      f64   rate_hz, samples per second
24      f64   voltage_v: a bit of 1 is +voltage_v, 0 is -voltage_v
32      u64   n_samples
40      u32   CRC-32 (zlib's) of the payload
44      u32   CRC-32 of the header's bytes 0 to 43
======  ====  ===================================================================================

The payload is one word of ``ceil(n_channels / 8)`` bytes per sample; channel q is bit q mod 8 of byte q div 8; the bits
beyond the last channel are 0. One bit has no zero: a board plays a stream once it has all of it and its checksum is
right, and switches its outputs off before it, after its last sample, at the end of the file, and at once when it reads
a stream of no samples, which is how "stop" is said.
"""

import struct
import zlib
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ...arguments.require import expect
from ...signal import Signal

MAGIC: Final = b"TACT1BIT"
VERSION: Final = 1
_FIELDS: Final = struct.Struct("<8sHHIddQI")
_CHECKSUM: Final = struct.Struct("<I")
HEADER_BYTES: Final = _FIELDS.size + _CHECKSUM.size
MOST_CHANNELS: Final = 65_535
_STREAM: Final = "packed stream"


def word_bytes(n_channels: int) -> int:
    """Bytes of one sample of all channels.

    >>> word_bytes(32), word_bytes(33)
    (4, 5)
    """
    return -(-n_channels // 8)


def encode(signal: Signal) -> bytes:
    """A signal of +V and -V as a stream; a signal of no samples is "stop".

    Raises
    ------
    InvalidParameter
        If a sample is neither +V nor -V for one V, the peak.

    Examples
    --------
    >>> stream = encode(Signal(np.array([[30.0, -30.0], [30.0, 30.0]]), 1e6, "V"))
    >>> len(stream), stream[48:].hex(), decode(stream).samples.tolist()
    (50, '0302', [[30.0, -30.0], [30.0, 30.0]])
    """
    voltage_v = signal.peak
    one_size = np.all(np.abs(signal.samples) == voltage_v)
    is_zero = signal.samples.size > 0 and voltage_v == 0  # zeros are of one size too, and have no sign
    one_bit = "+V and -V alone (a one-bit signal in volt, without ramps)"
    expect(signal.unit == "V" and one_size and not is_zero, _STREAM, "samples of more than one size", one_bit)
    bits = np.packbits(signal.samples.T > 0, axis=1, bitorder="little")
    return _header(signal, voltage_v, zlib.crc32(bits.tobytes())) + bits.tobytes()


def decode(stream: bytes) -> Signal:
    """The signal of a stream, bit by bit.

    Raises
    ------
    InvalidParameter
        If it is no stream, or was damaged.
    """
    n_channels, rate_hz, voltage_v, n_samples, checksum = _read_header(stream)
    payload = stream[HEADER_BYTES:]
    n_bytes = n_samples * word_bytes(n_channels)
    expect(len(payload) == n_bytes, _STREAM, f"{len(payload)} bytes after the header", f"{n_bytes}")
    expect(zlib.crc32(payload) == checksum, _STREAM, "a payload whose checksum is wrong", "it undamaged")
    words = np.frombuffer(payload, np.uint8).reshape(n_samples, word_bytes(n_channels))
    bits: NDArray[np.uint8] = np.unpackbits(words, axis=1, count=n_channels, bitorder="little")
    return Signal(np.where(bits.T == 1, voltage_v, -voltage_v), rate_hz, "V")


def stop_stream(n_channels: int, rate_hz: float) -> bytes:
    """A stream of no samples: outputs off."""
    return encode(Signal(np.zeros((n_channels, 0)), rate_hz, "V"))


def _header(signal: Signal, voltage_v: float, checksum: int) -> bytes:
    n_channels, n_samples = signal.samples.shape
    _check_channels(n_channels)
    fields = _FIELDS.pack(MAGIC, VERSION, HEADER_BYTES, n_channels, signal.rate_hz, voltage_v, n_samples, checksum)
    return fields + _CHECKSUM.pack(zlib.crc32(fields))


def _check_channels(n_channels: int) -> None:
    expect(1 <= n_channels <= MOST_CHANNELS, _STREAM, f"{n_channels} channels", f"from 1 to {MOST_CHANNELS}")


def _read_header(stream: bytes) -> tuple[int, float, float, int, int]:
    begins = len(stream) >= HEADER_BYTES and stream[:8] == MAGIC
    expect(begins, _STREAM, "no header", f"{HEADER_BYTES} bytes that begin with {MAGIC!r}")
    fields = stream[: _FIELDS.size]
    _, version, n_header, n_channels, rate_hz, voltage_v, n_samples, checksum = _FIELDS.unpack(fields)
    sound = zlib.crc32(fields) == _CHECKSUM.unpack_from(stream, _FIELDS.size)[0]
    expect(sound, _STREAM, "a header whose checksum is wrong", "it undamaged")
    known = (version, n_header) == (VERSION, HEADER_BYTES)
    expect(known, _STREAM, f"version {version}, header of {n_header} bytes", f"{VERSION} and {HEADER_BYTES}")
    _check_channels(n_channels)
    return n_channels, rate_hz, voltage_v, n_samples, checksum
