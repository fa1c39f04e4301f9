"""One-bit streams for boards that drive many channels.

A stream is a header of 48 bytes and its payload, all little-endian:

======  ====  ===================================================================================
offset  type  what
======  ====  ===================================================================================
0       8s    magic, ``TACT1BIT``
8       u16   version: 1, or 2 if a channel is off somewhere
10      u16   bytes of the header, 48
12      u32   n_channels, 1 to 65535
16      f64   rate_hz, samples per second
24      f64   voltage_v: a sign bit of 1 is +voltage_v, 0 is -voltage_v
32      u64   n_samples
40      u32   CRC-32 (zlib's) of the payload
44      u32   CRC-32 of the header's bytes 0 to 43
======  ====  ===================================================================================

The payload of version 1 is one word of signs per sample, ``ceil(n_channels / 8)`` bytes; channel q is bit q mod 8 of
byte q div 8; the bits beyond the last channel are 0. In version 2 a second word follows, with a bit for each
channel: where it is 0, the channel is switched off and its sign bit is 0. A board with a programmable supply first sets
it to ``voltage_v``. A board plays a stream once it is complete, its checksum is correct and the supply has the voltage
of the header. It switches its outputs off before the stream, after its last sample, at the end of the file, and at once
when it reads a stream without samples, which means "stop".
"""

import struct
import zlib
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ...arguments.require import expect
from ...signal import Signal

MAGIC: Final = b"TACT1BIT"
SIGNS: Final = 1
SIGNS_AND_OFF: Final = 2
"""Format versions, equal to the number of words per sample."""
_FIELDS: Final = struct.Struct("<8sHHIddQI")
_CHECKSUM: Final = struct.Struct("<I")
HEADER_BYTES: Final = _FIELDS.size + _CHECKSUM.size
MOST_CHANNELS: Final = 65_535
_STREAM: Final = "packed stream"


def word_bytes(n_channels: int) -> int:
    """Return the number of bytes of a word with a bit for each channel.

    >>> word_bytes(32), word_bytes(33)
    (4, 5)
    """
    return -(-n_channels // 8)


def encode(signal: Signal) -> bytes:
    """Encode a signal of +V, -V and 0 (off). No samples mean "stop".

    V is the peak of the signal. Raises `InvalidParameter` if a sample is neither +V, -V nor 0, or if all samples are 0.

    >>> stream = encode(Signal(np.array([[30.0, -30.0], [30.0, 30.0]]), 1e6, "V"))
    >>> len(stream), stream[48:].hex(), decode(stream).samples.tolist()
    (50, '0302', [[30.0, -30.0], [30.0, 30.0]])
    >>> encode(Signal(np.array([[0.0, -30.0], [30.0, 0.0]]), 1e6, "V"))[48:].hex()
    '02020001'
    """
    voltage_v, is_on = signal.peak, signal.samples != 0
    one_size = np.all(np.abs(signal.samples[is_on]) == voltage_v)
    some = signal.samples.size == 0 or voltage_v > 0
    one_bit = "only +V, -V and 0 (off), in volt and without ramps, as foci and amplitude_modulated on a bench"
    expect(signal.unit == "V" and one_size and some, _STREAM, "samples of several sizes, or only 0", one_bit)
    words = [signal.samples > 0] if is_on.all() else [signal.samples > 0, is_on]
    payload = np.concatenate([np.packbits(bits.T, axis=1, bitorder="little") for bits in words], axis=1).tobytes()
    n_channels, n_samples = signal.samples.shape
    _check_channels(n_channels)
    fields = _FIELDS.pack(
        MAGIC, len(words), HEADER_BYTES, n_channels, signal.rate_hz, voltage_v, n_samples, zlib.crc32(payload)
    )
    header = fields + _CHECKSUM.pack(zlib.crc32(fields))
    return header + payload


def decode(stream: bytes) -> Signal:
    """Decode the signal of a stream, 0 where a channel is off.

    Raises `InvalidParameter` if the stream has another format or is damaged.
    """
    n_words, n_channels, rate_hz, voltage_v, n_samples, checksum = _read_header(stream)
    payload = stream[HEADER_BYTES:]
    n_bytes = n_samples * n_words * word_bytes(n_channels)
    expect(len(payload) == n_bytes, _STREAM, f"{len(payload)} bytes after the header", f"{n_bytes}")
    expect(zlib.crc32(payload) == checksum, _STREAM, "a payload with a wrong checksum", "an undamaged stream")
    words = np.frombuffer(payload, np.uint8).reshape(n_samples, n_words, word_bytes(n_channels))
    bits: NDArray[np.uint8] = np.unpackbits(words, axis=2, count=n_channels, bitorder="little")
    signs = np.where(bits[:, 0].T == 1, voltage_v, -voltage_v)
    return Signal(signs if n_words == SIGNS else np.where(bits[:, 1].T == 1, signs, 0.0), rate_hz, "V")


def stop_stream(n_channels: int, rate_hz: float) -> bytes:
    """Return the stream without samples, which switches outputs off."""
    return encode(Signal(np.zeros((n_channels, 0)), rate_hz, "V"))


def _check_channels(n_channels: int) -> None:
    expect(1 <= n_channels <= MOST_CHANNELS, _STREAM, f"{n_channels} channels", f"from 1 to {MOST_CHANNELS}")


def _read_header(stream: bytes) -> tuple[int, int, float, float, int, int]:
    begins = len(stream) >= HEADER_BYTES and stream[:8] == MAGIC
    expect(begins, _STREAM, "no header", f"{HEADER_BYTES} bytes that begin with {MAGIC!r}")
    fields = stream[: _FIELDS.size]
    _, version, n_header, n_channels, rate_hz, voltage_v, n_samples, checksum = _FIELDS.unpack(fields)
    sound = zlib.crc32(fields) == _CHECKSUM.unpack_from(stream, _FIELDS.size)[0]
    expect(sound, _STREAM, "a header with a wrong checksum", "an undamaged stream")
    known = version in (SIGNS, SIGNS_AND_OFF) and n_header == HEADER_BYTES
    versions = f"{SIGNS} or {SIGNS_AND_OFF}, and {HEADER_BYTES}"
    expect(known, _STREAM, f"version {version}, header of {n_header} bytes", versions)
    _check_channels(n_channels)
    return version, n_channels, rate_hz, voltage_v, n_samples, checksum
