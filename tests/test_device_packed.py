"""Packed one-bit streams: every bit, every damage, and a board that reads them."""

import os
import signal
import threading
import time
import zlib

import numpy as np
import pytest
from hard_cases import exact_case
from hypothesis import given
from hypothesis import strategies as st
from test_device_outputs import RATE_HZ, bits, volts

from tactometry.devices.gain import Gain
from tactometry.devices.packed import HEADER_BYTES, decode, encode, stop_stream, word_bytes
from tactometry.devices.packed_output import PackedSettings
from tactometry.errors import DeviceFailed, InvalidParameter
from tactometry.signal import Signal


@pytest.mark.parametrize(("values", "unit"), [([[1.0, -1.0]], "N"), ([[0.0, 0.0]], "V"), ([[1.0, -0.5]], "V")])
def test_only_volts_of_one_size_are_packed(values, unit):
    with pytest.raises(InvalidParameter, match="packed stream: found samples of more than one size"):
        encode(Signal(np.array(values), RATE_HZ, unit))


@pytest.mark.parametrize(
    ("at", "value", "message"),
    [
        (0, b"TACT2BIT", "found no header, expected 48 bytes that begin with b'TACT1BIT'"),
        (8, b"\x02\x00", "found version 2, header of 48 bytes, expected 1 and 48"),
        (10, b"\x31\x00", "found version 1, header of 49 bytes"),
        (12, b"\x00\x00\x00\x00", "found 0 channels, expected from 1 to 65535"),
        (12, b"\x00\x00\x01\x00", "found 65536 channels, expected from 1 to 65535"),
        (32, b"\x02", "found 1 bytes after the header, expected 2"),
    ],
)
def test_a_sound_header_that_says_something_else_is_refused(at, value, message):
    stream = encode(volts([[1.0]]))
    fields = (stream[:at] + value + stream[at + len(value) :])[: HEADER_BYTES - 4]
    header = fields + zlib.crc32(fields).to_bytes(4, "little")
    with pytest.raises(InvalidParameter, match=message):
        decode(header + stream[HEADER_BYTES:])


def test_a_stream_of_too_many_channels_is_not_made():
    with pytest.raises(InvalidParameter, match="found 65536 channels, expected from 1 to 65535"):
        stop_stream(65_536, RATE_HZ)


@given(bits, st.floats(1e-3, 1e3), st.floats(1.0, 1e8))
def test_a_packed_stream_gives_back_every_bit(values, voltage_v, rate_hz):
    signal = Signal(values * voltage_v, rate_hz, "V")
    stream = encode(signal)
    assert len(stream) == HEADER_BYTES + word_bytes(values.shape[0]) * values.shape[1]
    assert decode(stream).digest() == signal.digest()
    exact_case("a packed one-bit stream", against="every bit")


@given(bits, st.data())
def test_no_damage_goes_unseen(values, data):
    stream = bytearray(encode(Signal(30.0 * values, 1e6, "V")))
    where = data.draw(st.integers(0, 8 * len(stream) - 1))
    stream[where // 8] ^= 1 << (where % 8)
    with pytest.raises(InvalidParameter, match="packed stream: found"):
        decode(bytes(stream))
    with pytest.raises(InvalidParameter, match="packed stream: found"):
        decode(encode(Signal(30.0 * values, 1e6, "V"))[: data.draw(st.integers(0, len(stream) - 1))])
    exact_case("any bit of a packed stream turned", against="refusal")


def test_the_bytes_are_those_of_the_documented_form():
    values = np.where(np.arange(33)[:, None] == [0, 9, 32], 1.0, -1.0)
    stream = encode(Signal(30.0 * values, 1e6, "V"))
    assert stream[:12] == b"TACT1BIT" + bytes([1, 0, 48, 0])
    assert int.from_bytes(stream[12:16], "little") == 33
    assert np.frombuffer(stream, "<f8", 2, 16).tolist() == [1e6, 30.0]
    assert int.from_bytes(stream[32:40], "little") == 3
    assert stream[48:] == bytes([1, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 1])
    assert int.from_bytes(stream[40:44], "little") == zlib.crc32(stream[48:])
    assert int.from_bytes(stream[44:48], "little") == zlib.crc32(stream[:44])


@pytest.mark.parametrize("values", [[[1.0, 0.5]], [[1.0, 0.0]], [[0.0]]])
def test_one_bit_is_plus_or_minus_one_voltage(values):
    with pytest.raises(InvalidParameter, match=r"expected \+V and -V alone"):
        encode(volts(values))


def test_a_board_gets_streams_and_is_told_to_stop(tmp_path):
    """Through a real named pipe to a reader, as to a device node."""
    pipe, got = tmp_path / "board", []
    os.mkfifo(pipe)
    board = threading.Thread(target=lambda: got.append(pipe.read_bytes()))
    board.start()
    output = PackedSettings(str(pipe), n_channels=32, rate_hz=1e6).driver(Gain(30.0, 1.0))
    output.open()
    signal = Signal(np.where(np.random.default_rng(0).random((32, 7000)) < 0.5, 30.0, -30.0), 1e6, "V")
    output.play(signal)
    output.stop()
    output.close()
    output.close()
    board.join(10)
    silence = stop_stream(32, 1e6)
    assert got[0].startswith(silence)
    assert got[0].endswith(silence + silence)
    assert decode(got[0][len(silence) : -2 * len(silence)]).digest() == signal.digest()
    assert output.facts() == {"n_bytes": len(got[0])}
    with pytest.raises(DeviceFailed, match="it is closed, nothing was played; open it first"):
        output.play(signal)


def test_a_board_that_takes_a_stream_in_pieces_gets_all_of_it(tmp_path):
    """Signals that arrive while a full pipe is written to end the call with a part of the bytes."""
    pipe, pieces = tmp_path / "board", []
    os.mkfifo(pipe)

    def take():
        with pipe.open("rb", buffering=0) as line:
            while piece := line.read(65_536):
                pieces.append(piece)
                time.sleep(2e-3)

    board = threading.Thread(target=take)
    board.start()
    output = PackedSettings(str(pipe), n_channels=32, rate_hz=1e6).driver(Gain(30.0, 1.0))
    output.open()
    sent = Signal(np.where(np.random.default_rng(0).random((32, 100_000)) < 0.5, 30.0, -30.0), 1e6, "V")
    usual = signal.signal(signal.SIGALRM, lambda number, frame: None)
    signal.setitimer(signal.ITIMER_REAL, 1e-3, 1e-3)
    try:
        output.play(sent)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, usual)
    output.close()
    board.join(10)
    n_silence = len(stop_stream(32, 1e6))
    assert decode(b"".join(pieces)[n_silence:-n_silence]).digest() == sent.digest()


def test_a_supply_cannot_be_scaled_by_one_bit():
    output = PackedSettings("nowhere", 1, RATE_HZ).driver(Gain(30.0, 1.0))
    assert output.final(volts([[30.0, -30.0]])).samples.tolist() == [[30.0, -30.0]]
    with pytest.raises(DeviceFailed, match="found a signal of 20 V, expected the 30 V of the supply"):
        output.final(volts([[20.0, -20.0]]))
    with pytest.raises(DeviceFailed, match="expected \\+V and -V alone .*nothing was played"):
        output.final(volts([[30.0, 0.0]]))
    with pytest.raises(DeviceFailed, match="found a signal of 20 V"):
        output.play(volts([[20.0, -20.0]]))


def test_a_board_that_is_not_there_is_named(tmp_path):
    output = PackedSettings(str(tmp_path / "no" / "board"), 1, RATE_HZ).driver(Gain(1.0, 1.0))
    with pytest.raises(DeviceFailed, match="board: cannot open the board .*nothing was played"):
        output.open()
