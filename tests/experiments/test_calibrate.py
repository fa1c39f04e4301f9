"""Prompts, refusals and output of `tactometry calibrate`."""

import importlib.util
import json
import re
import tomllib
from datetime import date

import numpy as np
import pytest
from benches import gain_toml
from calibrating import LOOPBACK, calibrate_with
from emulated import Emulator, available

from tactometry.experiments.bench.bench_file import parse_bench


@pytest.mark.skipif(not available("serial"), reason="no pyserial: extra serial")
def test_force_sensor_is_calibrated_by_weights(calibrate, tmp_path, artefacts):
    device = Emulator("serial", tmp_path, profile="1:500")
    port = f'[sensors.hand]\nkind = "serial"\nport = "{device.port}"\nrate_hz = 1000\nn_channels = 3\n'
    (tmp_path / "bench.toml").write_text(port, encoding="utf-8")
    base = ["force", "--bench", "bench.toml", "--by", "ZG", "--channel", 2]
    try:
        read_once = calibrate(*base, "--weights-kg", "0,0.1,0.2", answers="y\ny\ny\n")
    finally:
        device.close()
    assert read_once.returncode == 2
    assert "neither rise nor fall with the weights" in read_once.stderr
    typed = ["--weights-kg", "0,0.05,0.1,0.2,0.5", "--counts", "12,110,208.5,404,995"]
    done = calibrate(*base, *typed, "--figure", artefacts / "force.png")
    assert done.returncode == 0, done.stderr
    bench = parse_bench(tomllib.loads(port + done.stdout))
    assert bench.force.calibration.force_n(np.array([12.0, 995.0])) == pytest.approx([0.0, 4.903], abs=0.02)
    assert bench.force.calibration.measured_by == "ZG"
    assert (artefacts / "force.png").stat().st_size > 10_000


def test_silent_sensor_is_not_calibrated(calibrate, tmp_path, monkeypatch):
    monkeypatch.setattr("tactometry.experiments.bench.calibration.FIRST_SAMPLE_WITHIN_S", 0.1)
    (tmp_path / "b.toml").write_text('[sensors.hand]\nkind = "udp"\naddress = "127.0.0.1"\nrate_hz = 1000\n')
    silent = calibrate("force", "--bench", "b.toml", "--by", "Z", "--weights-kg", "0,1,2", answers="y\n")
    assert silent.returncode == 3
    assert "found no sample in 0.1 s, expected a sensor that sends" in silent.stderr


def test_an_output_gain_is_measured_at_the_load(calibrate, tmp_path):
    gain = "[output.gain]\nvolts_per_unit = 1.0\namplifier_gain = 50.0\nmax_age_days = 20\n"
    text = '[output]\nkind = "file"\nfolder = "played"\nrate_hz = 8000\n' + gain
    (tmp_path / "bench.toml").write_text(text, encoding="utf-8")
    base = ["gain", "--bench", "bench.toml", "--by", "ZG"]
    done = calibrate(*base, "--parts", "0.1,0.2", "--measured-v", "10.1,19.9", "--json")
    assert json.loads(done.stdout)["volts_per_unit"] == pytest.approx((1.01 + 3.98) / 0.05)
    done = calibrate(*base, "--parts", "0.1,0.2", "--measured-v", "10.1,19.9")
    measured = parse_bench(tomllib.loads(text[: text.index("[output.gain]")] + done.stdout)).output.gain
    assert measured.load_volts_per_unit == pytest.approx((1.01 + 3.98) / 0.05)
    said = (measured.amplifier_gain, measured.max_age_days, measured.measured_by, measured.measured_with)
    assert said == (50.0, 20, "ZG", "file played")
    refused = calibrate(*base)
    assert "limits: found none in the bench file" in refused.stderr
    assert not (tmp_path / "played").exists()


@pytest.mark.skipif(importlib.util.find_spec("sounddevice") is None, reason="no sounddevice: extra audio")
def test_gain_calibration_plays_tones_and_requests_voltages(calibrate, alsa, tmp_path):
    bench = LOOPBACK.replace('"pulse"', '"tofile"')
    too_old = gain_toml("audio another, int16", 20.0, 1.0, date(2020, 1, 1), max_age_days=1)
    gain = bench[bench.index("[output.gain]") : bench.index("[output.load]")]
    (tmp_path / "bench.toml").write_text(bench.replace(gain, too_old), encoding="utf-8")
    arguments = ["--bench", "bench.toml", "--by", "ZG", "--parts", "0.1,0.2", "--tone-s", "0.2"]
    done = calibrate_with(alsa, tmp_path, "gain", *arguments, "--json", answers="y\n2.1\ny\n4.2\n")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["volts_per_unit"] == pytest.approx(21.0)
    played = np.frombuffer((tmp_path / "played.raw").read_bytes(), "<i2")
    assert np.abs(played).max() / 32767 == pytest.approx(0.2, rel=0.02)
    refused = calibrate("gain", *arguments, "--measured-v", "1,x")
    assert "--measured-v: found '1,x', expected numbers" in refused.stderr


LEARN = "responses --bench s.toml --by Z --sensor hand --units-per-count 1 --volts-per-count 1 --voltage-v 1"
FORCE = "force --by Z --bench s.toml --weights-kg"
GAIN = "gain --by Z --bench s.toml"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("display --bar-m -1", "display: found a bar of -1.0 m"),
        ("display --bar-m 0.1 --write", "--write: found no bench file, expected --bench FILE, the file"),
        ("force --by Z --bench b.toml --weights-kg a,b", "--weights-kg: found 'a,b', expected numbers"),
        ("force --by Z --bench b.toml --weights-kg 1,2,3", "--sensor: found '', expected one of"),
        (f"{FORCE} 1,2,3 --channel 3 --counts 1,2,3", "--channel: found 3, expected a channel of "),
        (f"{FORCE} 1,2", "--weights-kg: found 2, expected at least 3 for a polynomial of degree 1"),
        (f"{FORCE} 1,2,3 --figure f.xyz", "--figure: found 'f.xyz', expected a name that ends in .png, .pdf, .svg"),
        (
            f"{FORCE} 0,0.1,0.2,0.3 --channel 2 --counts 100,200,330,400 --residual-at-most 0.01",
            "found 330 counts at 0.2 kg, off the fit by 6.5% of the largest force, expected at most 1%; weigh",
        ),
        (f"{LEARN} --out x", "--out: found 'x', expected a name that ends in .npz"),
        (f"{LEARN} --out no/x.npz", "--out: found 'no/x.npz', expected .* in an existing folder"),
        (f"{LEARN} --out x.npz", "--band-hz: found up to 70000 Hz, expected at most 500 Hz, half the rate of 'hand'"),
        (f"{GAIN} --parts 0.1,2", "--parts: found 2, expected fractions of full"),
        ("gain --bench b.toml --by Z", r"output\.gain: found none, expected volts_per_unit and"),
        (f"{GAIN} --measured-v 4.1,20.2,20.1", "found 20.2 V at 0.05 of full scale, 68.0% off the line through zero"),
    ],
)
def test_bad_calibration_is_refused_in_one_line(calibrate, tmp_path, words, message):
    (tmp_path / "b.toml").write_text("", encoding="utf-8")
    sensor = (
        "[output.gain]\nvolts_per_unit = 1.0\namplifier_gain = 1.0\n"
        '[sensors.hand]\nkind = "lsl"\nstream = "force"\nrate_hz = 1000\nn_channels = 3\n[limits]\nvoltage_peak_v = 1\n'
    )
    (tmp_path / "s.toml").write_text(sensor, encoding="utf-8")
    result = calibrate(*words.split())
    assert result.returncode == 2
    assert re.search(message, result.stderr)
    assert "\n" not in result.stderr


def test_calibration_needs_an_author(calibrate, tmp_path):
    (tmp_path / "s.toml").write_text("[output.gain]\nvolts_per_unit = 1.0\namplifier_gain = 1.0\n", encoding="utf-8")
    assert "--by: found an empty text, expected initials" in calibrate("gain", "--bench", "s.toml", "--by", " ").stderr
