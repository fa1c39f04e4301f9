"""Frame period: measurement, comparison with the screen mode, and pacing."""

import time
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from tactometry.experiments.bench.preflight_checks import _period
from tactometry.rigs.frame_timing import PERIOD_WITHOUT_BLANK_S, Pacer, Rhythm, nominal_rate_hz, rhythm_of, timing_of
from tactometry.rigs.pages.page import Page

rates_hz = st.sampled_from([30.0, 50.0, 59.94, 60.0, 75.0, 120.0, 144.0, 240.0])


@given(rates_hz, st.booleans(), st.floats(0.0, 0.03), st.integers(0, 3))
def test_frame_period_is_trusted_despite_dropped_frames(rate_hz, told, jitter, n_dropped):
    rng = np.random.default_rng(0)
    intervals_s = (1 + jitter * rng.uniform(-1, 1, 20)) / rate_hz
    intervals_s[:n_dropped] *= 2
    rhythm = rhythm_of(intervals_s.tolist(), rate_hz if told else None)
    assert (rhythm.trusted, rhythm.in_software, rhythm.caution) == (True, False, None)
    assert rhythm.period_s == pytest.approx(1 / rate_hz, rel=0.03)


@given(st.lists(st.floats(4.4e-3, 95e-3), min_size=20, max_size=20), rates_hz)
def test_loaded_frame_intervals_are_not_trusted(intervals_s, rate_hz):
    """Medians measured under load were 4.4 to 95 ms."""
    rhythm = rhythm_of(intervals_s, rate_hz)
    assert abs(rhythm.period_s * rate_hz - 1) <= 0.1 + 1e-9
    assert rhythm.trusted or rhythm.period_s == 1 / rate_hz


def test_untrusted_period_warning_states_expected_period():
    loaded = rhythm_of([0.02, 0.06, 0.09, 0.03] * 5, 60.0)
    assert loaded.caution.startswith("screen: found frames of 45.0 ms, expected 16.7 ms by the mode of the screen")
    assert "expected 16.7 ms by assumption" in rhythm_of([0.02, 0.06, 0.09, 0.03] * 5, None).caution
    assert timing_of([0.016, 0.050], loaded.period_s)["n_dropped_frames"] == 2


@pytest.mark.parametrize(("nominal_hz", "period_s"), [(None, PERIOD_WITHOUT_BLANK_S), (120.0, 1 / 120)])
@pytest.mark.parametrize("fast_s", [0.0007, 0.003])
def test_unsynchronised_frames_are_paced_at_mode_period(nominal_hz, period_s, fast_s):
    rhythm = rhythm_of([fast_s, *[2 * fast_s] * 3] * 5, nominal_hz)
    assert (rhythm.trusted, rhythm.in_software, rhythm.period_s) == (False, True, period_s)
    assert rhythm.caution is None


def test_period_differing_from_mode_is_not_trusted():
    assert not rhythm_of([1 / 60] * 20, 144.0).trusted
    assert rhythm_of([1 / 60] * 20, 144.0).period_s == 1 / 144


@pytest.mark.parametrize(
    ("mode", "rate_hz"),
    [
        (SimpleNamespace(info=SimpleNamespace(dotclock=148_500, htotal=2200, vtotal=1125), rate=148_500), 60.0),
        (SimpleNamespace(info=SimpleNamespace(dotclock=0, htotal=0, vtotal=0), rate=0), None),
        (SimpleNamespace(rate=144), 144.0),
        (SimpleNamespace(rate=0), None),
        (SimpleNamespace(rate=None), None),
        (None, None),
    ],
)
def test_nominal_rate_is_read_from_screen_mode(mode, rate_hz):
    assert nominal_rate_hz(mode) == (None if rate_hz is None else pytest.approx(rate_hz))


def test_pacer_waits_after_frames_are_too_fast():
    pacer = Pacer(Rhythm(0.05, 0.01, trusted=False, in_software=False))
    for _ in range(9):
        pacer.after(0.001)
    pacer.after(0.01)
    assert not pacer.in_software
    for _ in range(10):
        pacer.after(0.001)
    assert pacer.in_software
    begin_s = time.perf_counter()
    for _ in range(11):
        pacer.wait()
    assert time.perf_counter() - begin_s >= 0.1


# --- window


def test_window_uses_nominal_period_after_slow_start(screen, monkeypatch):
    """Three measurements under load, with a simulated mode of 60 Hz."""
    late_s = iter(np.random.default_rng(0).uniform(0.014, 0.06, 63).tolist())
    monkeypatch.setattr(type(screen), "_flip", lambda self: time.sleep(next(late_s)) or time.perf_counter())
    monkeypatch.setattr("tactometry.rigs.window.nominal_rate_hz", lambda mode: 60.0)
    rhythm = screen._rhythm()
    assert (rhythm.trusted, rhythm.in_software, rhythm.period_s) == (False, False, 1 / 60)
    assert next(late_s, None) is None
    kept = screen._pacer
    try:
        screen._pacer = Pacer(rhythm)
        facts = screen.facts()
        assert screen.caution.startswith("screen: found frames of ")
    finally:
        screen._pacer = kept
    assert facts["frame_period_measured_s"] > 0.02
    assert (facts["frame_period_nominal_s"], facts["frame_period_s"]) == (0.016667, 0.016667)
    assert facts["frame_period_trusted"] is False
    finding = _period(facts)
    assert (finding.expected, finding.fine) == ("16.67 ms", False)


def test_virtual_screen_is_paced_in_software(watched):
    facts = watched.facts()
    assert (facts["frame_period_nominal_s"], facts["frame_period_trusted"]) == (None, False)
    assert (facts["frame_period_s"], facts["frames_paced_in_software"]) == (0.016667, True)
    assert (watched.caution, _period(facts).fine) == (None, None)
    watched.present(Page())
    begin_s = time.perf_counter()
    for _ in range(12):
        watched.refresh(Page())
    assert time.perf_counter() - begin_s >= 11 / 60
