"""Figures of merit, energy, consumption and sound on fields and signals whose answer is known."""

import math

import numpy as np
import pytest

from tactometry.errors import InvalidParameter
from tactometry.signal import Signal
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.focusing.focusing import Emission, drive, focus_amplitude
from tactometry.stimuli.time_reversal.focusing.merit import (
    amplitude_by_subset_m,
    amplitude_over_count_m,
    area_m2,
    contrast_whole_of,
    contributions_m,
    dielectric_power_w,
    modal_amplitudes,
    switched_power_w,
    temporal_width_s,
    uniformity,
    width_m,
)
from tactometry.stimuli.time_reversal.focusing.one_bit import OneBit
from tactometry.stimuli.time_reversal.focusing.sigma_delta import SigmaDelta
from tactometry.stimuli.time_reversal.focusing.sound import (
    NoiseSpectrum,
    a_weighting_db,
    coincidence_frequency_hz,
    noise,
    radiation_efficiency,
    velocity_spectrum,
)
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN, BOROFLOAT_33
from tactometry.stimuli.time_reversal.responses.responses import impulse_responses, inaudible
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE, Screen
from tactometry.stimuli.time_reversal.screen.transducer import PointForce, capacitance_f

X = np.linspace(-0.05, 0.05, 401)
SIGMA = 6e-3


def gaussian_field() -> np.ndarray:
    return -3e-6 * np.exp(-(X[:, None] ** 2 + X[None, :] ** 2) / (2 * SIGMA**2))


def test_widths_of_a_gaussian():
    line = gaussian_field()[:, 200]
    assert width_m(X, line) == pytest.approx(2 * SIGMA * math.sqrt(2 * math.log(2)), rel=1e-3)
    assert width_m(X, line, math.sqrt(0.5)) == pytest.approx(2 * SIGMA * math.sqrt(math.log(2)), rel=1e-3)


def test_area_of_a_gaussian_matches_closed_form():
    expected = math.pi * 2 * SIGMA**2 * math.log(2)
    assert area_m2(gaussian_field(), (X, X)) == pytest.approx(expected, rel=0.02)


def test_area_counts_connected_cells_only():
    x, y = np.arange(5) * 1e-3, np.arange(7) * 3e-3
    field = np.zeros((5, 7))
    field[1:3, 1:4] = -1.0
    field[4, 6] = -1.0
    assert area_m2(field, (x, y)) == pytest.approx(6 * 1e-3 * 3e-3)


def test_contrast_of_a_negative_focus_is_positive():
    field = np.array([[3.0, -4.0]])
    assert contrast_whole_of(-10.0, field) == pytest.approx(10 / math.sqrt(12.5))


def test_temporal_width_of_a_gated_tone():
    rate, spread = 1e6, 50e-6
    t = (np.arange(4001) - 2000) / rate
    tone = np.exp(-(t**2) / (2 * spread**2)) * np.cos(2 * np.pi * 40e3 * t)
    assert temporal_width_s(tone, rate) == pytest.approx(2 * spread * math.sqrt(2 * math.log(2)), rel=5e-3)


def test_uniformity():
    assert uniformity(np.array([2.0, 2.0, 2.0])) == 1.0
    assert uniformity(np.array([1.0, 3.0])) == pytest.approx(1 - math.sqrt(2) / 2)


def kinetic_energy_j(screen, signal, sample, f_max_hz):
    """Half the sum of M q_n'^2."""
    return 0.5 * screen.plate.mass_kg * np.sum(modal_amplitudes(screen, signal, sample, f_max_hz, "velocity") ** 2)


def test_switched_power_is_half_c_swing_squared_per_transition():
    signal = Signal(np.array([[30.0, -30.0, -30.0, 30.0, 30.0]]), 1e5, "V")
    expected = 2 * 0.5 * 5e-9 * 60.0**2 * 1e5 / 4
    assert switched_power_w(signal, 5e-9) == pytest.approx(expected)


def sine(rate_hz):
    return Signal(30.0 * np.sin(2 * np.pi * 5e3 * np.arange(round(rate_hz * 4e-3)) / rate_hz)[None], rate_hz, "V")


@pytest.mark.parametrize("rate_hz", [50e3, 100e3, 200e3, 400e3])
def test_sine_dielectric_loss_is_independent_of_rate(rate_hz):
    """Heat of pi / 4 f C Upp^2 tan(delta), as makers of actuators give it for a sine of Upp."""
    expected = math.pi / 4 * 5e3 * 5e-9 * 60.0**2 * 0.017
    assert dielectric_power_w(sine(rate_hz), 5e-9, 0.017) == pytest.approx(expected, rel=1e-9)


def test_dielectric_loss_is_the_integral_of_in_phase_current():
    """Two components and two channels: the mean of u i over a period."""
    rate_hz, tangent = 200e3, 0.05
    t = np.arange(2000) / rate_hz
    tones = [(12.0, 3e3), (7.0, 11e3)]
    volts = sum(a * np.cos(2 * np.pi * f * t) for a, f in tones)
    in_phase = sum(2 * np.pi * f * 5e-9 * tangent * a * np.cos(2 * np.pi * f * t) for a, f in tones)
    found = dielectric_power_w(Signal(np.stack([volts, -2 * volts]), rate_hz, "V"), 5e-9, tangent)
    assert found == pytest.approx(5 * np.mean(volts * in_phase), rel=1e-9)


def test_sigma_delta_costs_an_order_of_magnitude_more_than_one_bit():
    raw = impulse_responses(A4_PROTOTYPE, [(0.12, 0.09)], rate_hz=1e6, duration_s=4e-3, f_max_hz=60e3)
    h = inaudible(raw)
    one_bit, sdm = (switched_power_w(drive(h, 30.0, q), 5e-9) for q in (OneBit(), SigmaDelta(2)))
    assert 7 < sdm / one_bit < 13


def test_capacitance():
    assert capacitance_f(1e-4, 0.3e-3, 1800.0) == pytest.approx(5.31e-9, rel=1e-3)


A_TABLE = {20: -50.4, 31.5: -39.5, 100: -19.1, 200: -10.8, 500: -3.2, 1e3: 0.0, 2e3: 1.2, 2.5e3: 1.3, 4e3: 1.0}
A_TABLE |= {8e3: -1.1, 10e3: -2.5, 16e3: -6.7, 20e3: -9.3}


@pytest.mark.parametrize("frequency_hz", A_TABLE)
def test_a_weighting_table(frequency_hz):
    assert a_weighting_db(frequency_hz)[0] == pytest.approx(A_TABLE[frequency_hz], abs=0.1)


def test_a_weighting_is_silent_outside_audible_range():
    assert list(a_weighting_db([0.0, 20.1e3])) == [-np.inf, -np.inf]


def test_coincidence_frequencies():
    for thickness, expected in ((0.5e-3, 23.7), (1.1e-3, 10.8), (2e-3, 5.9), (3e-3, 4.0)):
        plate = BOROFLOAT_33.plate(0.297, 0.21, thickness, "SSSS")
        assert coincidence_frequency_hz(plate) / 1e3 == pytest.approx(expected, abs=0.06)


def test_one_khz_tone_has_equal_a_weighted_level():
    f = np.arange(0.0, 25e3, 10.0)
    power = np.zeros(f.size)
    power[100] = 1.0 / 10.0
    assert NoiseSpectrum(f, power).a_weighted_db == pytest.approx(93.98, abs=0.01)


def test_velocity_spectrum_is_the_time_integral_of_the_velocity():
    screen = Screen(A4_SCREEN, (PointForce(0.08, 0.13),), Attenuation(2e-3))
    rng = np.random.default_rng()
    smooth = np.convolve(rng.normal(size=2000), np.hanning(40), "same")[None]
    signal = Signal(smooth, 100e3, "V")
    f, energy = velocity_spectrum(screen, signal, 5e3)
    direct = sum(2 * kinetic_energy_j(screen, signal, k, 5e3) / A4_SCREEN.mass_kg for k in range(0, 3200, 16)) * (
        16 / 100e3
    )
    assert np.sum(energy) * (f[1] - f[0]) == pytest.approx(direct, rel=0.03)


def radiated_by_a_mode(plate, m, n, frequency_hz):
    """Efficiency of one mode in a baffle, its wavenumber spectrum integrated over the hemisphere (Wallace 1972)."""
    k = 2 * np.pi * frequency_hz / 343.0
    nodes, weights = np.polynomial.legendre.leggauss(160)
    angle, weight = (nodes + 1) * np.pi / 4, weights * np.pi / 4
    from_normal, round_it = np.meshgrid(angle, angle, indexing="ij")

    def spectrum(q, side_m, order):
        own = order * np.pi / side_m
        return own**2 * 2 * (1 - (-1) ** order * np.cos(q * side_m)) / (q**2 - own**2) ** 2

    along_x = spectrum(k * np.sin(from_normal) * np.cos(round_it), plate.length_m, m)
    along_y = spectrum(k * np.sin(from_normal) * np.sin(round_it), plate.width_m, n)
    whole = 4 * np.einsum("i,j,ij", weight, weight, along_x * along_y * np.sin(from_normal))
    return k**2 / np.pi**2 * whole / plate.area_m2


def modes_near(plate, frequency_hz, half_width_hz):
    """Orders and frequencies of the modes of simply supported edges that lie near."""
    m, n = np.meshgrid(np.arange(1, 60), np.arange(1, 45), indexing="ij")
    wavenumber_2 = (m * np.pi / plate.length_m) ** 2 + (n * np.pi / plate.width_m) ** 2
    own_hz = plate.wave_constant_m2_per_s * wavenumber_2 / (2 * np.pi)
    near = np.abs(own_hz - frequency_hz) < half_width_hz
    return list(zip(m[near], n[near], own_hz[near], strict=True))


@pytest.mark.parametrize("of_coincidence", [0.25, 0.4, 0.6, 0.8, 0.9, 0.96, 1.05, 1.2, 1.6])
def test_plate_radiation_matches_mean_over_its_modes(of_coincidence):
    """To a quarter: some tens of modes scatter round the law of many."""
    f_c = coincidence_frequency_hz(A4_SCREEN)
    near = modes_near(A4_SCREEN, of_coincidence * f_c, 0.02 * f_c if 0.85 < of_coincidence < 1.1 else 0.05 * f_c)
    mean, law = (
        np.mean(values)
        for values in zip(
            *((radiated_by_a_mode(A4_SCREEN, *mode), radiation_efficiency(A4_SCREEN, mode[2])) for mode in near),
            strict=True,
        )
    )
    assert law == pytest.approx(mean, rel=0.25)


def test_the_efficiency_of_radiation_has_no_step():
    f = coincidence_frequency_hz(A4_SCREEN) * np.linspace(0.5, 1.5, 20001)
    level_db = 10 * np.log10(radiation_efficiency(A4_SCREEN, f))
    assert np.abs(np.diff(level_db)).max() < 0.01
    assert radiation_efficiency(A4_SCREEN, [0.0, 1e9]) == pytest.approx([0, 1], rel=1e-5)


def test_sound_is_the_radiated_power_over_a_hemisphere():
    """W = rho c S sigma <v^2>, p^2 = W rho c / (2 pi r^2), averaged over the drive and five tau."""
    screen = Screen(A4_SCREEN, (PointForce(0.08, 0.13),), Attenuation(2e-3))
    signal = Signal(np.hanning(60)[None], 50e3, "V")
    found = noise(screen, signal, 20e3, distance_m=0.5)
    f, energy = velocity_spectrum(screen, signal, 20e3)
    watt = 1.204 * 343 * A4_SCREEN.area_m2 * radiation_efficiency(A4_SCREEN, f) * energy / (60 / 50e3 + 5 * 2e-3)
    assert found.pressure_pa2_per_hz == pytest.approx(watt * 1.204 * 343 / (2 * math.pi * 0.5**2))
    assert noise(screen, signal, 20e3, distance_m=1.0).a_weighted_db == pytest.approx(
        found.a_weighted_db - 6.02, abs=0.01
    )


SMALL = Emission(Band(500.0, 12e3), 4e-3, 50e3)
FOCI = [(x, 0.045) for x in (0.05, 0.1, 0.15, 0.2)]


def test_contributions_add_up_to_the_focus():
    h = SMALL.responses(A4_PROTOTYPE, FOCI[:3])
    contributions = contributions_m(h, 30.0)
    for i in range(3):
        assert contributions[i].sum() == pytest.approx(focus_amplitude(drive(h.at_point(i), 30.0), h, i), rel=1e-12)


def test_amplitude_grows_with_each_transducer_to_the_same_end():
    contributions = np.random.default_rng().uniform(0.5, 1.5, (4, 8))
    grown = amplitude_over_count_m(contributions, np.random.default_rng(), 5)
    assert np.all(np.diff(grown, axis=2) > 0)
    assert grown[:, :, -1] == pytest.approx(np.broadcast_to(contributions.sum(axis=1), (5, 4)))


def test_transducers_are_added_in_different_orders():
    contributions = np.arange(1.0, 9.0)[None]
    grown = amplitude_over_count_m(contributions, np.random.default_rng(), 60)
    assert len(set(grown[:, 0, 0])) > 3
    assert set(grown[:, 0, 0]) <= set(contributions[0])


def test_subsets():
    contributions = np.arange(6.0).reshape(2, 3)
    found = amplitude_by_subset_m(contributions, {"ends": [0, 2], "all": range(3)})
    assert list(found["ends"]) == [2.0, 8.0]
    with pytest.raises(InvalidParameter, match=r"subsets\['none'\]: found \[3\], expected channels from 0 to 2"):
        amplitude_by_subset_m(contributions, {"none": [3]})
