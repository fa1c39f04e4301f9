"""Edges of the domain of time reversal: what happens there, or the sentence that says why not."""

import math

import numpy as np
import pytest

from tactometry.errors import InvalidParameter
from tactometry.stimuli.time_reversal import (
    A4_SCREEN,
    Band,
    Fingertip,
    FocusTrain,
    Pattern,
    Responses,
    Screen,
    Setup,
    TimeReversalStimulus,
)
from tactometry.stimuli.time_reversal.design.closed_forms import repetition_amplitude_ratio
from tactometry.stimuli.time_reversal.design.guide import Design, Transducers, amplitudes_m, n_held
from tactometry.stimuli.time_reversal.finger import amplitude_loss
from tactometry.stimuli.time_reversal.focusing.focusing import Emission, emitted
from tactometry.stimuli.time_reversal.focusing.pattern import Table, focus_samples
from tactometry.stimuli.time_reversal.plate.dispersion import mindlin_wavenumber_rad_per_m, wavenumber_rad_per_m
from tactometry.stimuli.time_reversal.responses.load import PlateLoad, loaded_responses
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.transducer import border

SCREEN = Screen(A4_SCREEN, border(A4_SCREEN, 4), Attenuation(3e-3))
EMISSION = Emission(Band(200.0, 9e3), 4e-3, 20e3)
FOCUS = (0.12, 0.09)


def test_finger_without_force_causes_no_loss():
    assert amplitude_loss(SCREEN, FOCUS, [Fingertip().load(FOCUS, 0.0)], EMISSION) == 0.0


def test_a_reversal_shorter_than_half_a_sample_is_refused():
    with pytest.raises(InvalidParameter, match=r"Emission.reversal_s: found 1e-05, expected at least half a sample"):
        Emission(Band(200.0, 9e3), 1e-5, 20e3)


def test_an_emission_above_the_nyquist_frequency_is_refused():
    with pytest.raises(InvalidParameter, match=r"Emission.band: found 11000.0 Hz, above the Nyquist frequency 10000"):
        Emission(Band(200.0, 11e3), 4e-3, 20e3)


def test_overlapping_drives_reduce_design_amplitude():
    alone = Design(A4_SCREEN, Transducers(), Band(20e3, 60e3), 3e-3, 6e-3)
    train = Design(A4_SCREEN, Transducers(), Band(20e3, 60e3), 3e-3, 6e-3, repetition_s=3e-3)
    times = np.array([1e-3, 3e-3, 6e-3, 12e-3])
    penalty = [repetition_amplitude_ratio(float(t), 3e-3, 3e-3) for t in times]
    assert penalty[:2] == [1.0, 1.0]
    assert penalty[3] < penalty[2] < 0.9
    np.testing.assert_allclose(amplitudes_m(train, times), amplitudes_m(alone, times) * penalty, rtol=1e-12)


def test_long_train_penalty_is_finite_at_any_ratio():
    """T of 1e6 tau is as good as endless, and its exponentials do not overflow."""
    endless = repetition_amplitude_ratio(1.0, 1e-3, 1e-3)
    assert repetition_amplitude_ratio(1e3, 1e-3, 1e-3) == pytest.approx(endless, rel=1e-9)
    assert repetition_amplitude_ratio(1e-3, 1e9, 1e-9) == 1.0


def test_refused_design_reports_available_patches():
    held = n_held(A4_SCREEN, 35e-3)
    with pytest.raises(InvalidParameter, match=f"expected at most {held} along the edges"):
        Design(A4_SCREEN, Transducers(held + 1, 35e-3), Band(1e3, 25e3), 3e-3, 6e-3)


def test_plate_is_still_below_its_first_mode():
    sampling = {"rate_hz": 2e3, "duration_s": 5e-3, "f_max_hz": 1.0}
    found = loaded_responses(SCREEN, [FOCUS], [PlateLoad(*FOCUS, 10.0)], **sampling)
    assert not found.samples.any()


def test_more_modes_than_a_machine_holds_are_refused():
    with pytest.raises(InvalidParameter, match="number of modes below f_max_hz: found .*, expected at most 1e"):
        A4_SCREEN.frequencies_hz(1e9)


def test_thick_glass_waves_approach_thin_and_shear_limits():
    shear = math.sqrt(5 / 6 * 64e9 / 2.4 / 2230)
    phase = 2 * math.pi * 1e9 / mindlin_wavenumber_rad_per_m(A4_SCREEN, 1e9)
    assert float(phase) == pytest.approx(shear, rel=1e-5)
    thin = wavenumber_rad_per_m(A4_SCREEN, 1.0)
    assert mindlin_wavenumber_rad_per_m(A4_SCREEN, 1.0) == pytest.approx(thin, rel=1e-5)


MOVING = Responses(1e-9 * np.random.default_rng(0).standard_normal((2, 3, 40)), 1e3)


@pytest.mark.parametrize("modulation", ["voltage", "burst"])
def test_moving_focus_level_is_its_largest_amplitude(modulation):
    pattern = Pattern(10.0, 0.4, Table((0.5, 1.0)))
    stimulus = TimeReversalStimulus(MOVING, pattern, path=(0, 1, 0, 1), modulation=modulation, tau_s=0.02)
    level = 0.5 * stimulus.level_max
    moved = np.abs(emitted(stimulus.at(level), MOVING)[[0, 1, 0, 1], focus_samples(pattern, 1e3, 40)])
    assert moved.max() == pytest.approx(level, rel=1e-12)
    assert moved[3] > moved[1]


def test_heard_responses_are_refused_when_shape_differs():
    with pytest.raises(InvalidParameter, match="found 1 points and 3 channels, expected 2 and 3 as in focus"):
        TimeReversalStimulus(MOVING, heard=MOVING.at_point(0))


def test_study_train_accepts_table_and_bursts():
    setup = Setup(n_transducers=4, modes_to_hz=5e3, rate_hz=10e3, learnt_s=5e-3)
    train = FocusTrain(
        setup, f_max_hz=4e3, repetition_hz=100.0, train_s=0.03, envelope_table=(1.0, 0.2), modulation="burst"
    )
    assert train.foci.weights == pytest.approx([1.0, 0.6 / 0.8666667, 0.3333333 / 0.8666667])
    on = [np.count_nonzero(part) for part in np.split(train.at(-20.0).samples[0], [100, 200])]
    assert on == sorted(on, reverse=True)
    assert len(set(np.abs(train.at(-20.0).samples[0]).round(9))) == 2
