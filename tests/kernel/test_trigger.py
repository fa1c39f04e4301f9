"""Trigger in the sensor threads: fires once, never blocks."""

import queue
import sys
import threading
import time

import numpy as np
import pytest
from patience import LONGEST_WAIT_S

from tactometry.devices.sensors.reader import Reader
from tactometry.errors import DeviceFailed
from tactometry.rigs.emitter import Emitter
from tactometry.rigs.touch.trigger import TURN_S, Trigger, quick_turns, receiving
from tactometry.signal import Signal


class Scene:
    """Callbacks of a trigger, recorded in a list."""

    def __init__(self):
        self.opens = self.breaks = self.muted = False
        self.done, self.at_work, self.may_end = [], threading.Event(), threading.Event()
        self.may_end.set()
        self.trigger = Trigger(lambda: self.opens, lambda: self.breaks, self.fire, lambda: self.done.append("stop"))

    def fire(self):
        self.at_work.set()
        assert self.may_end.wait(LONGEST_WAIT_S)
        self.done.append("muted" if self.muted else "fire")
        return None if self.muted else time.perf_counter()

    def considered(self, **changes):
        vars(self).update(changes)
        self.trigger.consider()
        return self.done


@pytest.fixture
def scene():
    return Scene()


def test_trigger_fires_and_stops_once(scene):
    assert scene.considered(breaks=True) == []
    assert (scene.trigger.begun, scene.trigger.broken) == (None, False)
    before_s = time.perf_counter()
    assert scene.considered(opens=True, breaks=False) == ["fire"]
    decided_s, onset_s = scene.trigger.begun
    assert before_s <= decided_s <= onset_s
    assert scene.considered() == ["fire"]
    assert scene.considered(breaks=True) == ["fire", "stop"]
    assert scene.trigger.broken
    assert scene.considered() == ["fire", "stop"]


def test_trigger_retries_when_output_was_muted(scene):
    assert scene.considered(opens=True, muted=True) == ["muted"]
    assert scene.trigger.begun is None
    assert scene.considered(muted=False) == ["muted", "fire"]


@pytest.mark.parametrize("begun", [False, True])
def test_disarmed_trigger_neither_fires_nor_stops(scene, begun):
    done = scene.considered(opens=begun).copy()
    scene.trigger.disarm()
    assert scene.considered(opens=True, breaks=True) == done


def test_only_disarm_waits_for_a_running_step(scene, in_background):
    scene.opens = True
    scene.may_end.clear()
    in_background(scene.trigger.consider)
    assert scene.at_work.wait(LONGEST_WAIT_S)
    other, off = threading.Thread(target=scene.trigger.consider), threading.Thread(target=scene.trigger.disarm)
    other.start()
    other.join(LONGEST_WAIT_S)
    assert not other.is_alive()
    off.start()
    off.join(0.05)
    assert off.is_alive()
    scene.may_end.set()
    off.join(LONGEST_WAIT_S)
    assert scene.considered(breaks=True) == ["fire"]


class Beginning:
    """Output that waits while it begins a signal."""

    def __init__(self):
        self.done, self.begins, self.may_go_on = [], threading.Event(), threading.Event()

    def play(self, signal):
        self.begins.set()
        assert self.may_go_on.wait(LONGEST_WAIT_S)
        self.done.append("play")
        return time.perf_counter()

    def stop(self):
        self.done.append("stop")
        self.may_go_on.set()


def test_muted_emitter_stops_and_refuses_signals(in_background):
    output = Beginning()
    emitter, signal = Emitter({}, output, None), Signal(np.zeros((1, 1)), 1000.0, "V")
    in_background(emitter.emit_if_allowed, signal)
    assert output.begins.wait(LONGEST_WAIT_S)
    emitter.mute(on=True)
    assert output.done == ["stop", "play", "stop"]
    assert emitter.emit_if_allowed(signal) is None
    emitter.mute(on=False)
    assert emitter.emit_if_allowed(signal) is not None
    assert output.done.count("play") == 2


class Hung(Beginning):
    """Output whose driver never returns from beginning a signal."""

    name = "hung"

    def stop(self):
        self.done.append("stop")


def test_mute_fails_when_output_hangs(in_background, monkeypatch):
    monkeypatch.setattr("tactometry.rigs.emitter.BEGIN_WITHIN_S", 0.1)
    output = Hung()
    emitter, signal = Emitter({}, output, None), Signal(np.zeros((1, 1)), 1000.0, "V")
    trigger = Trigger(lambda: True, lambda: False, lambda: emitter.emit_if_allowed(signal), emitter.stop)
    in_background(trigger.consider)
    assert output.begins.wait(LONGEST_WAIT_S)
    with pytest.raises(DeviceFailed, match="output 'hung': it hangs and did not begin within 0.1 s: switch its"):
        emitter.mute(on=True)
    trigger.disarm(longest_s=0.1)
    output.may_go_on.set()


@pytest.mark.parametrize("fails", ["opens", "fire", "breaks", "stop"])
def test_trigger_reports_errors_to_the_session_without_retrying(fails):
    def failing(name, value):
        def step():
            called.append(name)
            if name == fails:
                raise OSError("the device is gone")
            return value

        return step

    called = []
    trigger = Trigger(failing("opens", True), failing("breaks", True), failing("fire", 1.0), failing("stop", None))
    for _ in range(3):
        trigger.consider()
    assert called.count(fails) == 1
    assert called[-1] == fails
    for name in ("begun", "broken"):
        with pytest.raises(OSError, match="the device is gone"):
            getattr(trigger, name)


def test_quick_turns_restores_the_switch_interval():
    def fail():
        with quick_turns():
            assert sys.getswitchinterval() == pytest.approx(TURN_S)
            raise KeyError

    usual_s = sys.getswitchinterval()
    with pytest.raises(KeyError):
        fail()
    assert sys.getswitchinterval() == usual_s > TURN_S
    try:
        sys.setswitchinterval(TURN_S / 4)
        with quick_turns():
            assert sys.getswitchinterval() == pytest.approx(TURN_S / 4)
    finally:
        sys.setswitchinterval(usual_s)


# --- listening to sensors


class Teller:
    """Sensor with one listener."""

    hear = None

    def subscribe(self, hear):
        self.hear = hear
        return lambda: setattr(self, "hear", None)


def test_receiving_calls_listener_and_callback_until_exit():
    sensor, heard = Teller(), []

    def fail():
        with receiving(sensor, lambda *block: heard.append(block), lambda: heard.append("then")):
            sensor.hear(1, 2)
            raise KeyError

    with pytest.raises(KeyError):
        fail()
    assert heard == [(1, 2), "then"]
    assert sensor.hear is None


def test_receiving_without_sensor_calls_nothing():
    with receiving(None, pytest.fail):
        pass


class Gone:
    """Sensor that opens once, then fails to read, close and reopen."""

    name, n_channels, rate_hz = "gone", 1, 1000.0

    def __init__(self, error):
        self.error, self.n_opened, self.n_closed = error, 0, 0

    def open(self):
        self.n_opened += 1
        if self.n_opened > 1:
            raise self.error

    def receive(self):
        raise self.error

    def close(self):
        self.n_closed += 1
        if self.n_closed == 1:
            raise self.error

    def facts(self):
        return {}


@pytest.mark.parametrize(
    ("error", "failure"),
    [
        (DeviceFailed("gone: it is not there"), "gone: it is not there"),
        (RuntimeError("an\nerror"), "gone: found a failure (RuntimeError: an error), expected samples"),
    ],
)
def test_listeners_get_empty_blocks_when_sensor_is_away(error, failure):
    reader, blocks = Reader(Gone(error)), queue.Queue()
    reader.subscribe(blocks.put)
    reader.open()
    while reader.source.n_opened < 3:
        assert blocks.get(timeout=LONGEST_WAIT_S).values.shape == (0, 1)
    reader.close()
    assert reader.facts() == {"n_samples": 0, "n_outages": 1, "failure": failure, "n_steps_back": 0}


class Hanging(Gone):
    """Sensor whose driver returns neither from reading nor from closing."""

    def __init__(self):
        super().__init__(DeviceFailed("gone"))
        self.hangs = threading.Event()

    def receive(self):
        self.hangs.wait()

    def close(self):
        self.hangs.wait()


def test_session_ends_when_driver_hangs(monkeypatch):
    monkeypatch.setattr("tactometry.devices.sensors.reader.CLOSE_WITHIN_S", 0.1)
    reader = Reader(Hanging())
    reader.open()
    with pytest.raises(DeviceFailed, match="^gone: it hangs and did not end within 0.1 s: unplug it"):
        reader.close()
    reader.source.hangs.set()


def test_sensor_error_on_opening_is_a_failed_device():
    source = Gone(RuntimeError("an internal error"))
    source.n_opened = 1
    with pytest.raises(DeviceFailed, match=r"^gone: found a failure \(RuntimeError: an internal error\), expected"):
        Reader(source).open()
