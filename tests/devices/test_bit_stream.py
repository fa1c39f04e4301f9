"""Packed one-bit streams: encoding, damage and wrong headers."""

import zlib

import numpy as np
import pytest
from hard_cases import exact_case
from hypothesis import given, strategies as st
from packed_bits import RATE_HZ, bits, volts

from tactometry.devices.outputs.bit_stream import HEADER_BYTES, decode, encode, stop_stream, word_bytes
from tactometry.errors import InvalidParameter
from tactometry.signal import Signal

OTHERS = [([[1.0, -1.0]], "N"), ([[0.0, 0.0]], "V"), ([[1.0, -0.5]], "V"), ([[1.0, 0.0, -0.5]], "V")]


@pytest.mark.parametrize(("values", "unit"), OTHERS)
def test_encode_refuses_samples_of_several_magnitudes(values, unit):
    with pytest.raises(InvalidParameter, match=r"samples of several sizes, or only 0.*only \+V, -V and 0 \(off\)"):
        encode(Signal(np.array(values), RATE_HZ, unit))


@pytest.mark.parametrize(
    ("at", "value", "message"),
    [
        (0, b"TACT2BIT", "found no header, expected 48 bytes that begin with b'TACT1BIT'"),
        (8, b"\x03\x00", "found version 3, header of 48 bytes, expected 1 or 2, and 48"),
        (8, b"\x02\x00", "found 1 bytes after the header, expected 2"),
        (10, b"\x31\x00", "found version 1, header of 49 bytes"),
        (12, b"\x00\x00\x00\x00", "found 0 channels, expected from 1 to 65535"),
        (12, b"\x00\x00\x01\x00", "found 65536 channels, expected from 1 to 65535"),
        (32, b"\x02", "found 1 bytes after the header, expected 2"),
    ],
)
def test_decode_refuses_wrong_fields_with_valid_checksum(at, value, message):
    stream = encode(volts([[1.0]]))
    fields = (stream[:at] + value + stream[at + len(value) :])[: HEADER_BYTES - 4]
    header = fields + zlib.crc32(fields).to_bytes(4, "little")
    with pytest.raises(InvalidParameter, match=message):
        decode(header + stream[HEADER_BYTES:])


def test_stop_stream_refuses_too_many_channels():
    with pytest.raises(InvalidParameter, match="found 65536 channels, expected from 1 to 65535"):
        stop_stream(65_536, RATE_HZ)


@given(bits, st.floats(1e-3, 1e3), st.floats(1.0, 1e8))
def test_packed_stream_decodes_to_every_bit(values, voltage_v, rate_hz):
    signal = Signal(values * voltage_v, rate_hz, "V")
    stream = encode(signal)
    n_words = 1 if signal.samples.all() else 2
    assert len(stream) == HEADER_BYTES + n_words * word_bytes(values.shape[0]) * values.shape[1]
    assert decode(stream).digest() == signal.digest()
    exact_case("a packed one-bit stream", against="every bit")


@given(bits, st.data())
def test_decode_detects_any_flipped_bit_or_cut(values, data):
    stream = bytearray(encode(Signal(30.0 * values, 1e6, "V")))
    where = data.draw(st.integers(0, 8 * len(stream) - 1))
    stream[where // 8] ^= 1 << (where % 8)
    with pytest.raises(InvalidParameter, match="packed stream: found"):
        decode(bytes(stream))
    with pytest.raises(InvalidParameter, match="packed stream: found"):
        decode(encode(Signal(30.0 * values, 1e6, "V"))[: data.draw(st.integers(0, len(stream) - 1))])
    exact_case("any bit of a packed stream turned", against="refusal")


def test_stream_bytes_match_the_documented_format():
    values = np.where(np.arange(33)[:, None] == [0, 9, 32], 1.0, -1.0)
    stream = encode(Signal(30.0 * values, 1e6, "V"))
    assert stream[:12] == b"TACT1BIT" + bytes([1, 0, 48, 0])
    assert int.from_bytes(stream[12:16], "little") == 33
    assert np.frombuffer(stream, "<f8", 2, 16).tolist() == [1e6, 30.0]
    assert int.from_bytes(stream[32:40], "little") == 3
    assert stream[48:] == bytes([1, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 1])
    assert int.from_bytes(stream[40:44], "little") == zlib.crc32(stream[48:])
    assert int.from_bytes(stream[44:48], "little") == zlib.crc32(stream[:44])


def test_second_word_encodes_active_channels():
    values = np.zeros((9, 2))
    values[[0, 8], [0, 1]] = 1.0, -1.0
    stream = encode(Signal(30.0 * values, 1e6, "V"))
    assert stream[8:10] == bytes([2, 0])
    assert stream[48:] == bytes([1, 0, 1, 0, 0, 0, 0, 1])
    assert decode(stream).samples.tolist() == (30.0 * values).tolist()
