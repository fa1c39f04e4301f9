"""Slides in the window with force and position sampled in real time."""

import time
from dataclasses import replace

import pytest
from sampled import Sampled

from tactometry.devices.sensors.reader import Reader
from tactometry.devices.sensors.streamed import ForceCalibration, streamed_force, streamed_position
from tactometry.gates import triangle
from tactometry.rigs.bench import ASSUMED_DISPLAY_HEIGHT_M
from tactometry.session.request import Slide
from tactometry.stimuli.electrovibration import Sine

TONE = Sine(frequency_hz=60.0, duration_s=0.6, ramp_s=0.02, level_unit="V")
SLIDE = Slide("tone", 5.0, 0.6, 1.0, 0.2, 0.1, 1.5, speed_m_per_s=0.05, length_m=0.02, speed_tolerance=0.4)
PATH_M = 0.02


@pytest.fixture
def slid(bench_of):
    """A function that slides a finger of constant force along positions."""

    def slide(place_m, request=SLIDE):
        force, place = (Reader(Sampled(value, rate_hz=500.0)) for value in (lambda time_s: 1.0, place_m))
        sensor = streamed_force(force, 0, ForceCalibration(newtons_per_count=1.0))
        rig = bench_of(sensor=sensor, position=streamed_position(place, (0,), 1.0), tone=TONE)
        touched = rig.answer(request)
        rig.close()
        return touched

    return slide


def test_slide_following_the_cursor_is_valid(slid, log):
    touched = slid(lambda time_s: float(triangle(0.05 * time_s, PATH_M)))
    assert (touched.valid, touched.invalid_reason) == (True, None)
    assert touched.speed_mean_m_per_s == pytest.approx(0.05, rel=0.1)
    assert 0.8 <= touched.speed_in_band <= 1
    assert "play 5 V" in log


NEVER_GATED = {
    "resting": (lambda time_s: 0.01, "timeout"),
    "double speed": (lambda time_s: float(triangle(0.1 * time_s, PATH_M)), "timeout"),
    "no position": (lambda time_s: None, "sensor_lost"),
}


@pytest.mark.parametrize(("place_m", "reason"), NEVER_GATED.values(), ids=NEVER_GATED)
def test_slide_off_the_cursor_receives_no_stimulus(slid, log, place_m, reason):
    touched = slid(place_m)
    assert (touched.valid, touched.invalid_reason) == (False, reason)
    assert (touched.digest, touched.level_delivered) == (None, None)
    assert "play 5 V" not in log


def stop_and_go(log):
    """Return positions of a finger that pauses while the stimulus plays.

    It moves steadily until the stimulus begins, then rests for 0.1 s after each 0.12 s, which is too short to count
    as stopped.
    """
    begun_s = []

    def place_m(time_s):
        if not begun_s:
            if "play 5 V" not in log:
                return 0.05 * time_s
            begun_s.append(time_s)
        n_rests, since_s = divmod(time_s - begun_s[0], 0.22)
        return 0.05 * (begun_s[0] + 0.12 * n_rests + min(since_s, 0.12))

    return place_m


def test_stop_and_go_slide_is_too_slow(slid, log):
    """The log has two stops: one ends the touch, one closes the output."""
    touched = slid(stop_and_go(log))
    assert (touched.valid, touched.invalid_reason) == (False, "too_slow")
    assert touched.force_in_band == 1.0
    assert touched.speed_in_band < 0.8
    assert log == ["output.open", "play 5 V", "output.stop", "output.stop", "output.close", "screen.close"]


def accelerating(log):
    """Return positions of a finger that moves at three times the speed once the stimulus plays."""
    begun_s = []

    def place_m(time_s):
        if "play 5 V" in log:
            begun_s.append(time_s)
        return 0.05 * time_s + (0.1 * (time_s - begun_s[0]) if begun_s else 0.0)

    return place_m


CUT = {
    "stopped": lambda log: lambda time_s: 0.05 * min(time_s, 0.5),
    "too_fast": accelerating,
    "sensor_lost": lambda log: lambda time_s: None if "play 5 V" in log else 0.05 * time_s,
}


@pytest.mark.parametrize("reason", CUT)
def test_slide_that_leaves_the_cursor_is_cut(slid, log, reason):
    touched = slid(CUT[reason](log))
    assert (touched.valid, touched.invalid_reason) == (False, reason)
    assert touched.digest is not None
    assert log.index("play 5 V") < log.index("output.stop")


def test_speed_is_measured_but_ungated_without_tolerance(slid):
    touched = slid(lambda time_s: float(triangle(0.1 * time_s, PATH_M)), replace(SLIDE, speed_tolerance=None))
    assert touched.valid
    assert touched.speed_mean_m_per_s == pytest.approx(0.1, rel=0.2)
    assert touched.speed_in_band is None


def test_page_shows_finger_and_moving_dot(slid, watched):
    """Finger and dot move at the same speed while the rig waits for a force."""
    waiting = replace(SLIDE, target_n=5.0, timeout_s=4.0)
    slid(lambda time_s: triangle(0.05 * max(0.0, time_s - 0.08), PATH_M), waiting)
    tracks = [[item for item in page.items if getattr(item, "y", 0) == -0.23] for page in watched.drawn]
    dots, rings = zip(*[(track[1].x, track[2].x) for track in tracks if len(track) == 3], strict=True)
    half = 0.5 * PATH_M / ASSUMED_DISPLAY_HEIGHT_M
    assert len(rings) > 10
    assert min(rings) < -0.3 * half < 0.3 * half < max(rings)
    assert max(map(abs, [*dots, *rings])) <= 1.1 * half


def test_session_pauses_until_position_sensor_returns(slid):
    begin_s = time.perf_counter()

    def place_m(time_s):
        if time.perf_counter() < begin_s + 2 * SLIDE.timeout_s:
            raise OSError("unplugged")
        return float(triangle(0.05 * time_s, PATH_M))

    assert slid(place_m).valid
