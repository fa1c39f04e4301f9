"""Audio gaps of each stimulus, measured with a stalled sound server."""

import os
import signal
import time
from types import SimpleNamespace

import numpy as np
import pytest
from benches import gain_toml
from emulated import Emulator, wait_for
from force_bench import BENCH, begin, study_in
from player import noise
from tables import trial_rows
from window_sitting import any_keys, sit

from tactometry.devices.outputs.audio import AudioOutput, AudioSettings
from tactometry.devices.outputs.frame_feed import FrameFeed
from tactometry.devices.outputs.gain import Gain
from tactometry.experiments.data_sets.validation import validate
from tactometry.signal import Signal

N_TRIES = 3
"""A busy computer may stall the server late, or interrupt a stimulus by itself."""


def held_up(process, for_s):
    process.send_signal(signal.SIGSTOP)
    time.sleep(for_s)
    process.send_signal(signal.SIGCONT)


@pytest.mark.slow
def test_gap_during_stimulus_invalidates_its_trial(needed, display, sink, tmp_path, in_background):
    study, device = study_in(tmp_path, 1, "1 s"), Emulator("lsl", tmp_path, profile="1:100")
    bench = BENCH.format(stream=device.name, gain=gain_toml("audio pulse, int16", system_volume=1.0))
    bench = bench.replace('"tofile"', '"pulse"\nshared = true\nlatency_s = 0.1')
    bench = bench.replace("[limits]", "[limits]\nstop_within_s = 0.5")
    process = begin(tmp_path, study, bench, {**sink.env, "DISPLAY": os.environ["DISPLAY"]})

    def tear():
        wait_for(lambda: sink.heard() > 4800 or process.poll() is not None)
        held_up(sink.server, 0.4)

    in_background(tear)
    try:
        status, _, errors = sit(process, display, any_keys(5))
    finally:
        device.close()
    assert status in (0, 1), errors  # 1: a busy computer interrupts all five attempts
    rows = trial_rows(tmp_path / "data")
    torn = [row for row in rows if row["n_gaps"] not in ("", "0")]
    assert torn
    assert {row["valid"] for row in torn} == {"0"}
    assert {row["invalid_reason"] for row in torn} <= {
        "output_gap",
        "sensor_lost",
    }  # a busy computer may also lose the sensor
    assert [row["attempt"] for row in rows] == [str(n + 1) for n in range(len(rows))]
    assert validate(tmp_path / "data").defects == ()


@pytest.fixture
def output(portaudio):
    made = AudioOutput(AudioSettings(48e3, "pulse", latency_s=0.1, shared=True), Gain(50.0, 1.0))
    made.open()
    time.sleep(0.3)
    yield made
    made.close()


def tone(duration_s):
    return Signal(np.full((1, round(48e3 * duration_s)), 1.0), 48e3, "V")


def any_of(tries):
    return any(tries() for _ in range(N_TRIES))


def played(output, duration_s):
    sleep_until(output.play(tone(duration_s)) + duration_s)


def test_undisturbed_stimulus_has_no_gap(output):
    def undisturbed():
        played(output, 0.3)
        return output.n_gaps() == 0

    assert any_of(undisturbed)


def test_gaps_outside_a_stimulus_are_not_counted(output, sink):
    def beside():
        held_up(sink.server, 0.3)
        time.sleep(0.2)
        played(output, 0.3)
        n_gaps = output.n_gaps()
        held_up(sink.server, 0.3)
        time.sleep(0.2)
        return n_gaps == output.n_gaps() == 0

    assert any_of(beside)
    assert output.facts()["n_underruns"] >= 2


def sleep_until(end_s):
    time.sleep(max(0.0, end_s - time.perf_counter()))


def heard_while_held_up(output, sink, after_s, for_s):
    """Play noise while the server stalls once.

    Return True if the sink recorded every sample, and the number of gaps that the output reports.
    """
    signal_played = noise(1, 48e3, 0.6)
    sink.begin()
    end_s = output.play(signal_played) + 0.6
    time.sleep(after_s)
    held_up(sink.server, for_s)
    sleep_until(end_s)
    n_gaps = output.n_gaps()
    samples = output.final(signal_played).samples[0] / 50.0
    heard = sink.end()[:, 0] / 32768
    heard = heard[int(np.argmax(heard != 0)) :][: len(samples)]
    whole = (
        len(heard) == len(samples) and np.abs(heard - samples).max() < 3 / 32768
    )  # tolerance for the conversion from 32 to 16 bits
    return whole, n_gaps


def test_near_underrun_is_reported_as_gap(output, sink):
    end_s = output.play(tone(0.5)) + 0.5
    time.sleep(0.2)
    held_up(sink.server, 0.08)
    sleep_until(end_s)
    assert output.n_gaps() >= 1


HELD_UP_S = [(0.1, 0.3), (0.3, 0.12), (0.45, 0.4)]


def test_audible_gap_is_always_reported(output, sink):
    """The server stalls at several times. Some reported gaps are inaudible."""

    def is_reported():
        found = [heard_while_held_up(output, sink, *each) for each in HELD_UP_S]
        return any(not whole for whole, _ in found) and all(whole or n_gaps for whole, n_gaps in found)

    assert any_of(is_reported)


class Asking:
    """A sound card that requests blocks of 5 ms, with a given buffer lead."""

    def __init__(self):
        self.output = AudioOutput(AudioSettings(48e3, "x", latency_s=0.1, shared=True), Gain(50.0, 1.0))

    def ask(self, lead_s):
        times = SimpleNamespace(outputBufferDacTime=lead_s, currentTime=0.0)
        self.output._fill(np.zeros((240, 1)), 240, times, SimpleNamespace(output_underflow=False))

    def begin(self, lead_s, n_blocks=2000):
        self.output._feed = FrameFeed(np.ones((240 * n_blocks, 1)), n_fade=1)
        self.ask(lead_s)


def test_stimulus_starting_in_a_gap_counts_it():
    """The gap began before the stimulus and lost its first frames."""
    card = Asking()
    card.ask(10.0)
    card.begin(0.003)
    assert card.output.n_gaps(0.0) == 1


def test_empty_card_buffer_counts_as_a_gap():
    card = Asking()
    card.ask(10.0)
    card.begin(10.0)
    assert card.output.n_gaps(0.0) == 0
    for lead_s in (0.003, 0.008, 0.013, 0.018):
        card.ask(lead_s)
    assert card.output.n_gaps(0.0) == 1


def test_card_without_buffer_reports_no_gap():
    card = Asking()
    card.begin(0.0)
    card.ask(0.0)
    assert card.output.n_gaps(0.0) == 0


def test_frames_are_late_when_not_taken_in_time():
    course = FrameFeed(np.zeros((1000, 1)), n_fade=1)
    course.begun.set()
    course.take(900)
    assert [course.is_late(now_s, rate_hz=1000.0) for now_s in (0.95, 1.05)] == [False, True]
    course.take(100)
    assert not course.is_late(1.05, rate_hz=1000.0)


def test_stimulus_counts_gaps_from_onset_to_end():
    course = FrameFeed(np.zeros((1000, 1)), n_fade=1)
    assert not course.is_torn_by(0.0, rate_hz=1000.0)
    course.onset_s = 10.0
    course.begun.set()
    assert course.is_torn_by(10.9, rate_hz=1000.0)
    assert course.is_torn_by(11.02, rate_hz=1000.0)  # the card runs dry slightly before its reported lead ends
    assert not course.is_torn_by(11.1, rate_hz=1000.0)
