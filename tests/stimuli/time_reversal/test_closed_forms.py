"""Focus theory: its own numbers, and comparison with simulation."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.special import j0

from tactometry.stimuli.time_reversal.design.closed_forms import (
    Reverberation,
    analogue_amplitude_ratio,
    contrast_limit,
    contrast_whole,
    focus_profile,
    half_wavelength_m,
    one_bit_amplitude_ratio,
    repetition_amplitude_ratio,
    repetition_noise_ratio,
    resolution_m,
)
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.focusing.focusing import drive, emitted, focus_amplitude
from tactometry.stimuli.time_reversal.focusing.one_bit import OneBit
from tactometry.stimuli.time_reversal.focusing.pattern import Pattern, focus_samples, pattern_drive
from tactometry.stimuli.time_reversal.focusing.quantiser import Analogue
from tactometry.stimuli.time_reversal.plate.dispersion import wavelength_m
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN, BOROFLOAT_33, D263T
from tactometry.stimuli.time_reversal.responses.responses import band_limited, impulse_responses
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.screen import Screen
from tactometry.stimuli.time_reversal.screen.transducer import border

RATE_HZ, TAU_S, T_S = 100e3, 3e-3, 6e-3
FOCI = [(0.121, 0.093), (0.187, 0.067), (0.081, 0.141)]


def a4(n_channels: int) -> Screen:
    return Screen(A4_SCREEN, tuple(border(A4_SCREEN, n_channels)), Attenuation(TAU_S))


def test_amplitude_ratios_at_twice_tau():
    assert one_bit_amplitude_ratio(2.0, 1.0) == pytest.approx(0.865, abs=5e-4)
    assert analogue_amplitude_ratio(2.0, 1.0) == pytest.approx(0.982, abs=5e-4)


def test_contrast_of_the_worked_example():
    example = Reverberation(32, 25e3, 3e-3, 6e-3, 17.96e-3)
    assert example.absorption == pytest.approx(3.10, abs=0.01)
    assert contrast_whole(example) == pytest.approx(19.7, abs=0.05)
    assert contrast_limit(example) == pytest.approx(21.2, abs=0.05)


def test_contrast_limits():
    """Absorption limited: C^2 = 2 B Q tau tanh(T / tau); mode limited: sqrt(N)."""
    few = Reverberation(1, 25e3, 1e-5, 2e-5, 17.96e-3)
    assert contrast_whole(few) ** 2 == pytest.approx(2 * 25e3 * 1e-5 * math.tanh(2.0), rel=0.01)
    many = Reverberation(10**9, 25e3, 3e-3, 6e-3, 17.96e-3)
    assert contrast_whole(many) == pytest.approx(math.sqrt(many.n_modes), rel=1e-6)


def test_single_frequency_focus_is_bessel_j0_with_its_widths():
    f = 12.5e3
    narrow = Band(f * (1 - 1e-7), f * (1 + 1e-7))
    wavelength = float(wavelength_m(A4_SCREEN, f))
    r = np.linspace(0, 0.05, 30)
    assert focus_profile(A4_SCREEN, narrow, r) == pytest.approx(j0(2 * np.pi * r / wavelength), abs=2e-8)
    assert resolution_m(A4_SCREEN, narrow) / wavelength == pytest.approx(0.4842, abs=1e-4)
    assert resolution_m(A4_SCREEN, narrow, math.sqrt(0.5)) / wavelength == pytest.approx(0.3585, abs=3e-4)


def test_band_from_zero_is_the_airy_function_with_its_widths():
    wavelength = float(wavelength_m(A4_SCREEN, 25e3))
    assert resolution_m(A4_SCREEN, Band(0.0, 25e3)) / wavelength == pytest.approx(0.7051, abs=1e-4)
    assert resolution_m(A4_SCREEN, Band(0.0, 25e3), math.sqrt(0.5)) / wavelength == pytest.approx(0.5145, abs=3e-4)
    assert focus_profile(A4_SCREEN, Band(0.0, 25e3), 0.0) == 1.0


@pytest.mark.parametrize(
    ("thickness_m", "band", "expected_mm"),
    [
        (1.1e-3, Band(0, 25e3), 14.7),
        (1.1e-3, Band(0, 60e3), 9.5),
        (1.1e-3, Band(20e3, 60e3), 8.1),
        (1.1e-3, Band(20e3, 100e3), 6.6),
        (2e-3, Band(0, 25e3), 19.9),
        (3e-3, Band(0, 25e3), 24.3),
    ],
)
def test_resolution_table(thickness_m, band, expected_mm):
    plate = BOROFLOAT_33.plate(0.297, 0.21, thickness_m, "SSSS")
    assert resolution_m(plate, band) * 1e3 == pytest.approx(expected_mm, abs=0.06)


@given(st.floats(0.0, 0.999))
def test_the_handy_law_is_a_little_above_the_resolution(share):
    """0.3 to 3.3 %, by how the ends of the band are apart."""
    band = Band(60e3 * share, 60e3)
    assert 1.0028 < float(half_wavelength_m(A4_SCREEN, band.mean_hz)) / resolution_m(A4_SCREEN, band) < 1.0327


def test_hudin_2015_resolution_and_area():
    """148 x 210 x 0.5 mm glass, 20-70 kHz (band from memory): published 5.2 mm and 20 mm^2."""
    plate = D263T.plate(0.210, 0.148, 0.5e-3, "FFFF")
    width = resolution_m(plate, Band(20e3, 70e3))
    assert width * 1e3 == pytest.approx(5.15, abs=0.01)
    assert math.pi * width**2 / 4 * 1e6 == pytest.approx(20.8, abs=0.1)


REPETITION = {10e-3: 1.0, 5e-3: 0.93, 3.3e-3: 0.79, 2e-3: 0.66, 1e-3: 0.47}


@pytest.mark.parametrize("repetition_s", REPETITION)
def test_repetition_penalty_of_the_notes(repetition_s):
    """T = 6 ms, tau = 3 ms, 1 bit: simulated values of another program."""
    assert repetition_amplitude_ratio(6e-3, repetition_s, 3e-3) == pytest.approx(REPETITION[repetition_s], abs=0.04)


@pytest.mark.parametrize("around_s", [4e-3, 2e-3])
def test_repetition_penalty_meets_the_simulation(around_s):
    """Mean over repetition times: at each one all foci share the chance correlation of the modes at that lag."""
    h = impulse_responses(a4(32), FOCI[:1], rate_hz=RATE_HZ, duration_s=T_S, f_max_hz=25e3)
    alone = focus_amplitude(drive(h, 1.0), h)
    relative = []
    for repetition_s in around_s * np.linspace(0.9, 1.1, 8):
        train = Pattern(1 / repetition_s, 60e-3)
        u = emitted(pattern_drive(h, train, 1.0), h)[0][focus_samples(train, RATE_HZ, h.n_samples)]
        steady = np.mean(u[len(u) // 4 : -len(u) // 4]) / alone
        relative.append(steady / repetition_amplitude_ratio(T_S, repetition_s, TAU_S))
    assert np.mean(relative) == pytest.approx(1.0, abs=0.07)


@pytest.mark.parametrize(
    ("tau_s", "ratio", "band", "common", "each"),
    [
        (1e-3, 1.0, Band(1e3, 10e3), (2.8, 4.0), (1.9, 2.4)),
        (3.5e-3, 2.0, Band(20e3, 60e3), (4.7, 7.2), (3.6, 4.3)),
        (8e-3, 4.0, Band(20e3, 60e3), (6.0, 13.0), (4.6, 5.4)),
    ],
)
def test_one_bit_gain_over_analogue_is_within_bounds(tau_s, ratio, band, common, each):
    """The ends of what is simulated, and the prototype; one gain for all channels, and one for each."""
    screen = Screen(A4_SCREEN, tuple(border(A4_SCREEN, 32)), Attenuation(tau_s))
    h = band_limited(impulse_responses(screen, FOCI, rate_hz=240e3, duration_s=ratio * tau_s, f_max_hz=66e3), band)
    one_bit, together, apart = (
        np.mean([focus_amplitude(drive(h.at_point(i), 1.0, q), h, i) for i in range(len(FOCI))])
        for q in (OneBit(), Analogue(), Analogue(per_channel=True))
    )
    assert common[0] < one_bit / together < common[1]
    assert each[0] < one_bit / apart < each[1]


def test_repetition_noise():
    assert repetition_noise_ratio(np.inf, 3e-3) == 1.0
    assert repetition_noise_ratio(3e-3, 3e-3) == pytest.approx(1 / (1 - math.exp(-2)))


@pytest.mark.parametrize("level", [1e-3, 0.1, 0.5, 0.999])
@pytest.mark.parametrize("band", [Band(0.0, 25e3), Band(20e3, 20.1e3)], ids=["wide", "narrow"])
def test_every_level_below_the_peak_has_a_width(band, level):
    width = resolution_m(A4_SCREEN, band, level)
    assert focus_profile(A4_SCREEN, band, width / 2) == pytest.approx(level, abs=1e-9)


def test_long_train_penalty_is_finite_at_any_ratio():
    """T of 1e6 tau is as good as endless, and its exponentials do not overflow."""
    endless = repetition_amplitude_ratio(1.0, 1e-3, 1e-3)
    assert repetition_amplitude_ratio(1e3, 1e-3, 1e-3) == pytest.approx(endless, rel=1e-9)
    assert repetition_amplitude_ratio(1e-3, 1e9, 1e-9) == 1.0
