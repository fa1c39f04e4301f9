"""Silence within one audio block after anything that ends a stimulus.

Ended and killed processes are tested in `tests/devices/test_session.py` and `test_audio.py`.
"""

import math

import player
import pytest
from zero_scene import N_HEARD, PRESS, RATE_HZ, BadError, Noting, Scene

from tactometry.errors import Stopped
from tactometry.session.request import Press


@pytest.fixture
def driver(portaudio):
    return Noting(
        player.settings({"rate_hz": RATE_HZ, "n_channels": 2, "device": "pulse", "latency_s": 0.2}).driver(player.GAIN)
    )


@pytest.fixture
def scene(watched, driver, sink):
    made = Scene(watched, driver, sink)
    yield made
    made.bench.close()


@pytest.mark.parametrize(
    "force_n", [None, math.nan, 0.05], ids=["the sensor falls silent", "its samples are lost", "the finger leaves"]
)
def test_sound_stops_when_force_is_lost(scene, in_background, force_n):
    in_background(scene.when_heard, setattr, scene, "force_n", force_n)
    touched = scene.bench.answer(PRESS)
    scene.ended.set()
    if scene.force_n == 1.0:
        pytest.skip("the computer was too busy for the sensor")
    assert not touched.valid
    assert N_HEARD < scene.heard() <= scene.driver.n_given + 2 * 240


@pytest.mark.usefixtures("unhurried_sensors")
def test_sound_stops_on_escape(scene, in_background, hands):
    in_background(scene.when_heard, hands.tap, "Escape")
    with pytest.raises(Stopped, match="Escape was pressed"):
        scene.bench.answer(PRESS)
    assert N_HEARD < scene.heard() <= scene.driver.n_given + 2 * 240


@pytest.mark.usefixtures("unhurried_sensors")
def test_sound_stops_on_error(scene, in_background):
    in_background(scene.when_heard, scene.screen.fails.set)
    with pytest.raises(BadError):
        scene.bench.answer(PRESS)
    assert N_HEARD < scene.heard() <= scene.driver.n_given + 2 * 240


@pytest.mark.usefixtures("unhurried_sensors")
def test_sound_ends_with_the_touch(scene):
    assert scene.bench.answer(Press("short", 1.0, 0.5, 1.0, 0.2, hold_s=0.1, timeout_s=30.0)).valid
    n_whole = round(0.5 * RATE_HZ)
    assert n_whole - 10 <= scene.heard("short") <= n_whole
