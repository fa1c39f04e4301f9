"""Slides in the window with force and position sampled in real time: nothing plays on a finger that does not move."""

import time

import numpy as np
import pytest

from tactometry.request import Slide
from tactometry.rigs.bench import Bench
from tactometry.rigs.texts import texts_in
from tactometry.speed_gate import triangle
from tactometry.stimuli.electrovibration import Sine

TONE = Sine(frequency_hz=60.0, duration_s=0.6, ramp_s=0.02, level_unit="V")
SLIDE = Slide("tone", 5.0, 0.6, 1.0, 0.2, 0.1, 1.5, speed_m_per_s=0.05, length_m=0.02, speed_tolerance=0.4)
PATH_M = 0.02


class Sampled:
    """A sensor that samples a function of the time since it was opened at 500 Hz, on the real clock."""

    name, rate_hz = "sampled", 500.0

    def __init__(self, value):
        self._value = value

    def open(self):
        self._zero_s, self._n_read = time.perf_counter(), 0

    def read(self):
        n_due = int((time.perf_counter() - self._zero_s) * self.rate_hz)
        times_s = np.arange(self._n_read, n_due) / self.rate_hz
        self._n_read = n_due
        return times_s + self._zero_s, np.array([self._value(time_s) for time_s in times_s])

    def close(self):
        pass


class SampledPlace(Sampled):
    def read(self):
        times_s, places_m = super().read()
        return times_s, places_m.reshape(len(times_s), 1)


@pytest.fixture
def slid(watched, output, log):
    """A slide of a finger that holds its force, at these places."""

    def slide(place_m, request=SLIDE):
        parts = {"sensor": Sampled(lambda time_s: 1.0), "position": SampledPlace(place_m)}
        rig = Bench(watched, output, {"tone": TONE}, limits=None, texts=texts_in("en", {}), **parts)
        try:
            return rig.slide(request)
        finally:
            rig.close()

    return slide


def test_a_finger_that_follows_the_cursor_out_and_back_feels_a_valid_stimulus(slid, log):
    touched = slid(lambda time_s: float(triangle(0.05 * time_s, PATH_M)))
    assert touched.valid
    assert touched.speed_mean_m_per_s == pytest.approx(0.05, rel=0.1)
    assert "play 5 V" in log


def test_nothing_plays_on_a_finger_at_rest(slid, log):
    touched = slid(lambda time_s: 0.01)
    assert (touched.valid, touched.digest, touched.level_delivered) == (False, None, None)
    assert "play 5 V" not in log


def test_the_stimulus_stops_when_the_finger_stops(slid, log):
    begin_s = time.perf_counter()
    touched = slid(lambda time_s: 0.05 * min(time_s, 0.5))
    assert not touched.valid
    assert touched.digest is not None
    assert log.index("play 5 V") < log.index("output.stop")
    assert time.perf_counter() - begin_s < 10


def test_a_finger_at_twice_the_speed_never_starts(slid, log):
    assert not slid(lambda time_s: float(triangle(0.1 * time_s, PATH_M))).valid
    assert "play 5 V" not in log


def test_without_a_band_the_speed_is_measured_and_not_gated(slid):
    from dataclasses import replace

    touched = slid(lambda time_s: float(triangle(0.1 * time_s, PATH_M)), replace(SLIDE, speed_tolerance=None))
    assert touched.valid
    assert touched.speed_mean_m_per_s == pytest.approx(0.1, rel=0.2)
