"""Impulse responses learnt from sweeps and sequences."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from hypothesis.extra.numpy import arrays

from tactometry.errors import InvalidFile
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.focusing.focusing import drive, focus_amplitude
from tactometry.stimuli.time_reversal.responses.learning import (
    as_displacement,
    delay_s,
    learn,
    read_provenance,
    sequence,
    sweep,
    write_learnt,
)
from tactometry.stimuli.time_reversal.responses.measured import read
from tactometry.stimuli.time_reversal.responses.responses import Responses, band_limited, impulse_responses
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE

RATE_HZ, DURATION_S, F_MAX_HZ = 150e3, 7e-3, 60e3
BAND = Band(20e3, 60e3)
EXCITATIONS = {"sweep": sweep(15e3, 70e3, rate_hz=RATE_HZ, duration_s=0.1), "sequence": sequence(14, rate_hz=RATE_HZ)}


@pytest.fixture(scope="module")
def plate():
    """The true responses of a focus on the simulated screen, in m per V; recordings last until they have decayed."""
    return impulse_responses(A4_PROTOTYPE, [(0.121, 0.093)], rate_hz=RATE_HZ, duration_s=0.03, f_max_hz=F_MAX_HZ)


def recorded(plate, excitation, voltage_v, noise_db, rng):
    """Record each channel, with noise `noise_db` below its rms."""
    clean = np.array([np.convolve(voltage_v * excitation.samples, h) for h in plate.samples[0]])
    noise = (
        rng.standard_normal(clean.shape) * np.sqrt(np.mean(clean**2, axis=1, keepdims=True)) * 10 ** (noise_db / -20)
    )
    return clean + noise


@pytest.mark.parametrize("excitation", EXCITATIONS.values(), ids=EXCITATIONS)
def test_responses_learnt_at_40_db_focus_accurately(plate, excitation):
    heard = recorded(plate, excitation, 10.0, 40.0, np.random.default_rng(20261121))
    learned = learn(10.0 * excitation.samples, heard, RATE_HZ, duration_s=DURATION_S)
    true = Responses(plate.samples[:, :, : learned.n_samples], RATE_HZ)
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
    excitation = sweep(20e3, 40e3, rate_hz=RATE_HZ, duration_s=0.05)
    heard = recorded(plate, excitation, 10.0, 40.0, np.random.default_rng(5))
    sizes = [
        np.abs(learn(10.0 * excitation.samples, heard, RATE_HZ, duration_s=DURATION_S, regularisation=r).samples).max()
        for r in (0.0, 1e-4)
    ]
    assert sizes[0] > 10 * np.abs(plate.samples).max()
    assert sizes[1] < 2 * np.abs(plate.samples).max()


def test_sweep_fills_its_band_between_zero_ends():
    excitation = sweep(15e3, 45e3, rate_hz=RATE_HZ, duration_s=0.1)
    power = np.square(np.abs(np.fft.rfft(excitation.samples)))
    frequency_hz = np.fft.rfftfreq(len(excitation.samples), 1 / RATE_HZ)
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
