"""Calibrations: fits that recover the truth, words that a bench file understands, and responses learnt for real."""

import importlib.util
import io
import json
import re
import subprocess
import sys
import threading
import time
import tomllib
from datetime import date

import numpy as np
import pytest
from benches import gain_toml as gain_toml_of
from command_line import call
from emulated import Emulator, available, wait_for
from hands import SCREEN_PX
from hypothesis import given, strategies as st
from patience import LONGEST_PROGRAM_S

from tactometry.cli import main
from tactometry.devices.outputs.gain import Gain
from tactometry.devices.sensors.reader import Reader, SampleBlock
from tactometry.errors import DeviceFailed, InvalidFile, InvalidParameter, Stopped
from tactometry.experiments.bench.bench_file import Learnt, load_bench, parse_bench
from tactometry.experiments.bench.bench_table import table_toml, with_values, write_values
from tactometry.experiments.bench.calibration import display_height_m, fit_force, fit_gain, force_values, show_bar, tone
from tactometry.experiments.bench.figures import force_figure, responses_figure
from tactometry.experiments.bench.learning import Heard, Learning, Microphone, join, learn, quality, repeatable
from tactometry.signal import Signal
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.focusing.focusing import drive, focus_amplitude
from tactometry.stimuli.time_reversal.responses.learning import as_displacement, read_provenance, sequence, sweep
from tactometry.stimuli.time_reversal.responses.measured import read
from tactometry.stimuli.time_reversal.responses.responses import Responses, band_limited, impulse_responses
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE

TODAY = date(2026, 11, 21)


# --- fits


@given(st.floats(-5, 5), st.floats(1e-4, 1.0), st.booleans(), st.floats(-1e-6, 1e-6))
def test_the_polynomial_of_a_sensor_is_recovered(offset_n, slope, falling, bend):
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
def test_a_gain_is_recovered(volts_per_unit, units):
    fit = fit_gain(units, [volts_per_unit * unit for unit in units])
    assert fit.volts_per_unit == pytest.approx(volts_per_unit, rel=1e-12)
    assert fit.residual_rms_v < 1e-9 * volts_per_unit


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: fit_force([0, 1], [0, 1]), "found 2 masses and 2 counts, expected .* at least 3 for degree 1"),
        (lambda: fit_force([0, 1, 2], [0, 1, np.nan]), "found a mass or a count that is no finite number"),
        (lambda: fit_force([0, 1, -2], [0, 1, 2]), "or a mass below 0"),
        (lambda: fit_force([0, 1, 2], [0, 5, 3]), "neither rise nor fall with the weights"),
        (lambda: fit_gain([0.1], [1.0]), "found 1 and 1 values, expected as many, at least two"),
        (lambda: fit_gain([0.1, 0.2], [1.0, -1.0]), "not a finite number above 0"),
        (lambda: display_height_m(0.0), "found a bar of 0.0 m"),
    ],
)
def test_what_cannot_be_fitted_is_refused(call, message):
    with pytest.raises(InvalidParameter, match=message):
        call()


def test_what_is_printed_is_a_bench_file():
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


def test_the_tone_of_a_gain_has_its_part_and_ramps():
    played = tone(0.05 * 200.0, 2, 48e3, 3.0, 0.3)
    assert played.peak == pytest.approx(10.0, rel=1e-3)
    assert np.abs(played.samples[:, [0, -1]]).max() < 1e-2


# --- writing

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
def test_a_gain_is_written_into_the_bench_file_and_all_else_stays(calibrate, tmp_path, gain):
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


def test_weights_take_the_place_of_another_form_of_calibration(calibrate, tmp_path):
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


def test_a_display_is_written_where_the_file_has_no_screen(calibrate, tmp_path):
    (tmp_path / "bench.toml").write_text("# ours\n[limits]\nvoltage_peak_v = 1\n", encoding="utf-8")
    assert calibrate("display", "--bar-m", "0.149", "--bench", "bench.toml", "--write").returncode == 0
    bench = load_bench(tmp_path / "bench.toml")
    assert (bench.screen.height_m, bench.limits.voltage_peak_v) == (0.298, 1.0)
    assert (tmp_path / "bench.toml").read_text(encoding="utf-8").startswith("# ours\n")


def test_what_is_refused_is_not_written(calibrate, tmp_path):
    file = tmp_path / "bench.toml"
    file.write_text(STATED.format(gain=IN_ITS_TABLE), encoding="utf-8")
    before = file.read_bytes()
    off = calibrate(*GAIN[:-2], "10,25", "--write")
    assert (off.returncode, file.read_bytes()) == (2, before)
    assert calibrate(*GAIN[:-2], "10,25", "--residual-at-most", "0.2").returncode == 0
    assert file.read_bytes() == before


def test_a_file_that_would_be_no_bench_stands(tmp_path):
    file = tmp_path / "bench.toml"
    file.write_text("[screen]\nwidth_px = 800\n", encoding="utf-8")
    with pytest.raises(InvalidFile, match="screen.width_px: found 3, expected at least 320 pixels"):
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


# --- learning


class DeviceUnderTest:
    """An output and a sensor in one: what is played comes back through responses, with noise, in real time.

    Channel 0 is the point on the plate; channel 1 hears the drive, whichever channel plays it, late by both converters.
    """

    name, n_channels, limits = "device under test", 2, None
    latency = 37

    def __init__(self, responses, rng, noise_db):
        self.responses, self._rng, self._noise_db = responses, rng, noise_db
        self.rate_hz = responses.rate_hz
        self._waiting = np.zeros((2, 0))
        self._lock = threading.Lock()

    def play(self, signal):
        through = sum(np.convolve(v, h) for v, h in zip(signal.samples, self.responses.samples[0], strict=True))
        noise = self._rng.standard_normal(len(through)) * np.sqrt(np.mean(through**2)) * 10 ** (self._noise_db / -20)
        both = np.zeros((2, len(through) + self.latency))
        both[0, self.latency :] = through + noise
        both[1, self.latency : self.latency + signal.samples.shape[1]] = signal.samples.sum(axis=0) / 100.0
        with self._lock:
            self._waiting = both
        return time.perf_counter()

    def open(self):
        self._end_s = time.perf_counter()

    def receive(self):
        time.sleep(0.005)
        n = int((time.perf_counter() - self._end_s) * self.rate_hz)
        with self._lock:
            piece, self._waiting = self._waiting[:, :n], self._waiting[:, n:]
        values = np.pad(piece, ((0, 0), (0, n - piece.shape[1]))).T
        times_s = self._end_s + np.arange(1, n + 1) / self.rate_hz
        self._end_s = float(times_s[-1]) if n else self._end_s
        return SampleBlock(times_s, values)

    def close(self):
        pass

    def facts(self):
        return {}


class Played:
    """The output half of a device under test."""

    limits, name = None, "plate"

    def __init__(self, device, n_gaps=0):
        self.driver, self.play, self.n_gaps = self, device.play, lambda: n_gaps
        self.n_channels, self.rate_hz = device.responses.n_channels, device.rate_hz


@pytest.mark.parametrize("quantity", ["displacement", "velocity"])
def test_a_simulated_plate_is_learnt_through_its_vibrometer_at_40_db(quantity):
    rate_hz, focus = 150e3, [(0.121, 0.093)]
    channels = [0, 9, 18, 27]
    true, heard = (
        impulse_responses(
            A4_PROTOTYPE, focus, rate_hz=rate_hz, duration_s=0.03, f_max_hz=60e3, quantity=kind
        ).of_channels(channels)
        for kind in ("displacement", quantity)
    )
    scale = 10.0 * np.abs(heard.samples).sum(axis=2).max()
    device = DeviceUnderTest(Responses(heard.samples / scale, rate_hz), np.random.default_rng(11), noise_db=40.0)
    reader = Reader(device)
    reader.open()
    excitation = sweep(15e3, 70e3, rate_hz=rate_hz, duration_s=0.1)
    learning = Learning(excitation, 10.0, tuple(range(4)), 0.02, quantity)
    microphone = Microphone(reader, 0, 1, units_per_count=scale, volts_per_count=100.0)
    learned = join([heard.mean for heard in learn(learning, Played(device), microphone)])
    reader.close()
    found = as_displacement(learned, 20e3, 60e3)
    assert (found.quantity, found.samples.shape) == ("displacement", (1, 4, 3000))
    kept = Responses(true.samples[:, :, :3000], rate_hz)
    wanted = focus_amplitude(drive(band_limited(kept, Band(20e3, 60e3)), 30.0), kept)
    assert focus_amplitude(drive(found, 30.0), kept) == pytest.approx(wanted, rel=0.05)


class OtherEachTime(DeviceUnderTest):
    """A plate that answers as one row of its responses after the other, and a quiet that is white noise."""

    def play(self, signal):
        rows = self.responses.samples
        self.responses = Responses(np.roll(rows, -1, axis=1), self.rate_hz)
        return super().play(Signal(np.pad(signal.samples, ((0, len(rows[0]) - 1), (0, 0))), self.rate_hz, "V"))


def test_what_the_next_response_leaves_of_a_focus_is_told():
    """Of two responses at right angles for a half of their energy, it is their cosine."""
    rate_hz, shapes = 10e3, np.eye(2, 64, 20) + np.eye(2, 64, 20)[0]
    device = OtherEachTime(Responses(0.2 * shapes[None], rate_hz), np.random.default_rng(0), noise_db=200.0)
    reader = Reader(device)
    reader.open()
    learning, microphone = (
        Learning(sequence(10, rate_hz=rate_hz), 1.0, (0,), 0.01),
        Microphone(reader, 0, 1, 1.0, 100.0),
    )
    one = Played(device)
    one.n_channels = 1
    [heard] = learn(learning, one, microphone)
    reader.close()
    assert quality(heard, (200.0, 4900.0)).repeatability == pytest.approx(2 / np.sqrt(4 * 2), abs=0.02)
    with pytest.raises(DeviceFailed, match=r"channel 7: found a repeatability of 0\.7.*, expected at least 0\.9"):
        list(repeatable([(7, heard)], (200.0, 4900.0), 0.9))


def test_the_quiet_is_compared_with_the_response():
    """Noise of a tenth of the amplitude is 20 dB below, whatever the band."""
    rng = np.random.default_rng(3)
    shape, noise = rng.standard_normal((2, 1, 1, 4096))
    heard = Heard((Responses(shape, 1e3),) * 2, Responses(0.1 * noise, 1e3))
    wide = quality(heard, (50.0, 450.0)).snr_db
    n_free = 2 * 4096 * 0.8  # of a ratio of two energies; each is chi squared
    assert wide == pytest.approx(20.0, abs=3.9 * 10 / np.log(10) * np.sqrt(2 * 2 / n_free))
    louder = Heard(heard.repeats, Responses(noise, 1e3))
    assert quality(louder, (50.0, 450.0)).snr_db == pytest.approx(wide - 20.0)


def test_what_was_played_with_gaps_is_not_learnt():
    device = DeviceUnderTest(Responses(np.array([[[0.5]]]), 10e3), np.random.default_rng(0), noise_db=80.0)
    reader = Reader(device)
    reader.open()
    learning = Learning(sequence(8, rate_hz=10e3), 1.0, (0,), 0.01)
    with pytest.raises(DeviceFailed, match="output 'plate': found 2 gaps in what was played, expected none"):
        list(learn(learning, Played(device, n_gaps=2), Microphone(reader, 0, 1, 1.0, 1.0)))
    reader.close()


def test_a_recording_that_is_clipped_or_silent_is_refused():
    device = DeviceUnderTest(Responses(np.array([[[5.0]]]), 10e3), np.random.default_rng(0), noise_db=80.0)
    reader = Reader(device)
    reader.open()
    learning = Learning(sequence(8, rate_hz=10e3), 1.0, (0,), 0.01)
    with pytest.raises(DeviceFailed, match="the recording is clipped; lower the voltage"):
        list(learn(learning, Played(device), Microphone(reader, 0, 1, 1.0, 1.0)))
    device.responses = Responses(np.array([[[0.0]]]), 10e3)
    with pytest.raises(DeviceFailed, match="heard nothing, expected both to"):
        list(learn(learning, Played(device), Microphone(reader, 0, 1, 1.0, 1.0)))
    reader.close()
    with pytest.raises(DeviceFailed, match="expected one rate; nothing was played"):
        list(learn(Learning(sequence(8, rate_hz=9e3), 1.0, (0,), 0.01), Played(device), Microphone(reader, 0, 1, 1, 1)))
    with pytest.raises(InvalidParameter, match="found 0 and 2, expected two of 0 to 1"):
        Microphone(reader, 0, 2, 1.0, 1.0)


LOOPBACK = """
[output]
kind = "audio"
device = "pulse"
rate_hz = 48000
channels = [0, 1]
sample_format = "int16"
shared = true
{gain}
[output.load]
kind = "piezo"
capacitance_f = "1 nF"
displacement_m_per_v = [1e-6]
[limits]
voltage_peak_v = 20.0
duration_s = 10.0
current_peak_a = "10 mA"
displacement_peak_m = "1 mm"
duty = 1.0
session_s = "10 min"
[sensors.card]
kind = "audio"
device = "monitor"
rate_hz = 48000
n_channels = 2
""".format(gain=gain_toml_of("audio pulse, int16", 20.0, 1.0, system_volume=1.0))


def calibrate_with(env, cwd, *arguments, answers=""):
    """In a process of its own, whose sound library sees `env`."""
    command = [sys.executable, "-m", "tactometry", "calibrate", *map(str, arguments)]
    return subprocess.run(
        command, cwd=cwd, env=env, input=answers, capture_output=True, text=True, timeout=LONGEST_PROGRAM_S, check=False
    )


@pytest.fixture
def calibrate(tmp_path, monkeypatch, capsys):
    def run(*arguments, answers=""):
        monkeypatch.setattr("sys.stdin", io.StringIO(answers))
        status, said, out = call(capsys, "calibrate", *arguments)
        return subprocess.CompletedProcess(arguments, status, out, said)

    monkeypatch.chdir(tmp_path)
    return run


def test_a_real_loopback_is_learnt_as_a_wire(sink, tmp_path, artefacts):
    """Output 0 to the sensor, output 1 to the reference, through PortAudio, PulseAudio's sink and its monitor."""
    (tmp_path / "bench.toml").write_text(LOOPBACK, encoding="utf-8")
    arguments = ["--sensor", "card", "--reference-output", 1, "--units-per-count", 1e-6, "--volts-per-count", 20.0]
    arguments += ["--quantity", "displacement", "--voltage-v", 10.0, "--band-hz", 200, 20000, "--sequence-order", 14]
    arguments += ["--duration-s", 0.01, "--out", "learnt.npz", "--figure", artefacts / "learnt.png", "--by", "ZG"]
    refused = calibrate_with(sink.env, tmp_path, "responses", "--bench", "bench.toml", *arguments)
    assert (refused.returncode, "hands are off, expected it; nothing was played" in refused.stderr) == (2, True)
    arguments += ["--hands-off", "--write"]
    for _ in range(5):  # a busy computer tears what it plays, which is then not learnt
        result = calibrate_with(sink.env, tmp_path, "responses", "--bench", "bench.toml", *arguments)
        if "in what was played" not in result.stderr:
            break
    assert result.returncode == 0, result.stderr
    assert "learnt.npz: 1 responses of 0.01 s at 48000 Hz" in result.stdout
    found = read([tmp_path / "learnt.npz"])
    wire = Responses(np.eye(1, 480)[None] * 1e-6 / 20.0, 48e3)
    wanted = as_displacement(wire, 200.0, 20e3)
    assert np.allclose(found.samples, wanted.samples, atol=2e-3 * np.abs(wanted.samples).max())
    said = read_provenance(tmp_path / "learnt.npz")
    assert (said["measured_by"], said["excitation"], said["output"]) == ("ZG", "maximum-length sequence", "audio pulse")
    assert (said["signal_to_noise"], said["repeatability"]) == ("no noise was recorded", pytest.approx(1.0, abs=1e-4))
    assert load_bench(tmp_path / "bench.toml").time_reversal == Learnt("learnt.npz")


@pytest.mark.skipif(importlib.util.find_spec("sounddevice") is None, reason="no sounddevice: extra audio")
def test_without_limits_nothing_is_learnt_nor_played(calibrate, tmp_path):
    (tmp_path / "bench.toml").write_text(LOOPBACK.replace("[limits]", "[limitz]"), encoding="utf-8")
    arguments = ["--sensor", "card", "--units-per-count", 1, "--volts-per-count", 1, "--voltage-v", 1]
    result = calibrate("responses", "--bench", "bench.toml", *arguments, "--out", "x.npz", "--by", "ZG")
    assert (result.returncode, "did you mean 'limits'" in result.stderr) == (2, True)
    text = LOOPBACK[: LOOPBACK.index("[limits]")] + LOOPBACK[LOOPBACK.index("[sensors") :]
    (tmp_path / "bench.toml").write_text(text, encoding="utf-8")
    result = calibrate("responses", "--bench", "bench.toml", *arguments, "--out", "x.npz", "--by", "ZG")
    assert "expected those of the load; nothing was played" in result.stderr
    assert not (tmp_path / "x.npz").exists()


# --- the commands


@pytest.mark.skipif(not available("serial"), reason="no pyserial: extra serial")
def test_a_force_sensor_is_calibrated_by_weights(calibrate, tmp_path, artefacts):
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
    typed = [
        "--weights-kg",
        "0,0.05,0.1,0.2,0.5",
        "--counts",
        "12,110,208.5,404,995",
        "--figure",
        artefacts / "force.png",
    ]
    done = calibrate(*base, *typed)
    assert done.returncode == 0, done.stderr
    bench = parse_bench(tomllib.loads(port + done.stdout))
    assert bench.force.calibration.force_n(np.array([12.0, 995.0])) == pytest.approx([0.0, 4.903], abs=0.02)
    assert bench.force.calibration.measured_by == "ZG"
    assert (artefacts / "force.png").stat().st_size > 10_000


def test_a_sensor_that_sends_nothing_is_not_calibrated(calibrate, tmp_path, monkeypatch):
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
def test_tones_are_played_at_the_load_and_the_voltages_asked_for(calibrate, alsa, tmp_path):
    bench = LOOPBACK.replace('"pulse"', '"tofile"')
    too_old = gain_toml_of("audio another, int16", 20.0, 1.0, date(2020, 1, 1), max_age_days=1)
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


def test_a_display_is_measured_by_its_bar(calibrate):
    assert calibrate("display", "--bar-m", "0.149").stdout == "[screen]\nheight_m = 0.298\n"


WEIGH = ["force", "--bench", "s.toml", "--by", "Z", "--channel", 2, "--weights-kg", "0,0.1,0.2,0.3"]
LEARN = ["responses", "--bench", "s.toml", "--by", "Z", "--sensor", "hand", "--units-per-count", 1]
LEARN += ["--volts-per-count", 1, "--voltage-v", 1]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["display", "--bar-m", "-1"], "display: found a bar of -1.0 m"),
        (
            ["force", "--bench", "b.toml", "--by", "Z", "--weights-kg", "a,b"],
            "--weights-kg: found 'a,b', expected numbers",
        ),
        (["force", "--bench", "b.toml", "--by", "Z", "--weights-kg", "1,2,3"], "--sensor: found '', expected one of"),
        (
            ["force", "--bench", "s.toml", "--by", "Z", "--channel", 3, "--weights-kg", "1,2,3", "--counts", "1,2,3"],
            "--channel: found 3, expected from 0 to 2, a channel of ",
        ),
        (
            ["force", "--bench", "s.toml", "--by", "Z", "--weights-kg", "1,2"],
            "--weights-kg: found 2, expected at least 3 for a polynomial of degree 1",
        ),
        (
            ["force", "--bench", "s.toml", "--by", "Z", "--weights-kg", "1,2,3", "--figure", "f.xyz"],
            "--figure: found 'f.xyz', expected a name that ends in .png, .pdf, .svg",
        ),
        (["gain", "--bench", "s.toml", "--by", "Z", "--parts", "0.1,2"], "--parts: found 2, expected parts of full"),
        ([*LEARN, "--out", "x"], "--out: found 'x', expected a name that ends in .npz"),
        ([*LEARN, "--out", "no/x.npz"], "--out: found 'no/x.npz', expected .* in a folder that exists"),
        (
            [*LEARN, "--out", "x.npz"],
            "--band-hz: found up to 70000 Hz, expected at most 500 Hz, half the rate of 'hand'",
        ),
        (["gain", "--bench", "s.toml", "--by", " "], "--by: found nothing, expected who measures"),
        (["gain", "--bench", "b.toml", "--by", "Z"], r"output\.gain: found none, expected volts_per_unit and"),
        (
            ["gain", "--bench", "s.toml", "--by", "Z", "--measured-v", "4.1,20.2,20.1"],
            "found 20.2 V at 0.05 of full scale, 68.0% off the line through zero, expected at most 5%; measure",
        ),
        (
            [*WEIGH, "--counts", "100,200,330,400", "--residual-at-most", "0.01"],
            "found 330 counts at 0.2 kg, 6.5% of the largest force off the fit, expected at most 1%; weigh",
        ),
        (["display", "--bar-m", "0.1", "--write"], "--write: found no bench file, expected --bench, the file to write"),
    ],
)
def test_a_bad_calibration_is_one_sentence(calibrate, tmp_path, arguments, message):
    (tmp_path / "b.toml").write_text("", encoding="utf-8")
    sensor = (
        "[output.gain]\nvolts_per_unit = 1.0\namplifier_gain = 1.0\n"
        '[sensors.hand]\nkind = "lsl"\nstream = "force"\nrate_hz = 1000\nn_channels = 3\n[limits]\nvoltage_peak_v = 1\n'
    )
    (tmp_path / "s.toml").write_text(sensor, encoding="utf-8")
    result = calibrate(*arguments)
    assert result.returncode == 2
    assert re.search(message, result.stderr)
    assert "\n" not in result.stderr


def test_the_figures_are_drawn(artefacts):
    counts = np.array([0.0, 100.0, 200.0, 300.0, 500.0])
    force_figure(fit_force([0.0, 0.101, 0.199, 0.301, 0.5], counts), artefacts / "force_fit.png")
    responses = impulse_responses(A4_PROTOTYPE, [(0.1, 0.1)], rate_hz=150e3, duration_s=7e-3, f_max_hz=60e3)
    responses_figure(responses.of_channels([0, 5]), artefacts / "responses.png")
    assert (artefacts / "responses.png").stat().st_size > 10_000


class Ruler:
    """Someone at the screen: measures the bar as the X server shows it, goes on with a key, and types its length."""

    def __init__(self, hands):
        self._hands, self._root = hands, hands._display.screen().root
        self._n_windows = self._n_shown()
        self.length_px, self.n_windows_when_asked = 0, None

    def _n_shown(self):
        from Xlib import X

        return sum(each.get_attributes().map_state == X.IsViewable for each in self._root.query_tree().children)

    def _bar_px(self):
        from Xlib import X

        shown = self._root.get_image(0, 0, *SCREEN_PX, X.ZPixmap, 0xFFFFFFFF)
        pixels = np.frombuffer(shown.data, np.uint8).reshape(SCREEN_PX[1], SCREEN_PX[0], 4)[..., :3].min(axis=2)
        column = pixels[:, SCREEN_PX[0] // 2 - SCREEN_PX[1] // 2]
        return int(np.count_nonzero(column > 200))

    def measure(self):
        wait_for(lambda: self._n_shown() > self._n_windows and self._bar_px() > 0)
        self.length_px = self._bar_px()
        self._hands.tap("space")

    def readline(self, size=-1):
        del size
        self.n_windows_when_asked = self._n_shown() - self._n_windows
        return f"{self.length_px * 2.5e-4}\n"


def test_the_bar_that_is_shown_is_half_of_the_picture(display, screen, monkeypatch, capsys, in_background):
    """The window of the command opens in front of that of the other tests, full screen, and is closed before the
    terminal asks; the keyboard of both is one, and ends with it."""
    ruler = Ruler(display)
    monkeypatch.setattr("sys.stdin", ruler)
    in_background(ruler.measure)
    with pytest.raises(SystemExit) as ended:
        main(["calibrate", "display"])
    screen._keyboard.start()
    assert ended.value.code == 0
    assert ruler.length_px == pytest.approx(SCREEN_PX[1] / 2, abs=2)
    assert ruler.n_windows_when_asked == 0
    assert capsys.readouterr().out.startswith(f"[screen]\nheight_m = {2 * ruler.length_px * 2.5e-4!r}")


def test_escape_leaves_the_bar_and_measures_nothing(watched, participant):
    participant.answers("Escape")
    with pytest.raises(Stopped, match="Escape was pressed; nothing was measured"):
        show_bar(watched)
