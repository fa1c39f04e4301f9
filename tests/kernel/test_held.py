"""Held forces and speeds: gates never open early and detect a lost finger."""

import math
import time

import numpy as np
import pytest
from hypothesis import given, strategies as st

from tactometry.rigs.touch.gated_samples import DEAF_S, MOVING_S, SILENT_S, Trace
from tactometry.rigs.touch.touch import Held
from tactometry.session.request import Press, Slide

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
    """Count the consecutive samples up to the last for which `holds` is true."""
    return next((n for n, sample in enumerate(reversed(samples)) if not holds(sample)), len(samples))


def spans(n_samples, hold_s):
    return n_samples > 0 and (n_samples - 1) * PERIOD_S >= hold_s


def in_turns(hear, times_s, values):
    """Pass samples to a listener in blocks of one, as a reader does."""
    for n in range(len(times_s)):
        hear(times_s[n : n + 1], values[n : n + 1])
        yield n


forces_n = st.sampled_from([0.79, 1.21, 5.0, 0.0, math.nan])
runs = st.lists(st.tuples(st.sampled_from([0.8, 1.0, 1.2]), st.integers(1, 30), forces_n), min_size=1, max_size=5)


@given(runs, st.sampled_from([0.0, 8 * PERIOD_S, 0.1]))
def test_press_gate_opens_after_exact_hold_time(runs, hold_s):
    trace = np.array([force for held, n, broken in runs for force in [*[held] * n, broken, held]])
    held = Held(press(hold_s), moving=False)
    for n in in_turns(held.applied_force.on_samples, stamps_s(len(trace)), trace):
        true = spans(n_last(trace[: n + 1], lambda force: abs(force - 1.0) <= 0.2), hold_s)
        assert true or not held.open
        assert held.applied_force.gate.open == true
        assert math.isnan(trace[n]) == (held.applied_force.force_n is None)


class Clock:
    """Local clock, set to the last stamp received."""

    now_s = 0.0

    def perf_counter(self):
        return self.now_s

    def follows(self, times_s):
        for n, self.now_s in enumerate(times_s.tolist()):
            yield n


def test_slide_begins_when_force_and_speed_are_held(monkeypatch):
    """Motion begins 40 samples after force, then in reverse."""
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
            in_turns(held.applied_force.on_samples, times_s, forces),
            in_turns(held.finger_motion.on_samples, times_s, places_m),
            strict=True,
        )
        opened = [n for n, _, _ in heard if held.open]
        needed_s = {40: MOVING_S, 0: 0.1}[first_moves]
        assert opened
        assert opened[0] >= 40 + needed_s / PERIOD_S
        assert held.opened_s == max(held.applied_force.opened_s, held.finger_motion.opened_s) == times_s[opened[0]]


def test_gate_waits_for_hold_time_on_local_clock(monkeypatch):
    """By its stamps the gate is open, but the local clock decides."""
    monkeypatch.setattr("tactometry.rigs.touch.gated_samples.time", clock := Clock())
    held, times_s = Held(press(hold_s=0.0995), moving=False), stamps_s(1)[0] + np.arange(300) / 1000
    clock.now_s = times_s[150]
    held.applied_force.on_samples(times_s[:150], np.ones(150))
    opened = []
    for n in range(150, 300):
        clock.now_s = times_s[n]
        held.applied_force.on_samples(times_s[n : n + 1], np.ones(1))
        assert held.applied_force.gate.open
        opened.append(held.open)
    assert opened == [n >= 250 for n in range(150, 300)]


def test_halted_finger_is_lost_when_force_is_held():
    held, n_moving, n_samples = Held(slide(hold_s=0.1), moving=True), 60, 60 + round((HALT_S + 0.1) / PERIOD_S)
    times_s = stamps_s(n_samples)
    places_m = SPEED * PERIOD_S * np.minimum(np.arange(n_samples), n_moving)[:, None]
    lost = []
    for _ in zip(
        in_turns(held.applied_force.on_samples, times_s, np.ones(n_samples)),
        in_turns(held.finger_motion.on_samples, times_s, places_m),
        strict=True,
    ):
        lost.append(held.breaks())
        assert not held.applied_force.loss
    assert not any(lost[: n_moving + round(HALT_S / PERIOD_S)])
    assert lost[-1]


def test_slide_without_speed_gate_is_a_press():
    held = Held(slide(hold_s=0.0), moving=False)
    held.applied_force.on_samples(stamps_s(1), np.ones(1))
    assert held.finger_motion is None
    assert held.open


@pytest.mark.parametrize("part", [0.11, 0.09])
def test_finger_has_left_below_tenth_of_target(part):
    held = Held(press(0.0), moving=False)
    held.applied_force.on_samples(stamps_s(1), np.array([part]))
    assert held.breaks() == (part < 0.1)


def test_touch_breaks_when_all_samples_are_lost():
    held, n_known, n_samples = Held(press(0.0), moving=False), 10, 50
    forces = np.where(np.arange(n_samples) < n_known, 1.0, math.nan)
    lost = [held.breaks() for _ in in_turns(held.applied_force.on_samples, stamps_s(n_samples), forces)]
    assert lost.index(True) == n_known + math.floor(SILENT_S / PERIOD_S)


def traced(*blocks):
    trace = Trace()
    for times_s, values in blocks:
        trace.on_samples(np.array(times_s, dtype=float), np.array(values, dtype=float))
    return trace


def test_trace_interval_contains_known_samples_only():
    trace = traced(([1, 2], [10, 20]), ([], []), ([3, 4, 5], [math.nan, 40, 50]))
    times_s, values = trace.between(2.0, 4.0)
    assert (times_s.tolist(), values.tolist()) == ([2, 4], [20, 40])
    assert trace.between(6.0, 7.0)[0].size == traced().between(0.0, 9.0)[0].size == 0


def test_trace_interval_is_empty_when_stamps_go_back():
    trace = traced(([1, 2], [1, 2]), ([1.5, 3], [3, 4]))
    assert trace.between(0.0, 9.0)[0].size == 0
    assert trace.between(1.6, 9.0)[0].tolist() == [2, 3]


def test_silent_thread_counts_as_held_up():
    trace = traced(([time.perf_counter()], [1]))
    time.sleep(DEAF_S + 0.01)
    assert trace.quiet(60.0)
    assert DEAF_S <= 0.5
    trace.on_samples(np.empty(0), np.empty(0))
    assert not trace.quiet(60.0)
