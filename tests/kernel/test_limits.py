"""Every limit, against waveforms, gains and sequences that exceed it."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest
from hard_cases import exact_case
from hypothesis import assume, given, strategies as st
from hypothesis.extra.numpy import arrays

from tactometry.arguments.require import UNLIMITED
from tactometry.errors import InvalidParameter, LimitExceeded
from tactometry.safety.limits import FORCE_PEAK_N, LONGEST_SIGNAL_S, LONGEST_WINDOW_S, STOP_WITHIN_S, Exposure, Limits
from tactometry.safety.load import Load
from tactometry.signal import Signal

RATE_HZ = 1000.0
FINGER = Load("electrode", capacitance_f=2e-9, leak_resistance_ohm=5e6)
PATCHES = Load("piezo", capacitance_f=1e-8, displacement_m_per_v=(1e-7, 3e-7))
LIMITS = Limits(100.0, 60.0, current_peak_a=1.0, charge_peak_c=1.0, displacement_peak_m=1.0, duty=1.0, session_s=1e6)

volts = arrays(np.float64, st.tuples(st.just(2), st.integers(1, 40)), elements=st.floats(-100, 100))
limits_of = st.floats(1e-12, 1e3)


def refused(check, name):
    try:
        check()
    except LimitExceeded as error:
        message = str(error)
    else:
        return False
    assert message.startswith(f"limits.{name}: found ")
    assert message.endswith("nothing was played")
    return True


def in_volts(samples):
    return Signal(samples, RATE_HZ, "V")


def fine(samples, n=64):
    """Interpolate with n points per sample: (n_channels, ...)."""
    padded = np.pad(samples, ((0, 0), (1, 1)))
    at = np.linspace(0, padded.shape[1] - 1, (padded.shape[1] - 1) * n + 1)
    return np.array([np.interp(at, np.arange(padded.shape[1]), row) for row in padded]), 1 / (RATE_HZ * n)


# --- each limit against an independent computation of its quantity


@given(volts, limits_of)
def test_voltage_above_its_limit_is_refused(samples, limit):
    over = bool(np.any(np.abs(samples) > limit * (1 + 1e-11)))
    if over or not np.any(np.abs(samples) > limit):
        assert refused(lambda: Limits(limit).check(in_volts(samples)), "voltage_peak_v") == over
    exact_case("any signal against a limit of voltage", against="refused if and only if above")


@given(st.integers(1, 3000), st.floats(1e-3, 3.0))
def test_signal_longer_than_its_limit_is_refused(n_samples, limit):
    assert refused(lambda: Limits(1.0, limit).check(in_volts(np.zeros((1, n_samples)))), "duration_s") == (
        n_samples / RATE_HZ > limit * (1 + 1e-12)
    )


@given(volts, limits_of)
def test_current_above_its_limit_is_refused(samples, limit):
    course, step_s = fine(samples)
    slopes = np.diff(course, axis=1) / step_s
    current_a = np.abs(FINGER.capacitance_f * slopes + course[:, 1:] / FINGER.leak_resistance_ohm).max()
    if current_a > limit * (1 + 1e-9):
        limits = replace(LIMITS, displacement_peak_m=None, current_peak_a=limit)
        assert refused(lambda: limits.check_load(in_volts(samples), FINGER), "current_peak_a")


@given(volts, limits_of)
def test_charge_above_its_limit_is_refused(samples, limit):
    course, step_s = fine(samples)
    leaked_c = np.cumsum((course[:, 1:] + course[:, :-1]) / 2, axis=1) * step_s / FINGER.leak_resistance_ohm
    charge_c = np.abs(FINGER.capacitance_f * course[:, 1:] + leaked_c).max()
    if charge_c > limit * (1 + 1e-9):
        limits = replace(LIMITS, displacement_peak_m=None, charge_peak_c=limit)
        assert refused(lambda: limits.check_load(in_volts(samples), FINGER), "charge_peak_c")


@given(volts, limits_of, arrays(np.float64, (2, 12), elements=st.floats(-1e-6, 1e-6)))
def test_displacement_of_any_response_above_limit_is_refused(samples, limit, responses):
    gains = tuple(float(g) for g in np.abs(responses).sum(axis=1) + 1e-15)
    moved_m = np.abs(sum(np.convolve(v, h) for v, h in zip(samples, responses, strict=True))).max()
    if moved_m > limit * (1 + 1e-9):
        limits, load = replace(LIMITS, displacement_peak_m=limit), replace(PATCHES, displacement_m_per_v=gains)
        assert refused(lambda: limits.check_load(in_volts(samples), load), "displacement_peak_m")


plays = st.lists(st.tuples(st.floats(0, 5), st.floats(0.01, 3), st.floats(0, 1)), min_size=1, max_size=30)


@given(plays, st.floats(0.05, 1.0))
def test_no_window_exceeds_the_duty(plays, duty):
    """Every window that ends with a signal is summed."""
    limits, exposure, now_s, emitted = Limits(1.0, duty=duty, duty_window_s=6.0), Exposure(0.0), 0.0, []
    for pause_s, duration_s, kept in plays:
        now_s += pause_s
        if refused(lambda e=exposure, t=now_s, d=duration_s: limits.check_exposure(e, t, d), "duty"):
            continue
        exposure = exposure.after(now_s, duration_s, limits.duty_window_s)
        emitted.append((now_s, now_s + kept * duration_s))
        now_s += kept * duration_s
        exposure = exposure.stopped(now_s)
    for _, end_s in emitted:
        inside_s = sum(max(0.0, min(b, end_s) - max(a, end_s - 6.0)) for a, b in emitted)
        assert inside_s <= duty * 6.0 * (1 + 1e-9)


@given(st.floats(0, 1e4), st.floats(0, 1e4), st.floats(1e-3, 60), st.floats(1, 1e4))
def test_signal_ending_after_the_session_is_refused(opened_s, waited_s, duration_s, session_s):
    limits, begin_s = Limits(1.0, session_s=session_s), opened_s + waited_s
    late = begin_s + duration_s - opened_s > session_s * (1 + 1e-12)
    assert refused(lambda: limits.check_exposure(Exposure(opened_s), begin_s, duration_s), "session_s") == late


def test_limits_reject_nan():
    limits = Limits(1.0, session_s=1.0)
    assert refused(lambda: limits.check_exposure(Exposure(0.0), math.nan, 0.1), "session_s")


@given(st.floats(1e-3, 100), st.floats(0.01, 1.0), st.floats(1e-3, 100))
def test_touch_above_the_force_limit_is_refused(target_n, tolerance, limit):
    limits = Limits(1.0, force_peak_n=limit)
    over = target_n * (1 + tolerance) > limit * (1 + 1e-12)
    assert refused(lambda: limits.check_force(target_n, tolerance), "force_peak_n") == over


@given(st.lists(st.floats(0.0, 1.0), max_size=20), st.floats(0.01, 5.0))
def test_session_charge_above_its_limit_is_refused(charges_c, limit_c):
    limits, exposure = Limits(1.0, charge_session_c=limit_c), Exposure(0.0)
    for charge_c in charges_c:
        over = exposure.charge_c + exposure.playing_c + charge_c > limit_c * (1 + 1e-12)
        assert refused(lambda e=exposure, c=charge_c: limits.check_exposure(e, 0.0, 0.0, c), "charge_session_c") == over
        exposure = exposure if over else exposure.after(0.0, 0.0, 1.0, charge_c)
    assert exposure.charge_c + exposure.playing_c <= limit_c * (1 + 1e-12)


gaps_and_durations = st.lists(st.tuples(st.floats(0.0, 3.0), st.floats(0.1, 3.0)), min_size=1, max_size=8)


@given(gaps_and_durations, st.floats(0.1, 4.0), st.floats(0.05, 1.0))
def test_refusal_states_the_shortest_sufficient_wait(plays, duration_s, duty):
    limits, exposure, now_s = Limits(1.0, duty=duty, duty_window_s=6.0), Exposure(0.0), 0.0
    for gap_s, lasts_s in plays:
        now_s += gap_s
        exposure = exposure.after(now_s, lasts_s, 6.0)
        now_s += lasts_s
    assume(refused(lambda: limits.check_exposure(exposure, now_s, duration_s), "duty"))
    remedy = exposure.cure(now_s, duration_s, 6.0, duty * 6.0)
    if remedy == "shorten the signal":
        assert duration_s > duty * 6.0 * (1 - 1e-9)
        return
    wait_s = float(remedy.split()[1])
    assert not refused(lambda: limits.check_exposure(exposure, now_s + wait_s + 1e-6, duration_s), "duty")
    assert refused(lambda: limits.check_exposure(exposure, now_s + max(0.0, wait_s - 0.11), duration_s), "duty")


# --- a limit is not tighter than stated


def test_signal_exactly_at_each_limit_is_played():
    signal = in_volts(np.array([[50.0, -50.0], [0.0, 0.0]]))
    limits = Limits(
        50.0,
        duration_s=2e-3,
        current_peak_a=PATCHES.current_peak_a(signal),
        charge_peak_c=PATCHES.charge_peak_c(signal),
        displacement_peak_m=50.0 * 1e-7,
        duty=0.5,
        duty_window_s=4e-3,
        session_s=3e-3,
    )
    limits.check(signal)
    limits.check_load(signal, PATCHES)
    limits.check_exposure(Exposure(0.0), 1e-3, 2e-3)


# --- the physics of the load


def test_sine_current_equals_that_of_its_circuit():
    t_s = np.arange(20_001) / 1e6
    sine = Signal(100 * np.sin(2 * np.pi * 1000 * t_s)[None], 1e6, "V")
    admittance_s = abs(1 / FINGER.leak_resistance_ohm + 2j * np.pi * 1000 * FINGER.capacitance_f)
    assert FINGER.current_peak_a(sine) == pytest.approx(100 * admittance_s, rel=1e-4)


def test_charge_without_a_leak_is_capacitance_times_voltage():
    load = replace(FINGER, leak_resistance_ohm=math.inf)
    assert load.charge_peak_c(in_volts(np.array([[0.0, 30.0, -40.0, 0.0]]))) == pytest.approx(2e-9 * 40, rel=1e-15)


def test_charge_peak_is_found_between_samples():
    leaky = Load("electrode", capacitance_f=1e-9, leak_resistance_ohm=1e5)
    samples = np.array([[0.0, 100.0, 100.0, -100.0]])
    course, step_s = fine(samples, 4096)
    charge_c = 1e-9 * course[0, 1:] + np.cumsum(course[0, 1:] + course[0, :-1]) * step_s / 2 / 1e5
    at_samples = np.abs(charge_c[4095::4096]).max()
    assert leaky.charge_peak_c(in_volts(samples)) == pytest.approx(np.abs(charge_c).max(), rel=1e-6)
    assert leaky.charge_peak_c(in_volts(samples)) > at_samples


# --- limits that are not stated


@pytest.mark.parametrize(
    ("load", "limits", "message"),
    [
        (FINGER, Limits(1.0), "no current_peak_a or charge_peak_c, no duration_s, no duty, no session_s, expected"),
        (FINGER, Limits(1.0, 1.0, current_peak_a=1.0, session_s=1.0), "no duty, expected"),
        (FINGER, Limits(1.0, 1.0, charge_peak_c=1.0, duty=1.0), "no session_s, expected"),
        (FINGER, Limits(1.0, 1.0, duty=1.0, session_s=1.0), "no current_peak_a or charge_peak_c, expected"),
        (FINGER, replace(LIMITS, duration_s=None), "found no duration_s, expected"),
        (PATCHES, replace(LIMITS, duration_s=None), "found no duration_s, expected"),
        (PATCHES, Limits(1.0, 1.0, current_peak_a=1.0, duty=1.0, session_s=1.0), "no displacement_peak_m, expected"),
        (PATCHES, replace(LIMITS, duty=None), "found no duty, expected"),
        (PATCHES, replace(LIMITS, session_s=None), "found no session_s, expected"),
        (FINGER, LIMITS, "no displacement_m_per_v of the load"),
    ],
)
def test_load_without_stated_limits_is_refused(load, limits, message):
    with pytest.raises(LimitExceeded, match=message + ".*nothing was played"):
        limits.check_load(in_volts(np.zeros((2, 4))), load)


def test_signal_without_load_has_a_default_limit():
    Limits(1.0).check(in_volts(np.zeros((1, round(LONGEST_SIGNAL_S * RATE_HZ)))))
    assert refused(
        lambda: Limits(1.0).check(in_volts(np.zeros((1, round(LONGEST_SIGNAL_S * RATE_HZ) + 1)))), "duration_s"
    )


def test_defaults_of_limits_are_those_of_the_documentation():
    assert (LONGEST_SIGNAL_S, LONGEST_WINDOW_S, STOP_WITHIN_S, FORCE_PEAK_N) == (60.0, 3600.0, 0.1, 10.0)
    assert (Limits(1.0).duty_window_s, Limits(1.0).force_peak_n) == (60.0, 10.0)
    assert Limits(1.0).facts() == {"limit_voltage_peak_v": 1.0, "limit_duty_window_s": 60.0, "limit_force_peak_n": 10.0}


@pytest.mark.parametrize("name", ["voltage_peak_v", "duty_window_s", "force_peak_n"])
def test_mandatory_limits_cannot_be_none(name):
    with pytest.raises((InvalidParameter, TypeError)):
        Limits(**{"voltage_peak_v": 1.0, name: None})


def test_signal_without_charge_keeps_any_limit_of_charge():
    Limits(1.0, charge_session_c=1e-12).check_exposure(Exposure(0.0).after(0.0, 1.0, 60.0), 2.0, 1.0)


def test_limits_refuse_samples_not_in_volts():
    with pytest.raises(LimitExceeded, match="found a signal in 'm', expected volt"):
        Limits(1.0).check(Signal(np.zeros((1, 2)), RATE_HZ, "m"))


NAMES = [each.name for each in fields(Limits) if "duty" not in each.name]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("value", [0.0, -1.0, math.inf, math.nan])
def test_limit_is_finite_and_above_zero(name, value):
    with pytest.raises(InvalidParameter, match=f"^Limits.{name}: found {value}, expected a finite number above 0"):
        Limits(**{"voltage_peak_v": 1.0, name: value})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"duty": 0.0}, "duty: found 0.0"),
        ({"duty": 1.5}, "duty: found 1.5, expected at most 1"),
        ({"duty_window_s": 0.0}, "duty_window_s: found 0.0"),
        ({"duty_window_s": 3601.0}, "duty_window_s: found 3601, expected at most 3600"),
    ],
)
def test_limits_refuse_impossible_duty(change, message):
    with pytest.raises(InvalidParameter, match=rf"^Limits\.{message}"):
        Limits(1.0, **{"duty_window_s": 3600.0, **change})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"capacitance_f": 0.0}, "Load.capacitance_f: found 0.0"),
        ({"leak_resistance_ohm": -1.0}, "Load.leak_resistance_ohm: found -1.0"),
        ({"displacement_m_per_v": (1e-7, math.nan)}, "Load.displacement_m_per_v: found"),
    ],
)
def test_load_refuses_unphysical_values(change, message):
    with pytest.raises(InvalidParameter, match=f"^{message}"):
        replace(FINGER, **change)


def test_displacement_per_volt_needs_every_channel():
    with pytest.raises(InvalidParameter, match="found 2 values for 3 channels"):
        PATCHES.displacement_peak_m(in_volts(np.zeros((3, 4))))


# --- two sets of limits


some_limits = st.builds(
    Limits,
    voltage_peak_v=st.floats(1, 200),
    duration_s=st.none() | st.floats(1, 100),
    current_peak_a=st.none() | st.floats(1e-6, 1),
    duty=st.none() | st.floats(0.01, 1.0),
    duty_window_s=st.floats(1, 100),
    session_s=st.none() | st.floats(1, 1e4),
    force_peak_n=st.floats(1, 20),
    charge_session_c=st.none() | st.floats(1e-6, 1),
)


@given(some_limits, some_limits, plays)
def test_signal_within_tighter_limits_is_within_both(one, other, plays):
    both, exposure, now_s = one.tighter(other), Exposure(0.0), 0.0
    for pause_s, duration_s, _ in plays:
        now_s += pause_s
        try:
            both.check_exposure(exposure, now_s, duration_s)
        except LimitExceeded:
            continue
        one.check_exposure(exposure, now_s, duration_s)
        other.check_exposure(exposure, now_s, duration_s)
        exposure = exposure.after(now_s, duration_s, 200.0)
        now_s += duration_s


def test_tighter_keeps_the_stated_duty_exactly():
    """Rounding once changed a duty of 0.031 between sittings."""
    assert Limits(1.0, duty=0.031).tighter(Limits(1.0)).duty == 0.031
    assert Limits(1.0, duty=0.031).tighter(Limits(1.0, duty=0.5)).duty == 0.031


@given(some_limits, some_limits)
def test_tighter_takes_the_minimum_of_stated_limits(one, other):
    both = one.tighter(other)
    for name in ("voltage_peak_v", "duration_s", "current_peak_a", "session_s", "force_peak_n", "charge_session_c"):
        stated = [getattr(each, name) for each in (one, other) if getattr(each, name) is not None]
        assert getattr(both, name) == min(stated, default=None)


def test_tighter_duty_satisfies_both_windows():
    """Limits of 1 s in 1 s and 6 s in 60 s allow 1 s in 60 s."""
    short, long = Limits(1.0, duty=1.0, duty_window_s=1.0), Limits(1.0, duty=0.1, duty_window_s=60.0)
    for both in (short.tighter(long), long.tighter(short)):
        assert (both.duty, both.duty_window_s) == (pytest.approx(1 / 60), 60.0)


@pytest.mark.parametrize(
    ("stated_s", "delay_s", "over"),
    [(None, 0.1, False), (None, 0.1001, True), (0.05, 0.0501, True), (0.3, 0.3, False), (UNLIMITED, 9.0, False)],
)
def test_limits_refuse_a_stop_that_is_late(stated_s, delay_s, over):
    assert refused(lambda: Limits(1.0, stop_within_s=stated_s).check_stop(delay_s), "stop_within_s") == over


def test_unlimited_limits_refuse_nothing():
    limits = Limits(UNLIMITED, UNLIMITED, force_peak_n=UNLIMITED, session_s=UNLIMITED, charge_session_c=UNLIMITED)
    limits.check(in_volts(np.full((1, round(2 * LONGEST_SIGNAL_S * RATE_HZ)), 1e9)))
    limits.check_force(1e9, 0.1)
    limits.check_exposure(Exposure(0.0), 1e9, 1.0, 1e9)
