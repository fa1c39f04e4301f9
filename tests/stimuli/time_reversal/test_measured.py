"""Measured and learnt responses: files, alignment, checks, tau, sweeps and sequences."""

import math
import sys

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from hypothesis.extra.numpy import arrays
from scipy.io import wavfile

from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.focusing.focusing import drive, focus_amplitude
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
from tactometry.stimuli.time_reversal.responses.learning import (
    as_displacement,
    delay_s,
    learn,
    read_provenance,
    sequence,
    sweep,
    write_learnt,
)
from tactometry.stimuli.time_reversal.responses.measured import (
    aligned,
    inspect,
    read,
    reciprocity_error,
    schroeder_db,
    tau_s,
    trimmed,
)
from tactometry.stimuli.time_reversal.responses.responses import Responses, band_limited, impulse_responses
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE, Screen
from tactometry.stimuli.time_reversal.screen.transducer import border

RATE_HZ = 60000.0
SCREEN = Screen(A4_SCREEN, tuple(border(A4_SCREEN, 16)), Attenuation(3e-3))


@pytest.fixture(scope="module")
def recorded() -> Responses:
    points = [(0.12, 0.09), (0.2, 0.14)]
    return impulse_responses(SCREEN, points, rate_hz=RATE_HZ, duration_s=20e-3, f_max_hz=20e3)


def write_wav(h: Responses, folder) -> list:
    from scipy.io import wavfile

    paths = []
    for i, point in enumerate(h.samples):
        path = folder / f"point{i}.wav"
        wavfile.write(path, int(h.rate_hz), (point.T / np.abs(h.samples).max() * 0.9).astype(np.float32))
        paths.append(path)
    return paths


def write_hdf5(h: Responses, folder) -> list:
    h5py = pytest.importorskip("h5py", reason="the extra hdf5 is not installed")
    with h5py.File(folder / "h.h5", "w") as file:
        file["samples"], file["rate_hz"], file["quantity"] = h.samples, h.rate_hz, h.quantity
    return [folder / "h.h5"]


def write_csv(h: Responses, folder) -> list:
    paths = []
    for i, point in enumerate(h.samples):
        path = folder / f"point{i}.csv"
        header = f"# rate_hz={h.rate_hz} quantity=displacement scale=1e-9\n" + ",".join(f"q{q}" for q in range(16))
        np.savetxt(path, point.T * 1e9, delimiter=",", header=header, comments="", fmt="%.17g")
        paths.append(path)
    return paths


def write_numpy(h: Responses, folder) -> list:
    write_learnt(h, folder / "h.npz", {})
    return [folder / "h.npz"]


@pytest.mark.parametrize(
    ("write", "scale", "tolerance"),
    [(write_wav, True, 1e-7), (write_numpy, False, 0.0), (write_hdf5, False, 0.0), (write_csv, False, 1e-15)],
)
def test_files_return_the_saved_responses(recorded, tmp_path, write, scale, tolerance):
    full_scale = np.abs(recorded.samples).max() / 0.9 if scale else 1.0
    back = read(write(recorded, tmp_path), full_scale=full_scale)
    assert back.rate_hz == recorded.rate_hz
    assert np.abs(back.samples - recorded.samples).max() <= tolerance * np.abs(recorded.samples).max()


def test_sixteen_bit_wav(tmp_path):
    from scipy.io import wavfile

    wavfile.write(tmp_path / "h.wav", 1000, np.array([[16384, -32768]], np.int16))
    assert read([tmp_path / "h.wav"], full_scale=2e-6).samples[0, :, 0] == pytest.approx([1e-6, -2e-6])


def test_absent_file_and_mismatched_files(recorded, tmp_path):
    for suffix in ("npz", "wav", "csv", "h5"):
        with pytest.raises(
            InvalidFile, match=rf"none\.{suffix}: cannot be read \(No such file or directory\), expected"
        ):
            read([tmp_path / f"none.{suffix}"])
    write_learnt(recorded, tmp_path / "a.npz", {})
    write_learnt(trimmed(recorded, 0.0, 5e-3), tmp_path / "b.npz", {})
    with pytest.raises(InvalidFile, match="expected the same as in"):
        read([tmp_path / "a.npz", tmp_path / "b.npz"])


def test_alignment_undoes_a_fractional_delay(recorded):
    band = band_limited(recorded, Band(500.0, 18e3, 1e3))
    late = aligned(band, [-2.37e-4] * 16)
    back = aligned(late, [2.37e-4] * 16)
    assert back.samples[:, :, :900] == pytest.approx(band.samples[:, :, :900], abs=2e-3 * np.abs(band.samples).max())


def test_inspection_finds_clipping_silence_and_noise(recorded):
    assert inspect(recorded).sound
    samples = recorded.samples.copy()
    peak = np.abs(samples[0, 3]).max()
    samples[0, 3] = np.clip(samples[0, 3], -0.3 * peak, 0.3 * peak)
    samples[1, 5] = 0.0
    samples[1, 7] += np.random.default_rng().normal(size=samples.shape[2]) * np.abs(samples[1, 7]).max() * 0.3
    found = inspect(Responses(samples, RATE_HZ))
    assert found.clipped == ((0, 3),)
    assert found.silent == ((1, 5),)
    assert found.noisy == ((1, 7),)


def test_slow_and_repeated_peaks_are_not_clipped():
    t = np.arange(400) / 400
    slow = np.exp(-6 * t) * np.sin(2 * np.pi * 3 * t)
    again = np.where(np.arange(400) % 2 == 0, 1.0, 0.2) * (np.arange(400) < 40)
    assert inspect(Responses(np.stack([slow, again])[None], RATE_HZ)).clipped == ()
    flat = np.where(np.arange(400) < 10, 1.0, 0.1 * again)
    assert inspect(Responses(flat[None, None], RATE_HZ)).clipped == ((0, 0),)


def test_reciprocity_error():
    h = np.sin(np.arange(100.0))
    assert reciprocity_error(h, h) == 0.0
    assert reciprocity_error(h, 1.01 * h) == pytest.approx(0.01, rel=0.01)


def test_schroeder_curve_of_a_pure_decay_is_a_line():
    t = np.arange(6000) / 1e5
    level = schroeder_db(np.exp(-t / 3e-3))
    slope = (level[600] - level[0]) / t[600]
    assert slope == pytest.approx(-20 / math.log(10) / 3e-3, rel=1e-6)


def record_of(tau_s: float, n_taus: float, floor_db: float, rng) -> Responses:
    screen = Screen(A4_SCREEN, tuple(border(A4_SCREEN, 32)), Attenuation(tau_s))
    point = (rng.uniform(0.05, 0.25), rng.uniform(0.04, 0.17))
    h = impulse_responses(screen, [point], rate_hz=RATE_HZ, duration_s=n_taus * tau_s, f_max_hz=25e3)
    noise = np.abs(h.samples).max() * 10 ** (floor_db / 20) * 0.3 * rng.standard_normal(h.samples.shape)
    return Responses(h.samples + noise, RATE_HZ)


def test_tau_is_refused_when_the_record_does_not_decay():
    screen = Screen(A4_SCREEN, tuple(border(A4_SCREEN, 32)), Attenuation(math.inf))
    h = impulse_responses(screen, [(0.12, 0.09)], rate_hz=RATE_HZ, duration_s=10e-3, f_max_hz=25e3)
    with pytest.raises(
        InvalidParameter, match="response: found (a fall by .* dB before its end|its loudest part in the second half)"
    ):
        tau_s(h.samples[0, 0], RATE_HZ)


@pytest.mark.parametrize("n_taus", [2, 3, 10])
def test_short_responses_without_noise_are_sound(n_taus):
    assert inspect(record_of(3.5e-3, n_taus, -math.inf, np.random.default_rng())).sound


def test_inspection_finds_noise_floor_common_to_all_pairs():
    assert len(inspect(record_of(3.5e-3, 8, -3.0, np.random.default_rng())).noisy) > 16


@pytest.mark.parametrize("n_taus", [2.0, 5.0, 20.0, 60.0, 300.0])
def test_tau_is_independent_of_record_length(n_taus) -> None:
    t_s = np.arange(round(n_taus * 4e-3 * 1e5)) / 1e5
    assert tau_s(np.exp(-t_s / 4e-3) * np.sin(1e4 * t_s), 1e5) == pytest.approx(4e-3, rel=0.02)


def test_eight_bit_wav_is_unsigned_around_128(tmp_path):
    path = tmp_path / "a.wav"
    wavfile.write(path, 8000, np.array([[0, 64], [128, 192]], np.uint8))
    assert read([path], full_scale=2.0).samples.tolist() == [[[-2.0, 0.0], [-1.0, 1.0]]]


def test_hdf5_without_its_extra_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "h5py", None)
    (tmp_path / "a.h5").touch()
    with pytest.raises(InvalidFile, match=r"pip install tactometry\[hdf5\]"):
        read([tmp_path / "a.h5"])


@pytest.mark.parametrize(
    ("said", "factor"),
    [
        ("unit=m", 1.0),
        ("unit=mm", 1e-3),
        ("unit=um", 1e-6),
        ("unit=nm", 1e-9),
        ("unit=um scale=2", 2e-6),
        ("quantity=velocity unit=mm/s", 1e-3),
        ("quantity=acceleration unit=m/s2", 1.0),
    ],
)
def test_a_csv_file_says_its_unit(tmp_path, said, factor):
    path = tmp_path / "a.csv"
    path.write_text(f"# rate_hz=1000 {said}\na,b\n1,2\n3,4\n")
    np.testing.assert_allclose(read([path]).samples, factor * np.array([[[1, 3], [2, 4]]]), rtol=1e-15)


# --- responses learnt from sweeps and sequences

FAST_HZ, DURATION_S, F_MAX_HZ = 150e3, 7e-3, 60e3
BAND = Band(20e3, 60e3)
EXCITATIONS = {
    "sweep": sweep(15e3, 70e3, rate_hz=FAST_HZ, duration_s=0.1),
    "sequence": sequence(14, rate_hz=FAST_HZ),
}


@pytest.fixture(scope="module")
def plate():
    """The true responses of a focus on the simulated screen, in m per V; recordings last until they have decayed."""
    return impulse_responses(A4_PROTOTYPE, [(0.121, 0.093)], rate_hz=FAST_HZ, duration_s=0.03, f_max_hz=F_MAX_HZ)


def record_channels(plate, excitation, voltage_v, noise_db, rng):
    """Record each channel, with noise `noise_db` below its rms."""
    clean = np.array([np.convolve(voltage_v * excitation.samples, h) for h in plate.samples[0]])
    noise = (
        rng.standard_normal(clean.shape) * np.sqrt(np.mean(clean**2, axis=1, keepdims=True)) * 10 ** (noise_db / -20)
    )
    return clean + noise


@pytest.mark.parametrize("excitation", EXCITATIONS.values(), ids=EXCITATIONS)
def test_responses_learnt_at_40_db_focus_accurately(plate, excitation):
    heard = record_channels(plate, excitation, 10.0, 40.0, np.random.default_rng(20261121))
    learned = learn(10.0 * excitation.samples, heard, FAST_HZ, duration_s=DURATION_S)
    true = Responses(plate.samples[:, :, : learned.n_samples], FAST_HZ)
    with_truth = focus_amplitude(drive(band_limited(true, BAND), 30.0), true)
    with_learnt = focus_amplitude(drive(band_limited(learned, BAND), 30.0), true)
    assert with_learnt == pytest.approx(with_truth, rel=0.05)
    claimed = focus_amplitude(drive(band_limited(learned, BAND), 30.0), band_limited(learned, BAND))
    meant = focus_amplitude(drive(band_limited(true, BAND), 30.0), band_limited(true, BAND))
    assert claimed == pytest.approx(meant, rel=0.05)


@given(arrays(np.float64, (3, 20), elements=st.floats(-1, 1)))
@settings(max_examples=30)
def test_without_noise_a_sequence_gives_back_any_response(h):
    pulse = sequence(9, rate_hz=1e3).samples
    heard = np.array([np.convolve(pulse, row) for row in h])
    assert np.allclose(learn(pulse, heard, 1e3, duration_s=0.02, regularisation=0.0).samples[0], h, atol=1e-9)


def test_a_reference_channel_takes_latency_and_converters_away():
    rng = np.random.default_rng(3)
    pulse, converter, h = (
        sequence(10, rate_hz=1e3).samples,
        np.array([0.0, 0.0, 0.0, 0.9, 0.2]),
        rng.standard_normal(30),
    )
    reference = np.convolve(pulse, converter)
    heard = np.convolve(reference, h)
    reference = np.pad(reference, (0, len(heard) - len(reference)))
    found = learn(reference[None], heard[None], 1e3, duration_s=0.03, regularisation=1e-12)
    assert np.allclose(found.samples[0, 0], h, atol=1e-6)
    assert delay_s(pulse, heard, 1e3) >= 0.003


def test_regularisation_suppresses_noise_outside_played_band(plate):
    """Half of the band was not played: without regularisation its noise drowns the response."""
    excitation = sweep(20e3, 40e3, rate_hz=FAST_HZ, duration_s=0.05)
    heard = record_channels(plate, excitation, 10.0, 40.0, np.random.default_rng(5))
    sizes = [
        np.abs(learn(10.0 * excitation.samples, heard, FAST_HZ, duration_s=DURATION_S, regularisation=r).samples).max()
        for r in (0.0, 1e-4)
    ]
    assert sizes[0] > 10 * np.abs(plate.samples).max()
    assert sizes[1] < 2 * np.abs(plate.samples).max()


def test_sweep_fills_its_band_between_zero_ends():
    excitation = sweep(15e3, 45e3, rate_hz=FAST_HZ, duration_s=0.1)
    power = np.square(np.abs(np.fft.rfft(excitation.samples)))
    frequency_hz = np.fft.rfftfreq(len(excitation.samples), 1 / FAST_HZ)
    inside = (frequency_hz >= 14e3) & (frequency_hz <= 46e3)
    assert power[inside].sum() > 0.999 * power.sum()
    assert np.abs(excitation.samples).max() <= 1.0
    assert np.abs(excitation.samples[[0, -1]]).max() < 1e-9


def test_a_sequence_is_white():
    power = np.square(np.abs(np.fft.rfft(sequence(12, rate_hz=1e3).samples)))
    assert np.allclose(power[1:], 2**12, rtol=1e-9)


@pytest.mark.parametrize("late", [-0.4, -0.2, 0.3])
def test_delay_is_found_with_subsample_precision(late):
    t = np.arange(400) - 100.0
    played, recorded = (np.exp(-(((t - shift) / 4) ** 2)) for shift in (0.0, 20.0 + late))
    assert delay_s(played, recorded, 1e3) * 1e3 == pytest.approx(20.0 + late, abs=0.01)


@pytest.mark.parametrize(("quantity", "tolerance"), [("velocity", 0.02), ("acceleration", 0.06)])
def test_velocity_and_acceleration_are_integrated_to_displacement(quantity, tolerance):
    """The acceleration leaves out the impulse at time 0, which costs a few percent."""
    timing = {"rate_hz": 150e3, "duration_s": 20e-3, "f_max_hz": 40e3}
    heard, expected = (
        impulse_responses(A4_PROTOTYPE, [(0.121, 0.093)], **timing, quantity=q) for q in (quantity, "displacement")
    )
    found = as_displacement(heard, 5e3, 30e3)
    inside = as_displacement(expected, 5e3, 30e3)
    assert np.linalg.norm(found.samples - inside.samples) < tolerance * np.linalg.norm(inside.samples)


def test_learnt_responses_are_saved_with_provenance(tmp_path, plate):
    path = tmp_path / "learnt.npz"
    write_learnt(plate, path, {"measured_by": "ZG", "excitation": "sweep", "voltage_v": 10.0})
    assert np.array_equal(read([path]).samples, plate.samples)
    assert read_provenance(path) == {"measured_by": "ZG", "excitation": "sweep", "voltage_v": 10.0}


def test_file_without_provenance_is_refused_by_name(tmp_path):
    (tmp_path / "torn.npz").write_bytes(b"PK\x03\x04")
    for name in ("none.npz", "torn.npz"):
        with pytest.raises(InvalidFile, match=f"{name}: cannot be read .*expected"):
            read_provenance(tmp_path / name)
