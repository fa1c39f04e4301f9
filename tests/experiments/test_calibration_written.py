"""Calibration values written into bench files, other content preserved."""

import json
import tomllib

import pytest
from hypothesis import given, strategies as st

from tactometry.errors import InvalidFile
from tactometry.experiments.bench.bench_file import load_bench
from tactometry.experiments.bench.bench_table import with_values, write_values

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
