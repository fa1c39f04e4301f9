"""Measured responses of a simulated plate and of a real loopback."""

import importlib.util
import threading
import time
from contextlib import contextmanager

import numpy as np
import pytest
from calibrating import LOOPBACK, calibrate_with

from tactometry.devices.sensors.reader import Reader, SampleBlock
from tactometry.errors import DeviceFailed, InvalidParameter
from tactometry.experiments.bench.bench_file import load_bench
from tactometry.experiments.bench.bench_parts import Learnt
from tactometry.experiments.bench.learning import Heard, Learning, Microphone, join, learn, quality, repeatable
from tactometry.signal import Signal
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.focusing.focusing import drive, focus_amplitude
from tactometry.stimuli.time_reversal.responses.learning import as_displacement, read_provenance, sequence, sweep
from tactometry.stimuli.time_reversal.responses.measured import read
from tactometry.stimuli.time_reversal.responses.responses import Responses, band_limited, impulse_responses
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE


class DeviceUnderTest:
    """Simulated output and sensor that return the response in real time.

    Noise is added. Channel 0 is the point on the plate. Channel 1 records the drive, whichever channel plays it, after
    the delay of both converters.
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


@contextmanager
def opened(device):
    reader = Reader(device)
    reader.open()
    try:
        yield reader
    finally:
        reader.close()


SHORT = Learning(sequence(8, rate_hz=10e3), 1.0, (0,), 0.01)


def wire_of(gain):
    return DeviceUnderTest(Responses(np.array([[[gain]]]), 10e3), np.random.default_rng(0), noise_db=80.0)


@pytest.mark.parametrize("quantity", ["displacement", "velocity"])
def test_simulated_plate_is_learned_at_40_db(quantity):
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
    excitation = sweep(15e3, 70e3, rate_hz=rate_hz, duration_s=0.1)
    learning = Learning(excitation, 10.0, tuple(range(4)), 0.02, quantity)
    with opened(device) as reader:
        microphone = Microphone(reader, 0, 1, units_per_count=scale, volts_per_count=100.0)
        learned = join([heard.mean for heard in learn(learning, Played(device), microphone)])
    found = as_displacement(learned, 20e3, 60e3)
    assert (found.quantity, found.samples.shape) == ("displacement", (1, 4, 3000))
    kept = Responses(true.samples[:, :, :3000], rate_hz)
    wanted = focus_amplitude(drive(band_limited(kept, Band(20e3, 60e3)), 30.0), kept)
    assert focus_amplitude(drive(found, 30.0), kept) == pytest.approx(wanted, rel=0.05)


class OtherEachTime(DeviceUnderTest):
    """Plate that uses one response after the other, in white noise."""

    def play(self, signal):
        rows = self.responses.samples
        self.responses = Responses(np.roll(rows, -1, axis=1), self.rate_hz)
        return super().play(Signal(np.pad(signal.samples, ((0, len(rows[0]) - 1), (0, 0))), self.rate_hz, "V"))


def test_learning_reports_the_remaining_focus():
    """Two responses that share half of their energy have the cosine 1/sqrt(2)."""
    rate_hz, shapes = 10e3, np.eye(2, 64, 20) + np.eye(2, 64, 20)[0]
    device = OtherEachTime(Responses(0.2 * shapes[None], rate_hz), np.random.default_rng(0), noise_db=200.0)
    learning = Learning(sequence(10, rate_hz=rate_hz), 1.0, (0,), 0.01)
    one = Played(device)
    one.n_channels = 1
    with opened(device) as reader:
        [heard] = learn(learning, one, Microphone(reader, 0, 1, 1.0, 100.0))
    assert quality(heard, (200.0, 4900.0)).repeatability == pytest.approx(2 / np.sqrt(4 * 2), abs=0.02)
    with pytest.raises(DeviceFailed, match=r"channel 7: found repeatability 0\.7.*, expected at least 0\.9"):
        list(repeatable([(7, heard)], (200.0, 4900.0), 0.9))


def test_snr_compares_silence_with_response():
    """Noise at a tenth of the amplitude is 20 dB below in any band."""
    rng = np.random.default_rng(3)
    shape, noise = rng.standard_normal((2, 1, 1, 4096))
    heard = Heard((Responses(shape, 1e3),) * 2, Responses(0.1 * noise, 1e3))
    wide = quality(heard, (50.0, 450.0)).snr_db
    n_free = 2 * 4096 * 0.8  # of a ratio of two energies; each is chi squared
    assert wide == pytest.approx(20.0, abs=3.9 * 10 / np.log(10) * np.sqrt(2 * 2 / n_free))
    louder = Heard(heard.repeats, Responses(noise, 1e3))
    assert quality(louder, (50.0, 450.0)).snr_db == pytest.approx(wide - 20.0)


def test_recording_with_gaps_is_not_learnt():
    device = wire_of(0.5)
    with (
        opened(device) as reader,
        pytest.raises(DeviceFailed, match="output 'plate': found 2 gaps in playback, expected none"),
    ):
        list(learn(SHORT, Played(device, n_gaps=2), Microphone(reader, 0, 1, 1.0, 1.0)))


def test_clipped_or_silent_recording_is_refused():
    device = wire_of(5.0)
    with opened(device) as reader:
        microphone = Microphone(reader, 0, 1, 1.0, 1.0)
        with pytest.raises(DeviceFailed, match="the recording is clipped; lower the voltage"):
            list(learn(SHORT, Played(device), microphone))
        device.responses = Responses(np.array([[[0.0]]]), 10e3)
        with pytest.raises(DeviceFailed, match="found no signal on the channel or its reference"):
            list(learn(SHORT, Played(device), microphone))
    with pytest.raises(DeviceFailed, match="expected the same sampling rate; nothing was played"):
        list(learn(Learning(sequence(8, rate_hz=9e3), 1.0, (0,), 0.01), Played(device), microphone))
    with pytest.raises(InvalidParameter, match="found 0 and 2, expected two different channels from 0 to 1"):
        Microphone(reader, 0, 2, 1.0, 1.0)


def test_real_loopback_is_learned_as_a_wire(sink, tmp_path, artefacts):
    """Output 0 leads to the sensor, output 1 to the reference.

    The signal passes PortAudio, PulseAudio's sink and its monitor.
    """
    (tmp_path / "bench.toml").write_text(LOOPBACK, encoding="utf-8")
    words = (
        "--sensor card --reference-output 1 --units-per-count 1e-6 --volts-per-count 20 --quantity displacement "
        "--voltage-v 5 --band-hz 200 20000 --sequence-order 14 --duration-s 0.01 --out learnt.npz --by ZG --figure"
    )
    arguments = [*words.split(), artefacts / "learnt.png"]
    refused = calibrate_with(sink.env, tmp_path, "responses", "--bench", "bench.toml", *arguments)
    assert (
        refused.returncode,
        "--hands-off: found no confirmation, expected one before a sweep" in refused.stderr,
    ) == (2, True)
    arguments += ["--hands-off", "--write"]
    for _ in range(5):  # a busy computer plays with gaps, or its sound server drops samples
        result = calibrate_with(sink.env, tmp_path, "responses", "--bench", "bench.toml", *arguments)
        if result.returncode == 0 and read_provenance(tmp_path / "learnt.npz")["repeatability"] > 1 - 1e-4:
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
    assert "expected limits of the load; nothing was played" in result.stderr
    assert not (tmp_path / "x.npz").exists()
