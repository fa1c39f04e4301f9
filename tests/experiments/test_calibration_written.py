"""Calibration fits, and their values written into bench files with other content preserved."""

import json
import tomllib
from datetime import date

import numpy as np
import pytest
from hypothesis import given, strategies as st

from tactometry.devices.outputs.gain import Gain
from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.experiments.bench.bench_file import load_bench, parse_bench
from tactometry.experiments.bench.bench_table import table_toml, with_values, write_values
from tactometry.experiments.bench.calibration import display_height_m, fit_force, fit_gain, force_values, tone
from tactometry.experiments.bench.figures import force_figure, responses_figure
from tactometry.stimuli.time_reversal.responses.responses import impulse_responses
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE

TODAY = date(2026, 11, 21)

STATED = """# the bench in room 7
[output]
kind = "file"
folder = "played"        # on the fast disk
{gain}

[sensors.hand]
kind = "lsl"
stream = "force"
rate_hz = "1 kHz"

[force] # of the left hand
sensor = "hand"
newtons_per_count = 0.01 # as the maker says
zero_count = 3
release = false          # the plate is soft
max_age_days = 60
"""
IN_ITS_TABLE = "[output.gain]\nvolts_per_unit = 1.0 # data sheet\namplifier_gain = 50.0\nmax_age_days = 20"
GAIN = ["gain", "--bench", "bench.toml", "--by", "ZG", "--parts", "0.1,0.2", "--measured-v", "10,20", "--write"]


@pytest.mark.parametrize(
    "gain",
    [
        IN_ITS_TABLE,
        "gain = {volts_per_unit = 1.0, amplifier_gain = 50.0, max_age_days = 20} # data sheet",
        "gain.volts_per_unit = 1.0 # data sheet\ngain.amplifier_gain = 50.0\ngain.max_age_days = 20",
    ],
)
def test_gain_is_written_and_the_rest_kept(calibrate, tmp_path, gain):
    file, before = tmp_path / "bench.toml", STATED.format(gain=gain)
    file.write_text(before, encoding="utf-8")
    done = calibrate(*GAIN)
    assert (done.returncode, done.stdout.splitlines()[-1]) == (0, "# written into bench.toml")
    after = file.read_text(encoding="utf-8")
    measured = load_bench(file).output.gain
    assert measured.load_volts_per_unit == pytest.approx(100.0)
    assert (measured.measured_by, measured.max_age_days) == ("ZG", 20)
    assert "# data sheet" in after
    rest = before.split(gain)
    assert [part.strip() in after for part in rest] == [True, True]
    again = calibrate(*GAIN, "--json")
    assert json.loads(again.stdout)["written"] == "bench.toml"
    assert file.read_text(encoding="utf-8") == after


def test_weights_replace_other_form_of_calibration(calibrate, tmp_path):
    file = tmp_path / "bench.toml"
    file.write_bytes(STATED.format(gain=IN_ITS_TABLE).replace("\n", "\r\n").encode())
    typed = ["--weights-kg", "0,0.1,0.2", "--counts", "0,100,200", "--gravity-m-per-s2", "10", "--by", "ZG", "--write"]
    assert calibrate("force", "--bench", "bench.toml", *typed).returncode == 0
    bench, after = load_bench(file), file.read_bytes()
    assert bench.force.calibration.polynomial == pytest.approx((0.0, 0.01))
    assert (bench.force.release, bench.force.calibration.max_age_days) == (False, 60)
    assert b"newtons_per_count" not in after
    assert b"[force] # of the left hand\r\n" in after
    assert b"release = false          # the plate is soft\r\n" in after
    assert after.count(b"\n") == after.count(b"\r\n")


def test_display_height_is_written_without_screen_table(calibrate, tmp_path):
    (tmp_path / "bench.toml").write_text("# ours\n[limits]\nvoltage_peak_v = 1\n", encoding="utf-8")
    assert calibrate("display", "--bar-m", "0.149", "--bench", "bench.toml", "--write").returncode == 0
    bench = load_bench(tmp_path / "bench.toml")
    assert (bench.screen.height_m, bench.limits.voltage_peak_v) == (0.298, 1.0)
    assert (tmp_path / "bench.toml").read_text(encoding="utf-8").startswith("# ours\n")


def test_refused_calibration_is_not_written(calibrate, tmp_path):
    file = tmp_path / "bench.toml"
    file.write_text(STATED.format(gain=IN_ITS_TABLE), encoding="utf-8")
    before = file.read_bytes()
    off = calibrate(*GAIN[:-2], "10,25", "--write")
    assert (off.returncode, file.read_bytes()) == (2, before)
    assert calibrate(*GAIN[:-2], "10,25", "--residual-at-most", "0.2").returncode == 0
    assert file.read_bytes() == before


def test_file_is_kept_when_the_result_is_no_bench(tmp_path):
    file = tmp_path / "bench.toml"
    file.write_text("[screen]\nwidth_px = 800\n", encoding="utf-8")
    with pytest.raises(InvalidFile, match="screen.width_px: found 3, expected a whole number, at least 320"):
        write_values(file, "screen", {"width_px": 3})
    assert file.read_text(encoding="utf-8") == "[screen]\nwidth_px = 800\n"
    linked = tmp_path / "linked.toml"
    linked.symlink_to(file)
    write_values(linked, "screen", {"width_px": 900})
    assert linked.is_symlink()
    assert tomllib.loads(file.read_text(encoding="utf-8")) == {"screen": {"width_px": 900}}


@given(st.dictionaries(st.sampled_from("abcd"), st.floats(-9, 9) | st.text(max_size=5) | st.none(), max_size=4))
def test_keys_are_set_or_removed_and_others_stay(values):
    text = "[t.u] # one\na = 1 # two\nb = 2\nz = 3 # three\n"
    wanted = {key: value for key, value in ({"a": 1, "b": 2, "z": 3} | values).items() if value is not None}
    after = with_values(text, "t.u", values)
    assert tomllib.loads(after) == {"t": {"u": wanted}}
    assert "z = 3 # three\n" in after


# --- fits


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


def test_fit_residuals_sum_to_zero():
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
