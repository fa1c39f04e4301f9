"""Driving signals: one bit, sigma-delta, pulse width; what theory says of their spectra, and overload."""

import math

import numpy as np
import pytest
from hard_cases import exact_case, hard_case
from hypothesis import given, strategies as st

from tactometry.errors import LimitExceeded
from tactometry.stimuli.time_reversal.focusing.modulator import modulate
from tactometry.stimuli.time_reversal.focusing.one_bit import OneBit
from tactometry.stimuli.time_reversal.focusing.pulse_width import PulseWidth
from tactometry.stimuli.time_reversal.focusing.quantiser import Analogue
from tactometry.stimuli.time_reversal.focusing.sigma_delta import SigmaDelta

N = 1 << 16


def noise(u: np.ndarray, order: int) -> np.ndarray:
    """Power spectrum of what the modulator adds, mean over channels."""
    added = (modulate(u, order).bits - u) * np.hanning(u.shape[1])
    return np.mean(np.abs(np.fft.rfft(added)) ** 2, axis=0)


def busy(n_channels: int) -> np.ndarray:
    """Noise, so that the modulator neither idles nor makes tones."""
    return np.random.default_rng().uniform(-0.6, 0.6, (n_channels, N))


@pytest.mark.parametrize(("order", "slope_db"), [(1, 9.0), (2, 15.0)])
def test_in_band_noise_falls_with_oversampling(order, slope_db):
    power = noise(busy(16), order)
    in_band = [power[1 : N // 2 // osr].sum() for osr in (32, 64, 128)]
    falls = 10 * np.log10(np.array(in_band[:-1]) / in_band[1:])
    assert falls == pytest.approx([slope_db, slope_db], abs=2.0)


@pytest.mark.parametrize("order", [1, 2])
def test_noise_is_shaped_as_the_noise_transfer_function(order):
    """|NTF| = (2 sin(pi f / fs))^L with a white error: the same within 3 dB from band to band."""
    power = noise(busy(32), order)
    f = np.arange(power.size) / N
    error_power = []
    for low, high in ((0.01, 0.02), (0.03, 0.06), (0.1, 0.2)):
        part = (f >= low) & (f < high)
        error_power.append(np.sum(power[part]) / np.sum((2 * np.sin(np.pi * f[part])) ** (2 * order)))
    assert 10 * math.log10(max(error_power) / min(error_power)) < 3.0


@pytest.mark.parametrize("order", [1, 2])
def test_bits_carry_the_mean_of_the_signal(order):
    u = np.full((1, 20000), 0.3)
    assert modulate(u, order).bits.mean() == pytest.approx(0.3, abs=1e-3)


def test_first_order_is_sound_up_to_full_scale():
    stream = modulate(np.random.default_rng(2).choice([-1.0, 1.0], (4, 20000)), 1)
    assert stream.peak_state <= 2.0
    assert not stream.overloaded


def test_second_order_overload_is_refused_at_full_scale():
    sine = np.sin(2 * np.pi * 0.002 * np.arange(20000))[None]
    assert modulate(sine, 2).overloaded
    with pytest.raises(LimitExceeded, match=r"overloads; lower scale .* nothing is emitted"):
        SigmaDelta(order=2, scale=1.0).quantise(sine, 1e6)


@pytest.mark.parametrize(("period", "sound"), [(100, True), (20, True), (17, False)])
def test_second_order_overloads_on_fast_sine_only(period, sound):
    sine = 0.7 * np.sin(2 * np.pi * np.arange(20_000) / period)
    assert modulate(sine[None], 2).overloaded != sound


def test_second_order_reports_divergence_on_large_dc():
    stream = modulate(np.full((1, 100_000), 1.01), 2)
    assert stream.overloaded
    assert stream.peak_state > 1e6
    exact_case("sigma-delta on a constant of 1.01", against="overload said")


@given(st.integers(0, 2**32 - 1), st.floats(1e-9, 0.7))
def test_second_order_stays_sound_up_to_0_7(seed, peak):
    u = np.random.default_rng(seed).uniform(-peak, peak, (2, 2000))
    assert not modulate(u, 2).overloaded
    exact_case("sigma-delta up to 0.7", against="bounded state")


@pytest.mark.parametrize("order", [1, 2])
def test_tiny_sigma_delta_input_is_finite_without_mean(order):
    stream = modulate(1e-9 * np.sin(0.01 * np.arange(20000))[None], order)
    assert set(np.unique(stream.bits)) == {-1.0, 1.0}
    assert not stream.overloaded
    hard_case("sigma-delta of 1e-9", stream.bits.mean(), 0, 1e-3, against="no mean", floor=1)


def test_rice_transition_rates():
    """Flat Gaussian noise in a band: 29.5 k/s for 1-25 kHz and 83.3 k/s for 20-60 kHz within 3 %."""
    rate, n = 1e6, 1 << 20
    f = np.fft.rfftfreq(n, 1 / rate)
    for low, high, expected in ((1e3, 25e3, 29.5e3), (20e3, 60e3, 83.3e3)):
        rng = np.random.default_rng()
        spectrum = np.where((f >= low) & (f <= high), rng.normal(size=f.size) + 1j * rng.normal(size=f.size), 0)
        bits = OneBit().quantise(np.fft.irfft(spectrum)[None], rate)
        changes = np.count_nonzero(np.diff(bits[0]))
        assert changes * rate / (n - 1) == pytest.approx(expected, rel=0.03)


def test_zero_is_plus_one():
    assert OneBit().quantise(np.array([[0.0, -0.0, -1e-300]]), 1.0).tolist() == [[1.0, 1.0, -1.0]]


def test_pulse_width_has_carrier_line_unlike_sigma_delta():
    rate, n = 1e6, 1 << 14
    sine = np.sin(2 * np.pi * 3e3 * np.arange(n) / rate)[None]
    spectra = {
        name: np.abs(np.fft.rfft(q.quantise(sine, rate)[0] * np.hanning(n))) / n * 4
        for name, q in (("pwm", PulseWidth(100e3, 0.5)), ("sdm", SigmaDelta(2, 0.5)))
    }
    f = np.fft.rfftfreq(n, 1 / rate)
    around = np.abs(f - 100e3) < 2e3
    assert spectra["pwm"][around].max() > 0.5
    assert spectra["sdm"][around].max() < 0.1
    tone = np.abs(f - 3e3) < 200
    for spectrum in spectra.values():
        assert spectrum[tone].max() == pytest.approx(0.5, rel=0.15), "a Hann window scallops by 15 %"


@pytest.mark.parametrize("share", [-0.6, 0.0, 0.3])
def test_pulse_width_duty_cycle_follows_waveform(share):
    """Over whole periods the mean is the waveform, to a sample at each edge."""
    wave = np.append(np.full(10_000, share), 1.0)[None]
    assert PulseWidth(1e3).quantise(wave, 1e5)[0, :-1].mean() == pytest.approx(share, abs=0.02)


def test_first_order_overloads_above_a_state_of_2():
    assert [modulate(np.full((1, n), 1.2), 1).overloaded for n in (5, 6)] == [False, True]


def test_analogue_gains():
    wave = np.array([[1.0, -2.0], [4.0, 0.0]])
    assert Analogue().quantise(wave, 1.0).tolist() == [[0.25, -0.5], [1.0, 0.0]]
    assert Analogue(per_channel=True).quantise(wave, 1.0).tolist() == [[0.5, -1.0], [1.0, 0.0]]
    assert not Analogue().quantise(np.zeros((2, 3)), 1.0).any()
