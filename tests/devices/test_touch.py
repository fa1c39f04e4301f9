"""Events of a touch screen, written to a pipe as the kernel does."""

import os
import time

import numpy as np
import pytest
from hypothesis import given, strategies as st

from tactometry.devices.sensors.reader import Reader
from tactometry.devices.sensors.streamed import streamed_position
from tactometry.devices.sensors.touch_screen import (
    ABSOLUTE,
    EVENT,
    RELATIVE,
    SYNC,
    TRACKING,
    TouchSettings,
    TrackedFinger,
)
from tactometry.errors import DeviceFailed


def report(*events):
    return b"".join(EVENT.pack(0, 0, *event) for event in (*events, (SYNC, 0, 0)))


@pytest.fixture
def screen(tmp_path):
    """Writing end of a pipe, and a position sensor at its reading end."""
    pipe = tmp_path / "event0"
    os.mkfifo(pipe)
    keeper = os.open(pipe, os.O_RDWR)
    sensor = streamed_position(Reader(TouchSettings(str(pipe)).source()), (0, 1), 1e-4)
    sensor.open()
    yield keeper, sensor
    sensor.close()
    os.close(keeper)


def heard(sensor, n):
    positions, end_s = np.empty((0, 2)), time.monotonic() + 20
    while len(positions) < n and time.monotonic() < end_s:
        time.sleep(0.005)
        positions = np.concatenate([positions, sensor.read()[1]])
    return positions


def test_touch_position_follows_events_and_persists(screen):
    keeper, sensor = screen
    os.write(keeper, report((*TRACKING, 3), (ABSOLUTE, 53, 100), (ABSOLUTE, 54, 200)))
    os.write(keeper, report((ABSOLUTE, 53, 110)))
    positions = heard(sensor, 5)
    assert positions[0] == pytest.approx([0.01, 0.02])
    assert np.allclose(positions[1:], [0.011, 0.02])


def test_lifted_finger_has_no_position(screen):
    keeper, sensor = screen
    os.write(keeper, report((*TRACKING, 3), (ABSOLUTE, 53, 100)))
    assert len(heard(sensor, 1))
    os.write(keeper, report((*TRACKING, -1)))
    time.sleep(0.2)
    sensor.read()
    time.sleep(0.2)
    assert sensor.read()[0].size == 0


def test_touch_event_in_two_pieces_is_read(screen):
    keeper, sensor = screen
    events = report((*TRACKING, 3), (ABSOLUTE, 53, 700), (ABSOLUTE, 54, 800))
    os.write(keeper, events[:30])
    time.sleep(0.05)
    os.write(keeper, events[30:])
    assert heard(sensor, 1)[0] == pytest.approx([0.07, 0.08])


@given(st.lists(st.tuples(st.integers(-50, 50), st.integers(-50, 50)), min_size=1))
def test_mouse_steps_are_summed(steps):
    finger = TrackedFinger()
    for x, y in steps:
        finger = finger.after(RELATIVE, 0, x).after(RELATIVE, 1, y)
    assert finger.values[:2] == tuple(map(sum, zip(*steps, strict=True)))
    assert finger.touching


@given(st.integers(0, 50), st.integers(0, 2**15), st.integers(-(2**31), 2**31 - 1))
def test_other_events_leave_finger_unchanged(kind, code, value):
    known = [(ABSOLUTE, 0), (ABSOLUTE, 1), (ABSOLUTE, 53), (ABSOLUTE, 54), (ABSOLUTE, 58), TRACKING]
    if (kind, code) not in [*known, (RELATIVE, 0), (RELATIVE, 1)]:
        assert TrackedFinger().after(kind, code, value) == TrackedFinger()


def test_missing_touch_device_is_named():
    with pytest.raises(DeviceFailed, match="touch no/event: cannot open it .*expected a readable event device"):
        TouchSettings("no/event").source().open()
