"""Duty, session time and charge over several sittings and sessions."""

import math
import os
import time
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from benches import file_bench
from hypothesis import given, strategies as st
from study_texts import tutorial_in
from tutorial_session import EXPERIMENT, TOML
from window_sitting import any_keys, sit, tactometry

from tactometry.devices.outputs.file import FileOutput, FileSettings
from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.outputs.output import NullOutput
from tactometry.errors import LimitExceeded
from tactometry.experiments.data_sets.validation import validate
from tactometry.provenance import sha256
from tactometry.records.data_set import Session
from tactometry.records.journal import Head
from tactometry.records.open_session import OpenSession
from tactometry.safety.limits import Exposure, Limits
from tactometry.safety.load import Load
from tactometry.session.event import Event
from tactometry.signal import Signal

DUTY = 0.00026
"""Three stimuli of 0.3 s in any hour, so that a busy machine may take its time between them."""
SHORT = {
    'duration_s = "500 ms"': 'duration_s = "300 ms"',
    'hold_s = "300 ms"': 'hold_s = "20 ms"',
    "catch_rate = 0.2": "catch_rate = 0.0",
}


def test_duty_counts_across_sittings_data_sets_and_participants(display, tmp_path):
    """The fourth stimulus within an hour ends each sitting."""
    played = tmp_path / "played"
    bench = file_bench(tmp_path, DUTY, window_s=3600)
    words = ("run", tutorial_in(tmp_path, SHORT), "--bench", bench)
    for seed, (code, folder, *resume) in enumerate((("P01", "d"), ("P01", "d", "--resume"), ("P02", "e"))):
        out = tmp_path / folder
        process = tactometry(*words, "--participant", code, "--out", out, *resume, env=os.environ)
        status, _, errors = sit(process, display, any_keys(seed))
        assert status == 3, errors
        assert "limits.duty: found signals during 0.000333333 of the time, the limit is 0.00026 of" in errors
        assert len(list(played.glob("*.npz"))) == 3
        assert validate(out).defects == ()


HEAD = Head("tutorial", "0", "P01", 1, 1, 1, "bench", {})


def opened(root, session=1, code="P01", *, resume=False):
    keeper = OpenSession(root, EXPERIMENT.design(TOML), Session(code, session, "tutorial"), "bench", resume=resume)
    if not resume:
        keeper.journal.begin(replace(HEAD, participant=code, session=session, study_sha256=sha256(TOML)))
    return keeper


def stimulus(ago_s, duration_s=1.0, at_s=0.0, charge_c=0.0):
    utc = (datetime.now(UTC) - timedelta(seconds=ago_s)).isoformat(timespec="milliseconds")
    return Event("stimulus", at_s, utc, {"charge_c": charge_c}, duration_s)


def test_resumed_session_counts_time_of_earlier_sittings(tmp_path):
    begin_s = time.perf_counter()
    keeper = opened(tmp_path)
    keeper.note(stimulus(10.0, at_s=190.0, charge_c=1e-9))
    keeper.close()
    keeper = opened(tmp_path, resume=True)
    counted_s = time.perf_counter() - keeper.exposure().opened_s
    assert 190.0 - 1e-3 <= counted_s <= 190.0 + 1e-3 + time.perf_counter() - begin_s
    keeper.close()


# --- the guard


FINGER = Load("electrode", capacitance_f=1e-9, leak_resistance_ohm=1e6)


class Clock:
    now_s = 1000.0

    def __call__(self):
        return self.now_s


def guard(tmp_path, clock, **limits):
    stated = {"duration_s": 10.0, "current_peak_a": 1.0, "duty": 1.0, "session_s": 1e6} | limits
    return Guarded(FileOutput(FileSettings(str(tmp_path))), Limits(100.0, **stated), FINGER, clock)


def volts(duration_s, volt=10.0):
    return Signal(np.full((1, round(1e3 * duration_s)), volt), 1e3, "V")


def test_guard_counts_emissions_from_before_it_opened(tmp_path):
    clock = Clock()
    output = guard(tmp_path, clock, duty=0.5, duty_window_s=10.0)
    output.count_on(Exposure(1000.0, ((995.0, 1000.0),)))
    output.open()
    with pytest.raises(LimitExceeded, match=r"limits\.duty: .*; wait 5.0 s; nothing was played"):
        output.play(volts(5.0))
    clock.now_s = 1005.0
    output.play(volts(5.0))


def test_session_limit_counts_all_sittings(tmp_path):
    output = guard(tmp_path, Clock(), session_s=60.0)
    output.count_on(Exposure(1000.0 - 59.5))
    output.open()
    output.play(volts(0.5))
    with pytest.raises(LimitExceeded, match=r"limits\.session_s: found a session of 60\.6 s"):
        output.play(volts(1.1))


def test_guard_sums_charges_of_signals_whatever_their_sign(tmp_path):
    """10 V on 1 Mohm for 1 s leak 10 uC."""
    clock = Clock()
    output = guard(tmp_path, clock, charge_session_c=50e-6)
    output.count_on(Exposure(1000.0, (), charge_c=25e-6))
    output.open()
    for volt in (10.0, -10.0):
        output.play(volts(1.0, volt))
        clock.now_s += 2.0
    with pytest.raises(LimitExceeded, match=r"limits\.charge_session_c: found net charges of 5\.5e-05 C"):
        output.play(volts(1.0))


def balanced(volt=100.0):
    """Return 0.5 s of a voltage and 0.5 s of its negative."""
    return Signal(np.repeat([[volt, -volt]], 500, axis=1), 1e3, "V")


def test_guard_refuses_balanced_signal_with_excessive_half(tmp_path):
    output = guard(tmp_path, Clock(), charge_session_c=10e-6)
    output.open()
    with pytest.raises(LimitExceeded, match=r"limits\.charge_session_c: found net charges of 4\.9975e-05 C"):
        output.play(balanced())


def test_guard_counts_the_charge_of_stopped_signals(tmp_path):
    """Two signals are stopped after 50 uC. A third may reach 150 uC."""
    clock = Clock()
    output = guard(tmp_path, clock, charge_session_c=110e-6)
    output.open()
    for _ in range(2):
        output.play(balanced())
        clock.now_s += 0.5
        output.stop()
        clock.now_s += 9.5
    with pytest.raises(LimitExceeded, match="charge_session_c"):
        output.play(balanced())


def test_guard_counts_net_charge_of_complete_signals(tmp_path):
    clock, ends_c = Clock(), []
    output = guard(tmp_path, clock, charge_session_c=51e-6)
    output.subscribe(lambda *emission: None, ends_c.append)
    output.open()
    for _ in range(40):
        output.play(balanced())
        clock.now_s += 1.1
    output.close()
    assert ends_c == pytest.approx([0.0] * 40, abs=1e-9)


def test_resumed_session_counts_charge_of_earlier_stimuli(tmp_path):
    keeper = opened(tmp_path)
    for charge_c, passed_c in ((5e-6, 0.0), (5e-6, 3e-6), (4e-6, None)):
        keeper.note(stimulus(10.0, at_s=1.0, charge_c=charge_c))
        if passed_c is not None:
            keeper.note(Event("stimulus_end", 2.0, facts={"charge_c": passed_c}))
    keeper.close()
    keeper = opened(tmp_path, resume=True)
    assert keeper.exposure().charge_c == pytest.approx(7e-6)
    keeper.close()


@st.composite
def courses(draw):
    """Draw a signal, a stop, the delay and the duration of its fade."""
    n_channels, n_samples = draw(st.integers(1, 3)), draw(st.integers(1, 40))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    samples = rng.normal(0.0, draw(st.sampled_from((1e-3, 1.0, 200.0))), (n_channels, n_samples))
    signal = Signal(samples, draw(st.sampled_from((10.0, 1e3, 192e3))), "V")
    after_s, late, fade = (draw(st.floats(0.0, 1.2)) * signal.duration_s for _ in range(3))
    return signal, after_s, late, fade


def emitted(signal, times_s, stop_s=math.inf, fade_s=1.0):
    """Return the voltages at `times_s`, with a linear fade."""
    at_s = np.arange(-1, signal.samples.shape[1] + 1) / signal.rate_hz
    whole = np.array([np.interp(times_s, at_s, np.pad(channel, 1)) for channel in signal.samples])
    return whole * np.clip(1 - (times_s - stop_s) / max(fade_s, 1e-12), 0.0, 1.0)


def integrals_c(signal, *stop):
    """Integrate the charge through 1 Mohm by the trapezoidal rule."""
    times_s = np.arange(-400, 400 * (signal.samples.shape[1] + 1)) / (400 * signal.rate_hz)
    volts_v = emitted(signal, times_s, *stop)
    steps = (volts_v[:, 1:] + volts_v[:, :-1]) / 2 * np.diff(times_s)
    return np.cumsum(steps, axis=1) / 1e6


@given(courses())
def test_largest_charge_bounds_every_partial_signal(course):
    signal, *_ = course
    exact_c = np.abs(integrals_c(signal)).max()
    crossing_c = np.abs(signal.samples).max() / signal.rate_hz / 1e6
    charge = FINGER.passed_c(signal)
    assert exact_c * (1 - 1e-4) <= charge.largest_c <= exact_c + crossing_c
    assert charge.net_c == pytest.approx(np.abs(integrals_c(signal)[:, -1]).max(), rel=1e-4, abs=1e-4 * exact_c)


@given(courses())
def test_stopped_charge_bounds_every_fade(course):
    signal, after_s, late_s, fade_s = course
    passed_c = np.abs(integrals_c(signal, after_s + late_s, fade_s)[:, -1]).max()
    step_c = np.abs(signal.samples).max() / (400 * signal.rate_hz) / 1e6
    assert passed_c <= FINGER.passed_c(signal).stopped_c(after_s, late_s + fade_s) + step_c


def test_guard_reports_emissions_except_of_null_output(tmp_path):
    emissions = []
    for output in (guard(tmp_path, Clock()), Guarded(NullOutput(), Limits(100.0))):
        output.subscribe(lambda *emission: emissions.append(emission))
        output.open()
        output.play(volts(0.5))
    [(_, duration_s, charge_c)] = emissions
    assert (duration_s, charge_c) == (0.5, pytest.approx(5e-6, rel=0.01))


def test_net_charge_of_alternating_voltage_is_zero():
    samples = np.sin(2 * np.pi * 10 * np.arange(1000) / 1e3)[None]
    assert FINGER.passed_c(Signal(samples, 1e3, "V")).net_c == pytest.approx(0.0, abs=1e-15)
    rising = Signal(np.array([[10.0, 10.0], [-20.0, -20.0]]), 1e3, "V")
    assert FINGER.passed_c(rising).net_c == pytest.approx(20.0 * 2e-3 / 1e6)
