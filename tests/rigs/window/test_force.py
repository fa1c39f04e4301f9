"""Touches gated by a force that is sampled in real time."""

import math
import threading
import time
from dataclasses import replace

import pytest
from experimenter_seat import TONE
from hard_cases import exact_case
from patience import LONGEST_WAIT_S
from sampled import Passing

from tactometry.rigs.pages.page import Text
from tactometry.safety.limits import Limits
from tactometry.session.request import Adjust, Play, Press, Record, Show, Wait
from tactometry.trials.trial import Trial

TRIAL = Trial(1, 1, {}, "staircase", 5.0, "V", "yes_no", None)
PRESS = Press("tone", 5.0, 0.3, target_n=1.0, tolerance=0.2, hold_s=0.2, timeout_s=5.0)


class Slow(Passing):
    def __init__(self, output, takes_s):
        super().__init__(output)
        self._takes_s, self.begins = takes_s, threading.Event()

    def play(self, signal):
        self.begins.set()
        time.sleep(self._takes_s)
        return self.wrapped.play(signal)


def held_from(start_s, force_n):
    return lambda time_s: force_n if time_s >= start_s else 0.3


def test_stimulus_waits_for_held_force(bench_of, log):
    touched = bench_of(held_from(0.5, 1.1)).answer(PRESS)
    assert touched.valid
    assert touched.onset_s >= 0.5 + 0.2
    assert touched.force_mean_n == pytest.approx(1.1, rel=1e-9)
    assert (touched.force_sd_n, touched.force_in_band) == (pytest.approx(0, abs=1e-9), 1.0)
    assert touched.digest == TONE.at(5.0).digest()
    assert log == ["output.open", "play 5 V", "output.stop"]


def test_unheld_force_times_out_without_playback(bench_of, log):
    touched = bench_of(lambda time_s: 1.0 + 0.5 * math.sin(40 * time_s)).answer(replace(PRESS, timeout_s=0.6))
    assert (touched.valid, touched.digest, touched.level_delivered) == (False, None, None)
    assert touched.invalid_reason == "timeout"
    assert log == ["output.open"]


@pytest.mark.parametrize(
    ("afterwards", "reason"),
    [(None, "sensor_lost"), (math.nan, "sensor_lost"), (0.02, "lifted"), (3.1, "too_heavy")],
    ids=["the sensor is silent", "samples are lost", "the finger leaves", "the force is too high"],
)
def test_output_stops_when_force_is_lost(bench_of, log, afterwards, reason):
    request, felt = replace(PRESS, duration_s=20.0), iter([1.0] * 300)
    limits = Limits(50.0, force_peak_n=3.0)
    bench = bench_of(lambda time_s: next(felt, afterwards) if "play 5 V" in log else 1.0, limits=limits)
    touched = bench.answer(request)
    assert (touched.valid, touched.invalid_reason) == (False, reason)
    assert touched.force_mean_n is not None
    assert list(dict.fromkeys(log)) == ["output.open", "play 5 V", "output.stop"]


def test_output_stops_when_sensor_thread_hangs(bench_of, log):
    def hangs(time_s):
        if "play 5 V" in log:
            hung.wait(LONGEST_WAIT_S)
        return 1.0

    hung = threading.Event()
    touched = bench_of(hangs).answer(replace(PRESS, duration_s=600.0))
    hung.set()
    assert not touched.valid
    assert list(dict.fromkeys(log)) == ["output.open", "play 5 V", "output.stop"]


class Held(Passing):
    """A screen whose frame lasts until the playing output has stopped."""

    def __init__(self, screen, log):
        super().__init__(screen)
        self._log = log

    def refresh(self, page):
        while "play 5 V" in self._log and "output.stop" not in self._log:
            time.sleep(0.01)
        time.sleep(PRESS.duration_s)
        return self.wrapped.refresh(page)


def test_stimulus_stopped_during_slow_frame_is_invalid(bench_of, watched, log):
    felt = iter([1.0] * 100)
    held = Held(watched, log)
    touched = bench_of(lambda time_s: next(felt, None) if "play 5 V" in log else 1.0, screen=held).answer(PRESS)
    assert touched.force_in_band == 1.0
    assert not touched.valid


STUCK = replace(PRESS, timeout_s=0.8)


def test_stuck_force_plays_nothing(bench_of, log, watched):
    touched = bench_of(lambda time_s: 1.0, release=True).answer(STUCK)
    assert (touched.valid, touched.invalid_reason) == (False, "timeout")
    assert log == ["output.open"]
    assert "Lift your finger, then press again" in words_of(watched.drawn[-1])


@pytest.mark.parametrize(
    ("between_n", "plays"), [(1.0, False), (0.9, False), (1.3, True), (0.1, True), (math.nan, False)]
)
def test_force_must_leave_band_between_touches(bench_of, log, watched, between_n, plays):
    """The force is `between_n` for a while after the first stimulus."""
    ended = []

    def force_n(time_s):
        if "output.stop" not in log:
            return 1.0 if time_s > 0.3 else 0.3
        ended.append(time_s)
        return between_n if len(ended) < 100 else 1.0

    bench = bench_of(force_n, release=True)
    in_time = replace(STUCK, timeout_s=20.0)  # enough for a busy machine
    assert bench.answer(in_time).valid
    time.sleep(0.2)
    touched = bench.answer(in_time if plays else STUCK)
    assert touched.valid is plays
    assert log.count("play 5 V") == 1 + plays
    assert ("Lift your finger, then press again" in words_of(watched.drawn[-1])) is not plays


def words_of(page):
    return [item.words for item in page.items if isinstance(item, Text)]


@pytest.mark.parametrize(("drifted_n", "reason"), [(1.6, "too_heavy"), (0.5, "too_light")])
def test_force_drift_out_of_band_invalidates_trial(bench_of, log, drifted_n, reason):
    touched = bench_of(lambda time_s: drifted_n if "play 5 V" in log else 1.0).answer(PRESS)
    assert (touched.valid, touched.invalid_reason) == (False, reason)
    assert touched.force_in_band < 0.8


@pytest.mark.usefixtures("unhurried_sensors")
def test_gate_delay_is_unaffected_by_later_force(bench_of, log, kept):
    """The force re-enters its band during the stimulus and reopens the gate."""
    left = iter([0.7] * 50)
    bench = bench_of(lambda time_s: next(left, 1.0) if "play 5 V" in log else 1.0, kept=kept)
    begin_s = bench._done().at_s
    touched = bench.answer(replace(PRESS, duration_s=0.8, hold_s=0.1))
    bench.answer(Record(TRIAL))
    bench.answer(Wait(0.0))
    assert touched.valid
    [told] = [event for event in kept.events if event.kind == "trial"]
    assert 0 <= told.facts["gate_delay_s"] < touched.onset_s - begin_s


def test_sample_gap_restarts_the_hold(bench_of):
    touched = bench_of(lambda time_s: None if 0.15 <= time_s < 0.18 else 1.0).answer(PRESS)
    assert touched.onset_s >= 0.18 + 0.2
    exact_case("a gap in the samples of a held force", against="a hold anew")


def test_escape_closes_output_then_sensor_then_screen(bench_of, participant, log):
    participant.answers("Escape")
    with pytest.raises(Exception, match="Escape was pressed"):
        bench_of(held_from(60.0, 1.0)).answer(PRESS)
    assert list(dict.fromkeys(log)) == ["output.open", "output.stop", "output.close", "sensor.close", "screen.close"]


def test_stimulus_starting_at_timeout_is_valid(bench_of, output, log):
    bench = bench_of(held_from(0.0, 1.0), Slow(output, 1.0))
    touched = bench.answer(replace(PRESS, hold_s=0.1, timeout_s=0.4))
    assert touched.digest == TONE.at(5.0).digest()
    assert touched.valid
    assert log == ["output.open", "play 5 V", "output.stop"]


class Failing(Passing):
    def __init__(self, screen, output):
        super().__init__(screen)
        self._output = output

    def refresh(self, page):
        if self._output.begins.is_set():
            raise OSError("no screen")
        return self.wrapped.refresh(page)


def test_devices_stay_open_while_output_starts(bench_of, watched, output, log):
    slow = Slow(output, 0.5)
    bench = bench_of(held_from(0.0, 1.0), slow, Failing(watched, slow))
    with pytest.raises(OSError, match="no screen"):
        bench.answer(PRESS)
    assert log == ["output.open", "play 5 V", "output.stop", "output.close", "sensor.close", "screen.close"]


@pytest.mark.parametrize("lost", [None, math.nan, 11.0], ids=["silent", "lost samples", "excess force"])
def test_ungated_interval_restarts_after_sensor_loss(bench_of, log, lost):
    said = iter([lost] * 300)
    bench = bench_of(lambda time_s: next(said, 1.0) if "play 5 V" in log else 1.0)
    played = bench.answer(Play("tone", 5.0, 1.0))
    assert log[:3] == ["output.open", "play 5 V", "output.stop"]
    assert log.count("play 5 V") == 1 + bench._supervisor._n_pauses > 1  # a busy machine may pause more than once
    assert log[-1] == "play 5 V"
    assert played.digest == TONE.at(5.0).digest()


def test_adjustment_restarts_after_sensor_loss(bench_of, log, participant):
    said, again = iter([None] * 300), threading.Event()

    def force_n(time_s):
        if "play 5 V" not in log:
            return 1.0
        if log[-1] == "play 5 V" and "output.stop" in log[log.index("play 5 V") :]:
            again.set()
        return next(said, 1.0)

    bench = bench_of(force_n)
    participant.answers(again, 0.5, "Return")
    assert bench.answer(Adjust("tone", start=5.0, step=5.0, low=0.0, high=20.0)).level == 5.0
    assert bench._supervisor._n_pauses == 1
    assert log[-1] == "output.stop"


def test_next_touch_shows_why_last_was_invalid(bench_of, watched):
    told = "Too light: press more, until the bar stays between the lines"
    bench = bench_of(lambda time_s: 1.0)

    def of_next(*before, **row):
        for request in (Record(replace(TRIAL, **row)), *before):
            bench.answer(request)
        watched.pages.clear()
        bench.answer(PRESS)
        return [told in words_of(page) for page in watched.pages]

    lost = {"valid": False, "invalid_reason": "too_light"}
    assert of_next(**lost) == [True, False]
    assert of_next() == [False, False]
    assert of_next(Show("resting", duration_s=0.1), **lost) == [False, False]
