"""The decision in the sensors' threads: never early, once, and not after it was called off."""

import math
import queue
import sys
import threading
import time

import numpy as np
import pytest
from hypothesis import given, strategies as st
from patience import LONGEST_WAIT_S

from tactometry.devices.sensors.reader import Reader
from tactometry.errors import DeviceFailed
from tactometry.rigs.emitter import Emitter
from tactometry.rigs.touch.gated_samples import DEAF_S, MOVING_S, SILENT_S, Trace
from tactometry.rigs.touch.touch import Held
from tactometry.rigs.touch.trigger import TURN_S, Trigger, hearing, quick_turns
from tactometry.session.request import Press, Slide
from tactometry.signal import Signal

PERIOD_S = 1 / 256
HALT_S = 0.15
SPEED = 0.05
AHEAD_S = 1000.0
"""Stamps that lie ahead of our clock are of now."""


def press(hold_s, tolerance=0.2):
    return Press("tone", 5.0, 0.3, target_n=1.0, tolerance=tolerance, hold_s=hold_s, timeout_s=5.0)


def slide(hold_s):
    return Slide("tone", 5.0, 0.3, 1.0, 0.2, hold_s, timeout_s=5.0, speed_m_per_s=SPEED, speed_tolerance=0.2)


def stamps_s(n):
    return math.floor(time.perf_counter() + AHEAD_S) + PERIOD_S * np.arange(n)


def n_last(samples, holds):
    """How many samples in a row, up to the last, hold."""
    return next((n for n, sample in enumerate(reversed(samples)) if not holds(sample)), len(samples))


def spans(n_samples, hold_s):
    return n_samples > 0 and (n_samples - 1) * PERIOD_S >= hold_s


def in_turns(hear, times_s, values):
    """A reader's samples, one block of one after the other: nothing returns before it was heard."""
    for n in range(len(times_s)):
        hear(times_s[n : n + 1], values[n : n + 1])
        yield n


forces_n = st.sampled_from([0.79, 1.21, 5.0, 0.0, math.nan])
runs = st.lists(st.tuples(st.sampled_from([0.8, 1.0, 1.2]), st.integers(1, 30), forces_n), min_size=1, max_size=5)


@given(runs, st.sampled_from([0.0, 8 * PERIOD_S, 0.1]))
def test_a_press_begins_only_where_its_own_force_was_held_for_its_own_time(runs, hold_s):
    trace = np.array([force for held, n, broken in runs for force in [*[held] * n, broken, held]])
    held = Held(press(hold_s), moving=False)
    for n in in_turns(held.applied_force.hear, stamps_s(len(trace)), trace):
        true = spans(n_last(trace[: n + 1], lambda force: abs(force - 1.0) <= 0.2), hold_s)
        assert true or not held.open
        assert held.applied_force.gate.open == true
        assert math.isnan(trace[n]) == (held.applied_force.force_n is None)


class Clock:
    """Ours, at the last stamp that was heard."""

    now_s = 0.0

    def perf_counter(self):
        return self.now_s

    def follows(self, times_s):
        for n, self.now_s in enumerate(times_s.tolist()):
            yield n


def test_a_slide_begins_only_where_both_are_held(monkeypatch):
    """Force from the first sample, motion from the 40th; then the other way round."""
    monkeypatch.setattr("tactometry.rigs.touch.gated_samples.time", clock := Clock())
    for first_moves, first_holds in ((40, 0), (0, 40)):
        held, n_samples = Held(slide(hold_s=0.1), moving=True), 100
        times_s = stamps_s(n_samples)
        clock.now_s = times_s[0]
        steps_m = np.where(np.arange(n_samples) > first_moves, SPEED * PERIOD_S, 0.0)
        places_m = np.cumsum(steps_m)[:, None]
        forces = np.where(np.arange(n_samples) >= first_holds, 1.0, 0.5)
        heard = zip(
            clock.follows(times_s),
            in_turns(held.applied_force.hear, times_s, forces),
            in_turns(held.finger_motion.hear, times_s, places_m),
            strict=True,
        )
        opened = [n for n, _, _ in heard if held.open]
        needed_s = {40: MOVING_S, 0: 0.1}[first_moves]
        assert opened
        assert opened[0] >= 40 + needed_s / PERIOD_S
        assert held.opened_s == max(held.applied_force.opened_s, held.finger_motion.opened_s) == times_s[opened[0]]


def test_a_gate_opens_when_the_hold_was_heard_of_for_so_long_by_our_clock(monkeypatch):
    """All stamps of a hold come at once, then one of each millisecond: the gate is open by its stamps, and waits."""
    monkeypatch.setattr("tactometry.rigs.touch.gated_samples.time", clock := Clock())
    held, times_s = Held(press(hold_s=0.0995), moving=False), stamps_s(1)[0] + np.arange(300) / 1000
    clock.now_s = times_s[150]
    held.applied_force.hear(times_s[:150], np.ones(150))
    opened = []
    for n in range(150, 300):
        clock.now_s = times_s[n]
        held.applied_force.hear(times_s[n : n + 1], np.ones(1))
        assert held.applied_force.gate.open
        opened.append(held.open)
    assert opened == [n >= 250 for n in range(150, 300)]


def test_a_finger_that_halts_is_lost_though_its_force_is_held():
    held, n_moving, n_samples = Held(slide(hold_s=0.1), moving=True), 60, 60 + round((HALT_S + 0.1) / PERIOD_S)
    times_s = stamps_s(n_samples)
    places_m = SPEED * PERIOD_S * np.minimum(np.arange(n_samples), n_moving)[:, None]
    lost = []
    for _ in zip(
        in_turns(held.applied_force.hear, times_s, np.ones(n_samples)),
        in_turns(held.finger_motion.hear, times_s, places_m),
        strict=True,
    ):
        lost.append(held.breaks())
        assert not held.applied_force.loss
    assert not any(lost[: n_moving + round(HALT_S / PERIOD_S)])
    assert lost[-1]


def test_a_slide_whose_speed_is_not_gated_is_a_press():
    held = Held(slide(hold_s=0.0), moving=False)
    held.applied_force.hear(stamps_s(1), np.ones(1))
    assert held.finger_motion is None
    assert held.open


@pytest.mark.parametrize("part", [0.11, 0.09])
def test_below_a_tenth_of_its_target_the_finger_has_left(part):
    held = Held(press(0.0), moving=False)
    held.applied_force.hear(stamps_s(1), np.array([part]))
    assert held.breaks() == (part < 0.1)


def test_a_sensor_that_tells_nothing_but_lost_samples_is_lost():
    held, n_known, n_samples = Held(press(0.0), moving=False), 10, 50
    forces = np.where(np.arange(n_samples) < n_known, 1.0, math.nan)
    lost = [held.breaks() for _ in in_turns(held.applied_force.hear, stamps_s(n_samples), forces)]
    assert lost.index(True) == n_known + math.floor(SILENT_S / PERIOD_S)


# --- the trigger


class Scene:
    """What a trigger asks and does, in a list."""

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


def test_it_fires_once_when_it_opens_and_stops_once_when_it_breaks(scene):
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


def test_what_may_not_play_just_now_is_tried_again(scene):
    assert scene.considered(opens=True, muted=True) == ["muted"]
    assert scene.trigger.begun is None
    assert scene.considered(muted=False) == ["muted", "fire"]


@pytest.mark.parametrize("begun", [False, True])
def test_called_off_it_neither_fires_nor_stops(scene, begun):
    done = scene.considered(opens=begun).copy()
    scene.trigger.disarm()
    assert scene.considered(opens=True, breaks=True) == done


def test_calling_off_waits_for_what_is_under_way_and_nobody_else_does(scene, in_background):
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
    """An output that has begun to begin."""

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


def test_what_begins_while_it_is_muted_is_stopped_and_nothing_begins_until_it_is_not(in_background):
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
    """An output whose driver never comes back from its beginning."""

    name = "hung"

    def stop(self):
        self.done.append("stop")


def test_no_session_waits_for_an_output_that_hangs_as_it_begins(in_background, monkeypatch):
    monkeypatch.setattr("tactometry.rigs.emitter.BEGIN_WITHIN_S", 0.1)
    output = Hung()
    emitter, signal = Emitter({}, output, None), Signal(np.zeros((1, 1)), 1000.0, "V")
    trigger = Trigger(lambda: True, lambda: False, lambda: emitter.emit_if_allowed(signal), emitter.stop)
    in_background(trigger.consider)
    assert output.begins.wait(LONGEST_WAIT_S)
    begin_s = time.perf_counter()
    with pytest.raises(
        DeviceFailed, match="output 'hung': it hangs, and did not begin within 0.1 s: switch its amplif"
    ):
        emitter.mute(on=True)
    trigger.disarm(longest_s=0.1)
    assert time.perf_counter() - begin_s < 2.0
    output.may_go_on.set()


@pytest.mark.parametrize("fails", ["opens", "fire", "breaks", "stop"])
def test_what_went_wrong_is_raised_where_the_session_is_led_and_not_tried_again(fails):
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
    for asked in ("begun", "broken"):
        with pytest.raises(OSError, match="the device is gone"):
            getattr(trigger, asked)


def test_threads_take_quick_turns_only_while_a_decision_is_awaited():
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


# --- what is heard


class Teller:
    """A sensor that tells one who listens."""

    hear = None

    def subscribe(self, hear):
        self.hear = hear
        return lambda: setattr(self, "hear", None)


def test_the_decision_follows_what_was_heard_and_ends_with_it():
    sensor, heard = Teller(), []

    def fail():
        with hearing(sensor, lambda *block: heard.append(block), lambda: heard.append("then")):
            sensor.hear(1, 2)
            raise KeyError

    with pytest.raises(KeyError):
        fail()
    assert heard == [(1, 2), "then"]
    assert sensor.hear is None


def test_without_a_sensor_nothing_is_heard():
    with hearing(None, pytest.fail):
        pass


def told(*blocks):
    trace = Trace()
    for times_s, values in blocks:
        trace.hear(np.array(times_s, dtype=float), np.array(values, dtype=float))
    return trace


def test_only_the_known_samples_of_an_interval_are_given():
    trace = told(([1, 2], [10, 20]), ([], []), ([3, 4, 5], [math.nan, 40, 50]))
    times_s, values = trace.between(2.0, 4.0)
    assert (times_s.tolist(), values.tolist()) == ([2, 4], [20, 40])
    assert trace.between(6.0, 7.0)[0].size == told().between(0.0, 9.0)[0].size == 0


def test_where_a_stamp_goes_back_no_samples_are_given():
    trace = told(([1, 2], [1, 2]), ([1.5, 3], [3, 4]))
    assert trace.between(0.0, 9.0)[0].size == 0
    assert trace.between(1.6, 9.0)[0].tolist() == [2, 3]


def test_a_thread_that_says_nothing_at_all_is_held_up():
    trace = told(([time.perf_counter()], [1]))
    time.sleep(DEAF_S + 0.01)
    assert trace.quiet(60.0)
    assert DEAF_S <= 0.5
    trace.hear(np.empty(0), np.empty(0))
    assert not trace.quiet(60.0)


class Gone:
    """A sensor that is there once, and then neither tells nor can be closed at once or found again."""

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
        (
            RuntimeError("an internal\nerror"),
            "gone: found a failure (RuntimeError: an internal error), expected samples",
        ),
    ],
)
def test_while_a_sensor_is_away_its_listeners_are_told_that_nothing_came(error, failure):
    reader, told = Reader(Gone(error)), queue.Queue()
    reader.subscribe(told.put)
    reader.open()
    while reader.source.n_opened < 3:
        assert told.get(timeout=LONGEST_WAIT_S).values.shape == (0, 1)
    reader.close()
    assert reader.facts() == {"n_samples": 0, "n_outages": 1, "failure": failure, "n_steps_back": 0}


class Hanging(Gone):
    """A sensor whose driver comes back neither from reading nor from closing."""

    def __init__(self):
        super().__init__(DeviceFailed("gone"))
        self.hangs = threading.Event()

    def receive(self):
        self.hangs.wait()

    def close(self):
        self.hangs.wait()


def test_a_driver_that_hangs_keeps_no_session_from_its_end(monkeypatch):
    monkeypatch.setattr("tactometry.devices.sensors.reader.CLOSE_WITHIN_S", 0.1)
    reader = Reader(Hanging())
    reader.open()
    begin_s = time.perf_counter()
    with pytest.raises(DeviceFailed, match="^gone: it hangs, and did not end within 0.1 s: unplug it"):
        reader.close()
    assert 0.2 <= time.perf_counter() - begin_s < 1.0
    reader.source.hangs.set()


def test_a_sensor_that_fails_as_it_is_opened_is_a_failed_device():
    source = Gone(RuntimeError("an internal error"))
    source.n_opened = 1
    with pytest.raises(DeviceFailed, match=r"^gone: found a failure \(RuntimeError: an internal error\), expected"):
        Reader(source).open()
