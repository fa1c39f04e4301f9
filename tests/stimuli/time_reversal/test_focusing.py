"""Focusing: the identities, several foci, windows, hard places, the field and the movie."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st
from hypothesis.extra.numpy import arrays

from tactometry.errors import InvalidParameter
from tactometry.signal import Signal
from tactometry.stimuli.time_reversal.filters import Band, Butterworth
from tactometry.stimuli.time_reversal.focusing.focusing import (
    drive,
    emitted,
    focus_amplitude,
    focus_amplitudes,
    reversed_waveform,
)
from tactometry.stimuli.time_reversal.focusing.merit import field, grid, modal_amplitudes, modal_history, movie
from tactometry.stimuli.time_reversal.focusing.one_bit import OneBit
from tactometry.stimuli.time_reversal.focusing.quantiser import Analogue
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN, BOROFLOAT_33
from tactometry.stimuli.time_reversal.plate.modes import modes_of
from tactometry.stimuli.time_reversal.responses.responses import (
    Responses,
    band_limited,
    impulse_responses,
    inaudible,
    through,
)
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE, Screen
from tactometry.stimuli.time_reversal.screen.transducer import PointForce

FOCUS = (0.12, 0.09)
F_MAX_HZ = 25e3
TIMING = {"rate_hz": 100e3, "duration_s": 8e-3, "f_max_hz": F_MAX_HZ}


@pytest.fixture(scope="module")
def learnt() -> Responses:
    return impulse_responses(A4_PROTOTYPE, [FOCUS, (0.2, 0.15), (0.05, 0.04)], **TIMING)


some_responses = arrays(float, (1, 3, 20), elements=st.floats(-1, 1, width=32)).filter(lambda h: bool(h.any()))


@given(some_responses)
def test_one_bit_focus_is_sum_of_absolute_responses(samples):
    h = Responses(samples, 1e3)
    found = focus_amplitude(drive(h, 30.0, OneBit()), h)
    assert found == pytest.approx(30.0 * np.abs(samples).sum(), rel=1e-13)


@given(some_responses)
def test_analogue_focus_is_proportional_to_response_energy(samples):
    h = Responses(samples, 1e3)
    found = focus_amplitude(drive(h, 30.0, Analogue()), h)
    gain = 1 / np.abs(samples).max()
    assert found == pytest.approx(30.0 * gain * (samples**2).sum(), rel=1e-12)


@given(some_responses, st.integers(0, 2**32 - 1))
def test_no_drive_within_the_voltage_beats_one_bit(samples, seed):
    h = Responses(samples, 1e3)
    other = np.random.default_rng(seed).uniform(-30, 30, (3, 20))
    assert focus_amplitude(Signal(other, 1e3, "V"), h) <= focus_amplitude(drive(h, 30.0), h) * (1 + 1e-12)


def test_focus_occurs_at_last_drive_sample(learnt):
    signal = drive(learnt.at_point(0), 30.0, reversal_s=6e-3)
    u = emitted(signal, learnt)
    assert np.argmax(np.abs(u[0])) == 599
    assert u[0, 599] == pytest.approx(focus_amplitude(signal, learnt), rel=1e-12)


def test_two_foci_have_their_weights_and_signs(learnt):
    two = Responses(learnt.samples[:2], learnt.rate_hz)
    signal = drive(two, 30.0, Analogue(), weights=[1.0, -0.5])
    u = focus_amplitudes(signal, two)
    alone = [np.sum(two.samples[i] ** 2) for i in (0, 1)]
    assert u[1] / u[0] == pytest.approx(-0.5 * alone[1] / alone[0], abs=0.1)


@pytest.mark.parametrize("n", [2, 8, 32])
@pytest.mark.parametrize("f_min_hz", [1e3, 10e3])
def test_foci_amplitude_falls_with_root_of_their_number(n, f_min_hz):
    """1 bit: the mean over 16 sets of foci at random is 1 to 12 % above the law."""
    rng, over = np.random.default_rng(), []
    for _ in range(16):
        places = [tuple(map(float, place)) for place in rng.uniform((0.06, 0.04), (0.24, 0.17), (n, 2))]
        raw = impulse_responses(A4_PROTOTYPE, places, rate_hz=100e3, duration_s=7e-3, f_max_hz=27e3)
        h = band_limited(raw, Band(f_min_hz, 25e3))
        alone = np.mean([focus_amplitude(drive(h.at_point(i), 30.0), h, i) for i in range(n)])
        over.append(np.mean(focus_amplitudes(drive(h, 30.0), h)) / alone * math.sqrt(n))
    error = 5.24 * np.std(over, ddof=1) / math.sqrt(16)  # Student's t with 15 degrees of freedom at 1e-4
    assert 1.0 - error < np.mean(over) < 1.12 + error


@pytest.mark.parametrize("duration_s", [1e-3, 8e-3])
@pytest.mark.parametrize(("tau_s", "exponent"), [(math.inf, 0.0), (3.5e-3, 0.0), (3.5e-3, 1.0)])
def test_unfiltered_one_bit_drive_ends_at_positive_voltage(duration_s, tau_s, exponent):
    """The response to a pulse begins with 0 exactly: the last sample of an unfiltered drive is +V in every channel."""
    screen = replace(A4_PROTOTYPE, attenuation=Attenuation(tau_s, exponent=exponent))
    h = impulse_responses(screen, [FOCUS], **(TIMING | {"duration_s": duration_s}))
    assert not h.samples[:, :, 0].any()
    assert (drive(h, 30.0).samples[:, -1] == 30.0).all()


def test_window_multiplies_the_learnt_response(learnt):
    window = np.linspace(1, 0, learnt.n_samples)
    found = reversed_waveform(learnt.at_point(0), window=window)
    assert found == pytest.approx((learnt.samples[0] * window)[:, ::-1], rel=1e-15)


@pytest.mark.parametrize("place", [(0.0, 0.1), (0.297, 0.21), (1e-16, 0.1)])
@pytest.mark.parametrize("boundary", ["SSSS", "CCCC", "CFCF", "SFSC"])
def test_focus_on_a_held_edge_or_corner_is_refused(boundary, place):
    screen = replace(A4_PROTOTYPE, plate=replace(A4_PROTOTYPE.plate, boundary=boundary))
    h = impulse_responses(screen, [place], rate_hz=20e3, duration_s=2e-3, f_max_hz=4e3)
    with pytest.raises(InvalidParameter, match="foci: found responses that are zero everywhere"):
        drive(h, 30.0)


@pytest.mark.parametrize(("boundary", "power"), [("SSSS", 1), ("SFSF", 1), ("CCCC", 2)])
def test_focus_amplitude_falls_near_held_edge(boundary, power):
    screen = replace(A4_PROTOTYPE, plate=replace(A4_PROTOTYPE.plate, boundary=boundary))
    places = [(distance_m, 0.093) for distance_m in (1e-6, 1e-5, 1e-4)]
    h = impulse_responses(screen, places, rate_hz=20e3, duration_s=2e-3, f_max_hz=4e3)
    amplitudes = [focus_amplitude(drive(h.at_point(i), 30.0), h, i) for i in range(3)]
    assert np.log10(amplitudes[1] / amplitudes[0]) == pytest.approx(power, abs=1e-3)
    assert np.log10(amplitudes[2] / amplitudes[1]) == pytest.approx(power, abs=1e-2)


def test_field_at_the_focus_is_the_amplitude_and_its_peak(learnt):
    signal = drive(learnt.at_point(0), 30.0)
    x, y = np.linspace(0, 0.297, 100), np.linspace(0, 0.21, 71)
    u = field(A4_PROTOTYPE, signal, learnt.n_samples - 1, (x, y), F_MAX_HZ)
    peak = np.unravel_index(np.argmax(u), u.shape)
    assert (x[peak[0]], y[peak[1]]) == pytest.approx(FOCUS, abs=3.1e-3)
    there = field(A4_PROTOTYPE, signal, learnt.n_samples - 1, (np.array([0.12]), np.array([0.09])), F_MAX_HZ)
    assert there[0, 0] == pytest.approx(focus_amplitude(signal, learnt), rel=1e-12)


@pytest.mark.parametrize("boundary", ["SSSS", "FFFF"])
def test_matrix_product_field_is_the_sum_over_modes(boundary):
    from tactometry.stimuli.time_reversal.plate.modes import values

    modes = modes_of(BOROFLOAT_33.plate(0.297, 0.21, 1.1e-3, boundary), 8e3)
    amplitude = np.random.default_rng().normal(size=(2, len(modes.frequency_hz)))
    x, y = np.linspace(0, 0.297, 13), np.linspace(0, 0.21, 9)
    summed = amplitude @ values(modes, np.repeat(x, 9), np.tile(y, 13))
    assert modes.field(amplitude, x, y) == pytest.approx(summed.reshape(2, 13, 9), abs=1e-12 * np.abs(summed).max())


@pytest.mark.parametrize("instants", [[10, 400, 799, 900], [150]])
def test_movie_matches_matrix_product_throughout(learnt, instants):
    signal = drive(learnt.at_point(0), 30.0)
    history = modal_history(A4_PROTOTYPE, signal, instants, F_MAX_HZ)
    for column, sample in zip(history.T, instants, strict=True):
        expected = modal_amplitudes(A4_PROTOTYPE, signal, sample, F_MAX_HZ)
        assert column == pytest.approx(expected, abs=1e-11 * np.abs(history).max())
    frames = list(movie(A4_PROTOTYPE, signal, instants, grid(A4_PROTOTYPE, 20, 15), F_MAX_HZ))
    assert len(frames) == len(instants)
    assert np.abs(frames[-1]).max() > 0


def test_emitted_signal_is_convolution_of_drive_and_response():
    rng = np.random.default_rng()
    h = Responses(rng.normal(size=(2, 3, 37)), 1e3)
    signal = Signal(rng.normal(size=(3, 21)), 1e3, "V")
    expected = [sum(np.convolve(signal.samples[q], h.samples[p, q]) for q in range(3)) for p in range(2)]
    assert emitted(signal, h) == pytest.approx(np.array(expected), abs=1e-12)


def test_band_limited_responses_have_nothing_outside(learnt):
    band = Band(2e3, 20e3, 500.0)
    filtered = band_limited(learnt, band)
    power = np.abs(np.fft.rfft(filtered.samples[0, 0] * np.hanning(filtered.n_samples))) ** 2
    f = np.fft.rfftfreq(filtered.n_samples, 1 / filtered.rate_hz)
    assert power[(f < 1.5e3) | (f > 20.5e3)].max() < 1e-4 * power.max()


def test_band_rises_over_its_flanks():
    band = Band(2e3, 6e3, 1e3)
    f = np.array([1999.0, 2e3, 2.5e3, 3e3, 5e3, 5.25e3, 6e3, 6001.0])
    assert band.at(f).real == pytest.approx([0, 0, 0.5, 1, 1, (1 + math.sqrt(0.5)) / 2, 0, 0], abs=1e-12)
    assert Band(2e3, 6e3).at(np.array([1999.0, 2e3, 6e3, 6001.0])).real.tolist() == [0, 1, 1, 0]
    assert Band(0.0, 6e3, 1e3).at(np.zeros(1)).real.tolist() == [1]
    assert (band.width_hz, band.mean_hz) == (4e3, 4e3)


def test_the_inaudible_part_goes_up_to_the_nyquist_frequency():
    impulse = Responses(np.eye(1, 512, 200)[None], 200e3)
    power = np.abs(np.fft.rfft(inaudible(impulse).samples[0, 0])) ** 2
    f = np.fft.rfftfreq(512, 1 / 200e3)
    assert power[(f > 25e3) & (f < 95e3)] == pytest.approx(1.0, abs=0.1)
    assert power[f < 15e3].max() < 0.02


def test_audible_filter_keeps_amplitude_and_removes_audible_part(learnt):
    h = impulse_responses(A4_PROTOTYPE, [FOCUS], rate_hz=200e3, duration_s=7e-3, f_max_hz=60e3)
    quiet = inaudible(h, 20e3)
    f = np.fft.rfftfreq(h.n_samples, 1 / h.rate_hz)
    audible = f < 18e3
    before, after = (np.abs(np.fft.rfft(r.samples[0])) ** 2 for r in (h, quiet))
    assert after[:, audible].sum() < 1e-3 * before[:, audible].sum()


@example(f_min=0.0, width=100.0, flank=5e-324, x=0.25, y=0.125)
@settings(max_examples=25, deadline=None)
@given(st.floats(0.0, 20e3), st.floats(100.0, 5e3), st.floats(0.0, 2e3), st.floats(0.02, 0.27), st.floats(0.02, 0.19))
def test_any_band_and_position_is_finite_and_focuses(f_min, width, flank, x, y):
    screen = Screen(A4_SCREEN, (PointForce(x, y),), Attenuation(3e-3))
    whole = impulse_responses(screen, [FOCUS], rate_hz=60e3, duration_s=5e-3, f_max_hz=25e3)
    h = band_limited(whole, Band(f_min, f_min + width, flank))
    assert np.isfinite(h.samples).all()
    assert not h.samples.any() or focus_amplitude(drive(h, 1.0), h) > 0


def test_amplifier_responses():
    f = np.array([0.0, 1e3, 1e4])
    assert np.abs(Butterworth(1e3, 3).at(f)) == pytest.approx([1, math.sqrt(0.5), 1 / math.sqrt(1 + 10**6)])
    impulse = Responses(np.eye(1, 64)[None], 1e5)
    assert through(impulse, Butterworth(2e3)).samples.sum() == pytest.approx(1.0, rel=0.05)
