"""The force gate against a brute-force rule on the whole trace, and the compliance against its definition."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hard_cases import exact_case
from hypothesis import given, strategies as st

from tactometry.errors import InvalidParameter
from tactometry.gates import ForceGate, compliance

GATE = ForceGate(target_n=1.0, tolerance=0.25, hold_s=0.0625, max_gap_s=0.02)
TICK_S = 1 / 1024

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


def stamped(increments_and_forces):
    times = np.cumsum([step for step, _ in increments_and_forces]) * TICK_S
    return [(float(t), f) for t, (_, f) in zip(times, increments_and_forces, strict=True)]


def held(samples, last, gate):
    """Whether some start k <= last reaches to `last` without a break and is at least hold_s away."""
    for k in range(last, -1, -1):
        run = samples[k : last + 1]
        times = [t for t, _ in run]
        in_band = all(abs(f - gate.target_n) <= gate.tolerance * gate.target_n for _, f in run)
        joined = all(0 <= b - a <= gate.max_gap_s for a, b in itertools.pairwise(times))
        if in_band and joined and times[-1] - times[0] >= gate.hold_s:
            return True
    return False


@given(mostly_held)
def test_the_gate_is_open_exactly_when_the_force_was_held(increments):
    samples = stamped(increments)
    assert fed(GATE, samples) == [held(samples, k, GATE) for k in range(len(samples))]
    exact_case("any course of a force", against="the rule of the gate, sample by sample")


def test_the_brute_force_rule_sees_open_gates_too():
    samples = stamped([(10, 1.0)] * 30)
    assert [held(samples, k, GATE) for k in (5, 6, 7)] == [False, False, True]


def test_a_steady_hold_opens_at_hold_s_and_not_a_sample_before():
    samples = [(k * TICK_S, 1.0) for k in range(65)]
    assert fed(GATE, samples) == [False] * 64 + [True]


@pytest.mark.parametrize(
    "breaker",
    [
        (30 * TICK_S, 0.5),
        (30 * TICK_S, math.nan),
        (30 * TICK_S, math.inf),
        (math.nan, 1.0),
    ],
    ids=["out of band", "lost", "infinite", "no stamp"],
)
def test_a_break_starts_the_hold_again(breaker):
    before = [(k * TICK_S, 1.0) for k in range(30)]
    after = [(k * TICK_S, 1.0) for k in range(31, 140)]
    states = fed(GATE, [*before, breaker, *after])
    assert states.index(True) == 30 + 1 + 64


def test_a_stamp_that_goes_back_starts_the_hold_again():
    samples = [(k * TICK_S, 1.0) for k in [*range(30), *range(20, 90)]]
    assert fed(GATE, samples).index(True) == 30 + 64


def test_a_gap_of_more_than_20_ms_starts_the_hold_again():
    joined = [(k * 20 * TICK_S, 1.0) for k in range(5)]
    torn = [(t + (t > 0.05) * TICK_S, f) for t, f in joined]
    assert fed(GATE, joined) == [False] * 4 + [True]
    assert fed(GATE, torn) == [False] * 5
    assert fed(replace(GATE, max_gap_s=20 * TICK_S), joined) == [False] * 4 + [True]


def test_an_open_gate_closes_when_the_force_leaves():
    gate = GATE
    for k in range(70):
        gate = gate.after(k * TICK_S, 1.0)
    assert gate.open
    assert not gate.after(70 * TICK_S, 1.3).open


def test_a_gate_is_a_value():
    gate = GATE.after(0.0, 1.0)
    gate.after(0.01, 1.0)
    assert gate == GATE.after(0.0, 1.0)


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("target_n", 0.0, "above 0"),
        ("tolerance", -0.1, "above 0"),
        ("hold_s", math.nan, "at least 0"),
        ("max_gap_s", math.inf, "above 0"),
    ],
)
def test_an_impossible_gate_is_refused(name, value, expected):
    values = {"target_n": 1.0, "tolerance": 0.1, "hold_s": 0.5} | {name: value}
    with pytest.raises(InvalidParameter, match=rf"ForceGate.{name}: found {value}, expected .*{expected}"):
        ForceGate(**values)


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


def test_a_sample_one_window_ago_has_left_the_running_mean():
    assert compliance([0.0, 0.25], [3.0, 1.0], 1.0, 0.1).in_band == 0.5
    assert compliance([0.0, 0.25 - TICK_S], [3.0, 1.0], 1.0, 0.1).in_band == 0.0


def test_a_window_that_late_stamps_cannot_resolve_holds_its_own_sample():
    assert compliance([1e9, 1e9 + 1], [1.0, 3.0], 1.0, 0.1, window_s=1e-9).in_band == 0.5


def test_a_running_mean_forgives_a_short_tremor():
    times = np.arange(0, 1, 0.001)
    tremor = np.where(np.arange(1000) % 2 == 0, 0.6, 1.4)
    assert compliance(times, tremor, 1.0, 0.1)[2] > 0.99
    assert compliance(times, tremor, 1.0, 0.1, window_s=0.0005)[2] == 0.0


@pytest.mark.parametrize(
    ("times", "values", "message"),
    [
        ([], [], "at least one"),
        ([0.0, 1.0], [1.0], "as many of both"),
        ([0.0, 1.0], [1.0, math.nan], r"forces_n\[1\]: found nan"),
        ([math.inf], [1.0], r"times_s\[0\]: found inf"),
        ([0.0, 1.0, 0.5], [1.0, 1.0, 1.0], r"times_s\[2\]: found 0.5 after 1.0"),
    ],
)
def test_an_impossible_trace_is_refused(times, values, message):
    with pytest.raises(InvalidParameter, match=message):
        compliance(times, values, 1.0, 0.1)
