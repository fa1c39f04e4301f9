"""Calibration fits recover the true values as valid bench file keys."""

import tomllib
from datetime import date

import numpy as np
import pytest
from hypothesis import given, strategies as st

from tactometry.devices.outputs.gain import Gain
from tactometry.errors import InvalidParameter
from tactometry.experiments.bench.bench_file import parse_bench
from tactometry.experiments.bench.bench_table import table_toml
from tactometry.experiments.bench.calibration import display_height_m, fit_force, fit_gain, force_values, tone
from tactometry.experiments.bench.figures import force_figure, responses_figure
from tactometry.stimuli.time_reversal.responses.responses import impulse_responses
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE

TODAY = date(2026, 11, 21)


@given(st.floats(-5, 5), st.floats(1e-4, 1.0), st.booleans(), st.floats(-1e-6, 1e-6))
def test_force_fit_recovers_polynomial(offset_n, slope, falling, bend):
    slope = -slope if falling else slope
    counts = np.linspace(-20.0, 20.0, 9)
    forces_n = offset_n + slope * counts + bend * counts**2
    forces_n -= forces_n.min()
    fit = fit_force(forces_n / 9.81, counts, degree=2, gravity_m_per_s2=9.81)
    again = np.polynomial.polynomial.polyval(counts, fit.polynomial)
    assert np.allclose(again, forces_n, atol=1e-9)
    assert fit.residual_rms_n < 1e-9


def test_residuals_are_what_the_fit_leaves():
    rng = np.random.default_rng(2)
    counts = np.arange(20.0) * 100
    fit = fit_force((0.01 * counts + 0.02 * rng.standard_normal(20) + 1) / 9.80665, counts)
    assert fit.residual_rms_n == pytest.approx(0.02, rel=0.6)
    assert abs(fit.residuals_n.sum()) < 1e-9


@given(st.floats(0.1, 500), st.lists(st.floats(0.01, 1.0), min_size=2, max_size=9))
def test_gain_fit_recovers_gain(volts_per_unit, units):
    fit = fit_gain(units, [volts_per_unit * unit for unit in units])
    assert fit.volts_per_unit == pytest.approx(volts_per_unit, rel=1e-12)
    assert fit.residual_rms_v < 1e-9 * volts_per_unit


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: fit_force([0, 1], [0, 1]), "found 2 masses and 2 counts, expected .* at least 3 for degree 1"),
        (lambda: fit_force([0, 1, 2], [0, 1, np.nan]), "found a mass or a count that is not finite"),
        (lambda: fit_force([0, 1, -2], [0, 1, 2]), "or a mass below 0"),
        (lambda: fit_force([0, 1, 2], [0, 5, 3]), "neither rise nor fall with the weights"),
        (lambda: fit_gain([0.1], [1.0]), "found 1 and 1 values, expected equally many of both, at least two"),
        (lambda: fit_gain([0.1, 0.2], [1.0, -1.0]), "not a finite number above 0"),
        (lambda: display_height_m(0.0), "found a bar of 0.0 m"),
    ],
)
def test_impossible_fit_is_refused(call, message):
    with pytest.raises(InvalidParameter, match=message):
        call()


def test_printed_calibration_is_a_bench_file():
    fit = fit_force([0.0, 0.1, 0.2, 0.3], [5.0, 105.0, 205.0, 305.0])
    text = (
        table_toml("screen", {"height_m": 0.298})
        + '[output]\nkind = "file"\nfolder = "x"\n'
        + table_toml("output.gain", vars(Gain(2.0, 50.0, TODAY, 'Z "G"', 30, "file x", 0.5)))
        + '[sensors.hand]\nkind = "serial"\nport = "x"\nrate_hz = 1000\n'
        + table_toml("force", force_values(fit, "hand", 0, TODAY, "ZG"))
    )
    bench = parse_bench(tomllib.loads(text))
    assert bench.screen.height_m == 0.298
    assert bench.output.gain == Gain(2.0, 50.0, TODAY, 'Z "G"', 30, "file x", 0.5)
    forces_n = bench.force.calibration.force_n(np.array([5.0, 305.0, 400.0]))
    assert forces_n[:2] == pytest.approx([0.0, 0.3 * 9.80665], abs=1e-12)
    assert np.isnan(forces_n[2])


def test_gain_tone_has_peak_and_ramps():
    played = tone(0.05 * 200.0, 2, 48e3, 3.0, 0.3)
    assert played.peak == pytest.approx(10.0, rel=1e-3)
    assert np.abs(played.samples[:, [0, -1]]).max() < 1e-2


def test_calibration_figures_are_drawn(artefacts):
    counts = np.array([0.0, 100.0, 200.0, 300.0, 500.0])
    force_figure(fit_force([0.0, 0.101, 0.199, 0.301, 0.5], counts), artefacts / "force_fit.png")
    responses = impulse_responses(A4_PROTOTYPE, [(0.1, 0.1)], rate_hz=150e3, duration_s=7e-3, f_max_hz=60e3)
    responses_figure(responses.of_channels([0, 5]), artefacts / "responses.png")
    assert (artefacts / "responses.png").stat().st_size > 10_000
