"""Output to a board that reads one-bit streams, hangs or is missing."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from emulated import wait_for
from packed_bits import RATE_HZ, volts
from patience import LONGEST_WAIT_S
from sampled import force_sensor

from tactometry.devices.outputs.bit_stream import decode, stop_stream
from tactometry.devices.outputs.gain import Gain
from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.outputs.packed import READ_WITHIN_S, PackedSettings
from tactometry.errors import DeviceFailed, InvalidParameter, TactometryError
from tactometry.rigs.bench import Bench
from tactometry.rigs.device_rig import Equipment
from tactometry.rigs.texts import texts_in
from tactometry.safety.limits import Limits
from tactometry.safety.load import Load
from tactometry.session.request import Press
from tactometry.signal import Signal


def noise(n_samples):
    return Signal(np.where(np.random.default_rng(0).random((32, n_samples)) < 0.5, 30.0, -30.0), 1e6, "V")


LONG, SHORT = noise(100_000), noise(1000)
"""The one is longer than a pipe, the other is not."""
SILENCE = stop_stream(32, 1e6)


def driver_of(pipe):
    return PackedSettings(str(pipe), n_channels=32, rate_hz=1e6).driver(Gain(30.0, 1.0))


def output_to(pipe):
    output = driver_of(pipe)
    output.open()
    return output


@pytest.mark.parametrize(("n_channels", "expected"), [(0, "at least 1"), (1_000_000_000, "at most 65535")])
def test_board_refuses_unsupported_channel_counts(n_channels, expected):
    """Refused before a signal for all channels would exceed the memory."""
    with pytest.raises(InvalidParameter, match=rf"n_channels: found {n_channels}, expected a whole number, {expected}"):
        PackedSettings("board", n_channels, 250e3)


def test_board_receives_streams_and_stops(tmp_path, in_background):
    pipe, got, signal = tmp_path / "board", [], noise(7000)
    os.mkfifo(pipe)
    in_background(lambda: got.append(pipe.read_bytes()))
    output = output_to(pipe)
    output.play(signal)
    wait_for(lambda: output.facts()["n_bytes"] > 28_000)
    output.stop()
    output.close()
    output.close()
    wait_for(lambda: got)
    assert got[0].startswith(SILENCE)
    assert got[0].endswith(SILENCE + SILENCE)
    assert decode(got[0][len(SILENCE) : -2 * len(SILENCE)]).digest() == signal.digest()
    assert output.facts() == {"n_bytes": len(got[0])}
    with pytest.raises(DeviceFailed, match="found a closed output, expected an open one; nothing was played"):
        output.play(signal)


def test_board_receives_whole_stream_in_pieces(tmp_path, in_background):
    """A signal during a write ends the call after part of the bytes."""
    pipe, pieces, ended = tmp_path / "board", [], threading.Event()
    os.mkfifo(pipe)

    def take():
        with pipe.open("rb", buffering=0) as line:
            while piece := line.read(65_536):
                pieces.append(piece)
                time.sleep(2e-3)
        ended.set()

    in_background(take)
    output = output_to(pipe)
    usual = signal.signal(signal.SIGALRM, lambda number, frame: None)
    signal.setitimer(signal.ITIMER_REAL, 1e-3, 1e-3)
    try:
        output.play(LONG)
        wait_for(lambda: output.facts()["n_bytes"] > 400_000)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, usual)
    output.close()
    assert ended.wait(LONGEST_WAIT_S)
    assert decode(b"".join(pieces)[len(SILENCE) : -len(SILENCE)]).digest() == LONG.digest()


class Board:
    """Process that copies its input to a file and can hang."""

    def __init__(self, folder):
        self.pipe, self.got = folder / "board", folder / "got"
        os.mkfifo(self.pipe)
        with self.got.open("wb") as file:
            self.process = subprocess.Popen(["cat", str(self.pipe)], stdout=file)

    def hang(self):
        self.process.send_signal(signal.SIGSTOP)
        wait_for(lambda: Path(f"/proc/{self.process.pid}/stat").read_text().split()[2] == "T")

    def wakes_and_ends_with(self):
        self.process.send_signal(signal.SIGCONT)
        self.process.wait(10)
        return self.got.read_bytes()

    def close(self):
        self.process.kill()
        self.process.wait()


@pytest.fixture
def board(tmp_path):
    made = Board(tmp_path)
    yield made
    made.close()


WITHIN_S = 20 * READ_WITHIN_S
"""Far above the time of a stop, on a busy machine; without a deadline it was never over."""


def took_s(call):
    begin_s = time.perf_counter()
    call()
    return time.perf_counter() - begin_s


def test_stop_cuts_a_stream_to_a_hung_board(board):
    """When the board wakes up, it finds no complete stream and plays nothing."""
    output = output_to(board.pipe)
    board.hang()
    output.play(LONG)
    time.sleep(0.05)
    assert took_s(output.stop) < WITHIN_S
    assert took_s(output.close) < WITHIN_S
    assert board.wakes_and_ends_with() == SILENCE


def test_incompletely_read_stream_counts_as_gap(board):
    output = output_to(board.pipe)
    board.hang()
    for plays_s, n_gaps in ((0.0, 0), (LONG.duration_s, 1)):  # a cut stream shows nothing about the board
        output.play(LONG)
        time.sleep(plays_s)
        output.stop()
        assert output.n_gaps() == n_gaps
    output.close()


NOT_READ = (
    "had not read a whole stream when the next stream began, so that it was not played"
    r"|accepted \d+ of \d+ bytes within 1.1 s, expected all; restart the board"  # by then, on a busy machine
)


@pytest.mark.parametrize("signal", [LONG, SHORT], ids=["longer than a pipe", "that a pipe holds"])
def test_hung_board_is_detected_by_gaps_and_refusal(signal, board):
    output = output_to(board.pipe)
    output.play(signal)
    time.sleep(signal.duration_s)
    assert output.n_gaps(LONGEST_WAIT_S) == 0
    board.hang()
    output.play(signal)
    time.sleep(signal.duration_s)
    assert output.n_gaps() == 1
    with pytest.raises(DeviceFailed, match=NOT_READ):
        output.play(signal)
    output.close()


def test_unread_stop_fails_and_withdraws_the_stream(board):
    output = output_to(board.pipe)
    board.hang()
    output.play(SHORT)
    wait_for(lambda: output._sending.n_sent)

    def stop():
        with pytest.raises(DeviceFailed, match="did not read the stop command within 0.09 s; switch its amplifier off"):
            output.stop()

    assert READ_WITHIN_S <= took_s(stop) < WITHIN_S
    output.stop()
    output.close()
    assert board.wakes_and_ends_with() == SILENCE


def test_hung_board_fails_after_its_time_limit(board, monkeypatch):
    monkeypatch.setattr("tactometry.devices.outputs.packed.SEND_EXTRA_S", 0.1)
    output = output_to(board.pipe)
    board.hang()

    output.play(LONG)
    time.sleep(0.3)
    with pytest.raises(
        DeviceFailed, match=r"the board accepted \d+ of 400048 bytes within 0.2 s, expected all; restart"
    ):
        output.stop()
    output.close()
    assert board.wakes_and_ends_with() == SILENCE


def test_board_plays_next_stream_after_a_cut_one(tmp_path, in_background):
    """A cut stream ends with the file, and the board reopens its pipe."""
    pipe, got, slow = tmp_path / "board", [], threading.Event()
    os.mkfifo(pipe)

    def read_twice():
        for _ in range(2):
            with pipe.open("rb", buffering=0) as line:
                pieces = []
                while piece := line.read(65_536):
                    pieces.append(piece)
                    time.sleep(0.1 if slow.is_set() else 0.0)
                got.append(b"".join(pieces))

    in_background(read_twice)
    output = output_to(pipe)
    slow.set()
    output.play(LONG)
    time.sleep(0.1)
    output.stop()
    slow.clear()
    wait_for(lambda: len(got) == 1)
    output.play(SHORT)
    wait_for(lambda: output._sending.n_sent)
    output.close()
    wait_for(lambda: len(got) == 2)
    with pytest.raises(InvalidParameter, match="expected 400000"):
        decode(got[0][len(SILENCE) :])
    assert decode(got[1][: -len(SILENCE)]).digest() == SHORT.digest()


def test_board_that_closes_its_pipe_is_reported(tmp_path, in_background):
    pipe = tmp_path / "board"
    os.mkfifo(pipe)

    def read_a_part():
        with pipe.open("rb", buffering=0) as line:
            line.read(1000)

    in_background(read_a_part)
    output = output_to(pipe)
    output.play(LONG)
    time.sleep(LONG.duration_s)
    with pytest.raises(DeviceFailed, match=r"the board accepts no more data \(Broken pipe\); the output stopped"):
        output.stop()
    output.close()


def test_pipe_without_reader_is_refused_after_time_limit(tmp_path, monkeypatch):
    monkeypatch.setattr("tactometry.devices.outputs.packed.OPEN_WITHIN_S", 0.2)
    os.mkfifo(tmp_path / "board")
    output = PackedSettings(str(tmp_path / "board"), 1, RATE_HZ).driver(Gain(30.0, 1.0))

    def refused():
        with pytest.raises(DeviceFailed, match="found no reader of this pipe within 0.2 s.*nothing was played"):
            output.open()

    assert 0.2 <= took_s(refused) < 1.0
    output.close()


PLAYS_A_MINUTE = """
import signal, sys, time
import numpy as np
import tactometry.cli
from tactometry.devices.outputs.gain import Gain
from tactometry.devices.outputs.packed import PackedSettings
from tactometry.signal import Signal
signal.signal(signal.SIGTERM, tactometry.cli._terminate)
output = PackedSettings(sys.argv[1], n_channels=32, rate_hz=1e3).driver(Gain(30.0, 1.0))
output.open()
print("open", flush=True)
input()
try:
    output.play(Signal(np.full((32, 60_000), 30.0), 1e3, "V"))
    print("sends", flush=True)
    time.sleep(60)
finally:
    output.close()
"""


def test_process_ends_on_signal_when_board_hangs(board):
    """The signal arrives during a stream and uses the handler of the command."""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", PLAYS_A_MINUTE, board.pipe], **pipes) as process:
        assert process.stdout.readline() == b"open\n"
        board.hang()
        process.stdin.write(b"\n")
        process.stdin.flush()
        assert process.stdout.readline() == b"sends\n"
        process.send_signal(signal.SIGTERM)
        # a busy machine may be slow, but the process does not wait for the 60 s of its stream
        assert process.wait(30) == 143, process.stderr.read()
    assert not board.wakes_and_ends_with().startswith(SILENCE + b"TACT")


class Bits:
    """One-bit stimulus whose level selects the length of its stream."""

    unit = "V"

    def at(self, level):
        return LONG if level else SHORT


@pytest.mark.usefixtures("unhurried_sensors")
@pytest.mark.parametrize("level", [0.0, 1.0], ids=["the stream waits in the pipe", "the stream is being sent"])
def test_escape_ends_a_session_whose_board_hangs(board, watched, hands, in_background, monkeypatch, level):
    output, seen = driver_of(board.pipe), []
    limits = Limits(40.0, 60.0, current_peak_a=10.0, duty=1.0, session_s=600.0)
    guard, sensor = Guarded(output, limits, Load("electrode", 1e-12)), force_sensor(lambda time_s: 1.0, seen)
    equipment = Equipment(guard, {"bits": Bits()}, sensor=sensor, ramp_s=0.0, release=False)
    bench = Bench(watched, equipment, texts_in("en", {}))
    board.hang()
    monkeypatch.setattr("tactometry.devices.outputs.packed.SEND_EXTRA_S", LONGEST_WAIT_S)  # Escape comes first

    def escape_as_it_sends():
        wait_for(lambda: not output._line.was_read(0.0))
        hands.tap("Escape")

    in_background(escape_as_it_sends)
    begin_s = time.perf_counter()
    with pytest.raises(TactometryError) as ended:
        bench.answer(Press("bits", level, 60.0, target_n=1.0, tolerance=0.2, hold_s=0.1, timeout_s=60.0))
    assert time.perf_counter() - begin_s < 30.0
    assert ("Escape was pressed" if level else "did not read the stop command") in str(ended.value)
    assert bench.closed
    assert "sensor.close" in seen
    assert board.wakes_and_ends_with() in (SILENCE, b"")


def test_one_bit_output_refuses_other_voltages():
    output = PackedSettings("nowhere", 1, RATE_HZ).driver(Gain(30.0, 1.0))
    with pytest.raises(DeviceFailed, match="found a signal of 20 V, expected the 30 V of the supply"):
        output.final(volts([[20.0, -20.0]]))
    assert output.final(volts([[30.0, 0.0, -30.0]])).samples.tolist() == [[30.0, 0.0, -30.0]]
    with pytest.raises(DeviceFailed, match="expected only \\+V, -V and 0 .*nothing was played"):
        output.final(volts([[30.0, 15.0]]))
    with pytest.raises(DeviceFailed, match="found a signal of 20 V"):
        output.play(volts([[20.0, -20.0]]))


def test_missing_board_is_named(tmp_path):
    output = PackedSettings(str(tmp_path / "no" / "board"), 1, RATE_HZ).driver(Gain(1.0, 1.0))
    with pytest.raises(DeviceFailed, match="board: cannot open the board .*nothing was played"):
        output.open()
