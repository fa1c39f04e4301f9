"""Sampling limits of pulses, textures and force components."""

import numpy as np
import pytest
from hard_cases import hard_case
from hypothesis import example, given, strategies as st

from tactometry.errors import InvalidParameter
from tactometry.stimuli.electrovibration import PulseTrain, Square, Step, Trapezoid
from tactometry.stimuli.electrovibration.textures.followed_texture import finest_period_m
from tactometry.stimuli.electrovibration.textures.texture import Bump, Grating, Noise, Region, Texture
from tactometry.stimuli.electrovibration.waveforms.sampled import Sampled

RATE_HZ = 1000.0
LINE_S = st.one_of(st.just(0.0), st.floats(1e-12, 4e-3))


@given(rise_s=LINE_S, high_s=LINE_S, fall_s=LINE_S, low_s=LINE_S, low_ratio=st.sampled_from([0.0, -1.0]))
def test_trapezoid_samples_cross_its_middle_both_ways(
    rise_s: float, high_s: float, fall_s: float, low_s: float, low_ratio: float
) -> None:
    edges_s = (rise_s + fall_s) / 2
    lines = {"rise_s": rise_s, "high_s": high_s, "fall_s": fall_s, "low_s": low_s}
    if min(high_s, low_s) + edges_s < 0.99e-3:
        with pytest.raises(InvalidParameter):
            Trapezoid(**lines, low_ratio=low_ratio, rate_hz=RATE_HZ)
    elif min(high_s, low_s) + edges_s > 1.01e-3:
        samples = Trapezoid(**lines, low_ratio=low_ratio, rate_hz=RATE_HZ).at(0.0).samples[0]
        middle = (1 + low_ratio) / 2
        assert samples.max() >= middle - 1e-9
        assert samples.min() <= middle + 1e-9
        if max(rise_s, fall_s) == 0:
            assert (samples.max(), samples.min()) == (1.0, low_ratio)


@given(onset_s=LINE_S, rise_s=LINE_S, fall_s=LINE_S, rest_s=st.floats(1e-9, 4e-3))
@example(onset_s=0.0, rise_s=0.0, fall_s=1.6e-3, rest_s=1e-6)
def test_the_samples_of_a_step_reach_its_half(onset_s: float, rise_s: float, fall_s: float, rest_s: float) -> None:
    times = {"onset_s": onset_s, "rise_s": rise_s, "fall_s": fall_s}
    times["duration_s"] = sum(times.values()) + rest_s
    width_s = rest_s + (rise_s + fall_s) / 2
    if width_s < 0.99e-3:
        with pytest.raises(InvalidParameter):
            Step(**times, rate_hz=RATE_HZ)
    elif width_s > 1.51e-3:
        assert Step(**times, rate_hz=RATE_HZ).at(0.0).samples.max() >= 0.5 - 1e-9


def test_short_pulse_needs_band_limit_or_higher_rate() -> None:
    lines = {"rise_s": 0.0, "high_s": 1e-5, "fall_s": 0.0, "low_s": 3.99e-3}
    assert Trapezoid(**lines, rate_hz=200_000.0).at(0.0).peak == 1.0
    mean = Trapezoid(**lines, band_limited=True).at(0.0).samples.mean()
    assert mean == pytest.approx(1e-5 / 4e-3, rel=1e-9)


@pytest.mark.parametrize("polarity", ["positive", "negative", "biphasic", "alternating"])
def test_pulses_may_follow_each_other_without_a_pause(polarity: str) -> None:
    longest_s = 1 / 200 if polarity == "biphasic" else 1 / 100
    samples = PulseTrain(frequency_hz=100.0, width_s=longest_s, ramp_s=0.0, polarity=polarity).at(0.0).samples
    assert np.all(np.abs(samples) == 1.0)


@pytest.mark.parametrize("frequency_hz", [30.0, 2400.0, 5100.0, 9900.0])
@pytest.mark.parametrize("n", [20_000, 20_001])
def test_sampled_tone_force_has_twice_its_frequency(frequency_hz: float, n: int) -> None:
    tone = Sampled(tuple(np.sin(2 * np.pi * frequency_hz * np.arange(n) / 20_000)), rate_hz=20_000.0)
    assert tone.voltage_frequency_hz == pytest.approx(frequency_hz, abs=0.5)
    assert tone.force_frequency_hz == pytest.approx(2 * frequency_hz, abs=1.0)


@given(
    texture=st.sampled_from([Grating(1e-3, duty=0.1), Grating(1e-3, duty=0.8), Region(0.0, 1e-3), Bump(0.0, 1e-3)]),
    share=st.floats(0.01, 0.999),
    start=st.floats(0, 1),
)
def test_positions_within_guard_sample_whole_texture(texture: Texture, share: float, start: float) -> None:
    step_m = share * (finest_period_m(texture) or 0.0) / 2
    found = texture.force_share(np.arange(-10e-3 - start * step_m, 10e-3, step_m))
    assert found.max() > 0.85
    assert found.min() < 0.15


@pytest.mark.parametrize("n_rms", [10.0, 40.0])
def test_noise_texture_has_requested_rms(n_rms: float) -> None:
    drawn = Noise.drawn(100.0, 1000.0, 0.1, rng=np.random.default_rng(5))
    noise = Noise(100.0, 1000.0, 0.1, drawn.phases_rad, n_rms=n_rms)
    share = noise.force_share(np.arange(1000) * 1e-4)
    assert share.std() == pytest.approx(1 / (2 * n_rms), rel=1e-9)
    assert share.mean() == pytest.approx(0.5, rel=1e-9)


@pytest.mark.parametrize("exponent", [400.0, -400.0, 1e30, -1e30])
def test_noise_of_an_extreme_exponent_is_its_strongest_line(exponent: float) -> None:
    noise = Noise.drawn(100.0, 1000.0, 0.1, rng=np.random.default_rng(5), exponent=exponent)
    power = np.abs(np.fft.rfft(noise.height(np.arange(1000) * 1e-4)))
    assert np.argmax(power) == (100 if exponent > 0 else 10)
    assert noise.height(np.arange(1000) * 1e-4).std() == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize("n_highest", [0, 1, 2, 33, 700])
def test_a_band_limited_polygon_is_its_fourier_series(n_highest: int) -> None:
    corners = Trapezoid(rise_s=0.001, high_s=0.003, fall_s=0.0, low_s=0.002, low_ratio=-0.2).corners
    phase = np.r_[0.0, 1.0, np.random.default_rng(1).uniform(-3, 3, 500)]
    n = np.arange(1, n_highest + 1)
    series = corners.mean + 2 * (np.exp(2j * np.pi * np.multiply.outer(phase, n)) @ corners.harmonics(n)).real
    found = corners.band_limited(phase, n_highest)
    scale = found[0] / series[0]
    assert 0.8 < scale <= 1 + 1e-9
    np.testing.assert_allclose(corners.band_limited(phase[:1], n_highest), found[:1], rtol=1e-3)
    hard_case("700 harmonics of a polygon", found, scale * series, 1e-11, against="Fourier series", floor=1)


def test_slow_band_limited_square_matches_its_series() -> None:
    square = Square(frequency_hz=0.3003, duration_s=0.5, ramp_s=0.0, rate_hz=192_000.0, band_limited=True)
    samples, n = square.at(0.0).samples[0], np.arange(1, 319_681)
    where = np.array([0, 1, 2, 40_000, 95_999])
    turns = np.multiply.outer(np.mod(0.3003 * where / 192_000, 1.0), n)
    series = 2 * (np.exp(2j * np.pi * turns) @ square.corners.harmonics(n)).real
    scaled = samples[where] * (series[3] / samples[40_000])
    hard_case("319 680 harmonics of a square", scaled, series, 1e-9, against="Fourier series", floor=1)


def test_noise_in_chunks_is_noise_at_once() -> None:
    noise = Noise.drawn(10.0, 10_000.0, 0.1, rng=np.random.default_rng(5))
    x_m = np.linspace(-0.2, 0.2, 6000).reshape(2, 3000)
    found = noise.height(x_m)
    assert found.shape == (2, 3000)
    np.testing.assert_allclose(found[1, ::500], noise.height(x_m[1, ::500]), atol=1e-9)
    assert noise.height(0.0).shape == ()
    assert noise.height([]).shape == (0,)
