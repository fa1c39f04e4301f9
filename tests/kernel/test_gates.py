"""Gates against brute force, and compliance against its definition."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hard_cases import exact_case
from hypothesis import given, strategies as st

from tactometry.errors import InvalidParameter
from tactometry.gates import ForceGate, SpeedGate, compliance, motion, triangle
from tactometry.observers.finger import SimulatedFinger
from tactometry.session.request import Press, Slide

# --- force

GATE = ForceGate(target_n=1.0, tolerance=0.25, hold_s=0.0625, max_gap_s=20 / 1024)
TICK_S = 1 / 1024
"""Multiples of it, their sums and quotients are exact."""

steps = st.one_of(st.integers(1, 20), st.integers(-30, 40))
forces = st.one_of(st.sampled_from([0.75, 1.0, 1.25]), st.sampled_from([0.5, 0.7499, 1.2501, math.nan, math.inf]))
mostly_held = st.lists(
    st.tuples(steps, st.one_of(st.just(1.0), st.just(1.0), st.just(1.0), forces)), min_size=1, max_size=60
)


def fed(gate, samples):
    states = []
    for time_s, force_n in samples:
        gate = gate.after(time_s, force_n)
        states.append(gate.open)
    return states


def stamped_ticks(increments_and_forces):
    times = np.cumsum([step for step, _ in increments_and_forces]) * TICK_S
    return [(float(t), f) for t, (_, f) in zip(times, increments_and_forces, strict=True)]


def held(samples, last, gate):
    """Return True if the force was in band for hold_s up to `last`."""
    for k in range(last, -1, -1):
        run = samples[k : last + 1]
        times = [t for t, _ in run]
        in_band = all(abs(f - gate.target_n) <= gate.tolerance * gate.target_n for _, f in run)
        joined = all(0 <= b - a <= gate.max_gap_s for a, b in itertools.pairwise(times))
        if in_band and joined and times[-1] - times[0] >= gate.hold_s:
            return True
    return False


@given(mostly_held)
def test_force_gate_is_open_exactly_when_force_held(increments):
    samples = stamped_ticks(increments)
    assert fed(GATE, samples) == [held(samples, k, GATE) for k in range(len(samples))]
    exact_case("any course of a force", against="the rule of the gate, sample by sample")


def test_force_gate_opens_exactly_at_hold_s():
    samples = [(k * TICK_S, 1.0) for k in range(65)]
    assert fed(GATE, samples) == [False] * 64 + [True]


@pytest.mark.parametrize(
    "breaker",
    [(30 * TICK_S, 0.5), (30 * TICK_S, math.nan), (30 * TICK_S, math.inf), (math.nan, 1.0)],
    ids=["out of band", "lost", "infinite", "no stamp"],
)
def test_break_restarts_the_hold(breaker):
    before = [(k * TICK_S, 1.0) for k in range(30)]
    after = [(k * TICK_S, 1.0) for k in range(31, 140)]
    states = fed(GATE, [*before, breaker, *after])
    assert states.index(True) == 30 + 1 + 64


dyadic = st.integers(0, 4096).map(lambda k: k / 1024)


@given(st.lists(st.tuples(st.integers(0, 100), dyadic), min_size=1, max_size=80))
def test_compliance_equals_its_definition(increments):
    times = np.cumsum([step for step, _ in increments]) * TICK_S
    values = np.array([force for _, force in increments])
    means = [
        np.mean([f for t, f in zip(times[: k + 1], values, strict=False) if t > times[k] - 0.25])
        for k in range(len(times))
    ]
    expected = np.mean([abs(m - 2.0) <= 0.25 * 2.0 for m in means])
    mean_n, sd_n, in_band = compliance(times, values, 2.0, 0.25)
    assert (mean_n, in_band) == (values.mean(), expected)
    assert sd_n == pytest.approx(math.sqrt(np.mean((values - values.mean()) ** 2)), abs=1e-12)


def test_running_mean_excludes_sample_one_window_ago():
    assert compliance([0.0, 0.25], [3.0, 1.0], 1.0, 0.1).in_band == 0.5
    assert compliance([0.0, 0.25 - TICK_S], [3.0, 1.0], 1.0, 0.1).in_band == 0.0


def test_window_below_stamp_resolution_contains_its_sample():
    assert compliance([1e9, 1e9 + 1], [1.0, 3.0], 1.0, 0.1, window_s=1e-9).in_band == 0.5


@pytest.mark.parametrize(
    ("times", "values", "message"),
    [
        ([], [], "at least one"),
        ([0.0, 1.0], [1.0], "equal numbers of both"),
        ([0.0, 1.0], [1.0, math.nan], r"forces_n\[1\]: found nan"),
        ([math.inf], [1.0], r"times_s\[0\]: found inf"),
        ([0.0, 1.0, 0.5], [1.0, 1.0, 1.0], r"times_s\[2\]: found 0.5 after 1.0"),
    ],
)
def test_compliance_refuses_impossible_traces(times, values, message):
    with pytest.raises(InvalidParameter, match=message):
        compliance(times, values, 1.0, 0.1)


# --- speed

steps_s = st.sampled_from([0.001, 0.005, 0.01, 0.02, 0.0200001, 0.05, 0.0, -0.01, -1.0, math.nan])


def stamped(trace):
    """Accumulate steps into stamps, from the last valid one."""
    now_s, samples = 0.0, []
    for step_s, value in trace:
        now_s = now_s if math.isnan(step_s) else now_s + step_s
        samples.append((math.nan if math.isnan(step_s) else now_s, value))
    return samples


def follows(earlier_s, later_s):
    return 0 < later_s - earlier_s <= 0.02


def speed_at(samples, window_s=0.05):
    """Compute the speed at the last sample from its definition, or None."""
    run = []
    for t, x in samples:
        if not (math.isfinite(t) and math.isfinite(x)):
            run = []
            continue
        run = [*run, (t, x)] if run and follows(run[-1][0], t) else [(t, x)]
    run = [(t, x) for t, x in run if t >= run[-1][0] - window_s]
    if not run or run[-1][0] - run[0][0] < window_s / 2:
        return None
    return abs(run[-1][1] - run[0][1]) / (run[-1][0] - run[0][0])


def motion_was_held(samples, hold_s):
    speeds = [speed_at(samples[: n + 1]) for n in range(len(samples))]
    for begin in range(len(samples)):
        kept = all(speed is not None and abs(speed - 0.05) <= 0.5 * 0.05 for speed in speeds[begin:])
        if kept and samples[-1][0] - samples[begin][0] >= hold_s:
            return True
    return False


@st.composite
def glides(draw):
    """Draw a finger near 50 mm/s that slips occasionally, with sensor defects."""
    place_m, trace = 0.0, []
    for step_s in draw(st.lists(steps_s, max_size=25)):
        advance_s = 0.0 if math.isnan(step_s) else max(step_s, 0.0)
        place_m += advance_s * draw(st.sampled_from([0.05, 0.04, 0.07, 0.0, 0.2, -0.05]))
        trace.append((step_s, draw(st.sampled_from([place_m] * 8 + [math.nan, math.inf]))))
    return trace


@given(trace=glides(), hold_s=st.sampled_from([0.0, 0.01, 0.03]))
def test_speed_gate_is_open_exactly_when_speed_held(trace, hold_s):
    gate, samples = SpeedGate(0.05, 0.5, hold_s), []
    for sample in stamped(trace):
        samples.append(sample)
        gate = gate.after(*sample)
        assert gate.speed_m_per_s == speed_at(samples)
        assert gate.open == motion_was_held(samples, hold_s)


def glided(gate, ticks, speed_m_per_s=1.0):
    for n in ticks:
        gate = gate.after(n * TICK_S, speed_m_per_s * n * TICK_S)
    return gate


def test_speed_window_includes_sample_one_window_ago():
    gate = SpeedGate(1.0, 0.25, window_s=64 * TICK_S, max_gap_s=1.0)
    assert glided(gate, (0, 64)).speed_m_per_s == 1.0
    assert glided(gate, (0, 65)).speed_m_per_s is None


def test_speed_is_known_when_half_window_is_spanned():
    gate = SpeedGate(1.0, 0.25, window_s=64 * TICK_S, max_gap_s=1.0)
    assert glided(gate, (0, 31)).speed_m_per_s is None
    assert glided(gate, (0, 32)).speed_m_per_s == 1.0


def test_speed_gate_opens_exactly_after_its_hold():
    gate = SpeedGate(1.0, 0.25, hold_s=16 * TICK_S, window_s=64 * TICK_S)
    assert [glided(gate, range(n)).open for n in (48, 49)] == [False, True]


def test_speed_gate_bridges_longest_gap_not_doubled_stamps():
    gate = SpeedGate(1.0, 0.25, window_s=16 * TICK_S, max_gap_s=8 * TICK_S)
    assert glided(gate, (0, 8)).moving
    assert not glided(gate, (0, 9)).moving
    assert glided(gate, (0, 8, 8)).samples == ((8 * TICK_S, 8 * TICK_S),)


@pytest.mark.parametrize(("speed", "held"), [(0.75, True), (1.25, True), (0.7499, False), (1.2501, False)])
def test_speed_band_includes_its_edges(speed, held):
    gate = SpeedGate(1.0, 0.25, window_s=64 * TICK_S)
    assert glided(gate, range(65), speed).moving is held
    times_s = TICK_S * np.arange(65)
    assert motion(times_s, speed * times_s, 1.0, 0.25).in_band == held


def test_motion_window_includes_samples_at_its_ends():
    """The windows span (0, 1), (0, 2), (1, 2) s: 1, 1.5 and 2 m/s."""
    assert motion([0.0, 1.0, 2.0], [0.0, 1.0, 3.0], 1.5, 0.01, window_s=2.0).in_band == pytest.approx(1 / 3)
    assert motion([0.0, 1.0, 2.0], [0.0, 1.0, 3.0], 1.0, 0.01, window_s=2.0).in_band == pytest.approx(1 / 3)


def test_sparse_samples_have_the_speed_between_them():
    assert motion([0.0, 1.0, 2.0], [0.0, 0.05, 0.1], 0.05, tolerance=0.1, window_s=0.05).in_band == 1.0
    assert motion([0.0, 1.0, 2.0], [0.0, 0.05, 0.5], 0.05, tolerance=0.1, window_s=0.05).in_band == pytest.approx(2 / 3)
    assert motion([0.0, 1.0, 2.0], [0.0, 0.1, 0.15], 0.05, tolerance=0.1, window_s=0.05).in_band == pytest.approx(1 / 3)


@pytest.mark.parametrize("length_m", [0.02, 0.1])
def test_triangle_motion_is_in_band_except_at_turns(length_m):
    times_s = np.arange(2000) / 1000
    moved = motion(times_s, triangle(0.05 * times_s, length_m), 0.05, tolerance=0.2)
    n_turns = math.floor(0.05 * 2 / length_m - 1e-9)
    assert moved.mean_m_per_s == pytest.approx(0.05, rel=0.01)
    assert moved.in_band >= 1 - n_turns * 0.05 / 2.0 - 1e-9


@given(speed=st.floats(0.005, 0.5), tolerance=st.floats(0.05, 0.9))
def test_constant_speed_is_in_band_exactly_near_target(speed, tolerance):
    if abs(abs(speed / 0.05 - 1) - tolerance) < 1e-6:
        return
    times_s = np.arange(300) / 1000
    moved = motion(times_s, speed * times_s, 0.05, tolerance)
    assert moved.in_band == float(abs(speed / 0.05 - 1) <= tolerance)


@pytest.mark.parametrize(
    ("times_s", "places_m", "words"),
    [
        ([0.0], [0.0], "at least two"),
        ([0.0, 0.0], [0.0, 1.0], r"times_s\[1\]: found 0.0 after 0.0, expected a later stamp"),
        (
            [0.0, 1.0],
            [0.0, math.nan],
            r"positions_m\[\d\]: found nan, expected a finite number; remove lost samples",
        ),
        ([0.0, 1.0], [0.0], "equal numbers of both"),
    ],
)
def test_motion_refuses_invalid_paths(times_s, places_m, words):
    with pytest.raises(InvalidParameter, match=words):
        motion(times_s, places_m, 0.05, 0.2)


FORCE, SPEED = ForceGate(1.0, 0.1, 0.5), SpeedGate(0.05, 0.2)


@pytest.mark.parametrize(
    ("gate", "name", "value", "expected"),
    [
        (FORCE, "target_n", 0.0, "above 0"),
        (FORCE, "tolerance", -0.1, "above 0"),
        (FORCE, "hold_s", math.nan, "at least 0"),
        (FORCE, "max_gap_s", math.inf, "above 0"),
        (SPEED, "target_m_per_s", 0.0, "above 0"),
        (SPEED, "tolerance", math.nan, "above 0"),
        (SPEED, "hold_s", -1.0, "at least 0"),
        (SPEED, "window_s", math.inf, "above 0"),
    ],
)
def test_gate_refuses_impossible_settings(gate, name, value, expected):
    with pytest.raises(InvalidParameter, match=rf"Gate.{name}: found {value}, expected a finite number.*{expected}"):
        replace(gate, **{name: value})


def test_simulated_finger_follows_the_requested_path():
    finger = SimulatedFinger(speed_cv=0.0, speed_waver_cv=0.0)
    slide = Slide("tone", 20.0, 1.0, 1.0, 0.2, 0.5, 5.0, 0.05, length_m=0.02, speed_tolerance=0.2)
    grip = finger.hold(slide, np.random.default_rng(1))
    assert grip.positions_m.min() >= 0
    assert grip.positions_m.max() == pytest.approx(0.02, abs=1e-3)
    assert grip.speed_m_per_s == pytest.approx(0.05)
    assert motion(grip.times_s, grip.positions_m, 0.05, 0.2).mean_m_per_s == pytest.approx(0.05, rel=0.05)


def test_simulated_finger_rests_in_a_press():
    grip = SimulatedFinger().hold(Press("tone", 20.0, 1.0, 1.0, 0.2, 0.5, 5.0), np.random.default_rng(1))
    assert grip.speed_m_per_s == 0.0
    assert not grip.positions_m.any()
