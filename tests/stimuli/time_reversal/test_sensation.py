"""Sensation of foci, and time-reversal stimuli of study files."""

from dataclasses import replace

import numpy as np
import pytest
from felt_models import felt_by
from hypothesis import given, settings, strategies as st
from scipy.signal import find_peaks

from tactometry.config.strict import build
from tactometry.contact import Contact
from tactometry.errors import LimitExceeded
from tactometry.signal import Signal
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.fingertip import Fingertip
from tactometry.stimuli.time_reversal.focusing.focusing import drive as reversed_drive, emitted
from tactometry.stimuli.time_reversal.focusing.one_bit import OneBit
from tactometry.stimuli.time_reversal.focusing.pattern import PATTERNS, focus_samples
from tactometry.stimuli.time_reversal.focusing.quantiser import Analogue
from tactometry.stimuli.time_reversal.focusing.sigma_delta import SigmaDelta
from tactometry.stimuli.time_reversal.responses.load import PlateLoad, loaded_responses
from tactometry.stimuli.time_reversal.responses.responses import band_limited
from tactometry.stimuli.time_reversal.screen.transducer import MOMENT_N_PER_V
from tactometry.stimuli.time_reversal.stimulus.focus_train import FocusTrain, measured
from tactometry.stimuli.time_reversal.stimulus.sensation import (
    TimeReversalSensation,
    events,
    felt_amplitude_m,
    free_displacement,
    loaded_displacements,
    peaks,
)
from tactometry.stimuli.time_reversal.stimulus.setup import Setup

SMALL = Setup(n_transducers=8, modes_to_hz=22e3, rate_hz=50e3)
FAINTEST_N = 1e-12


def train(**changes):
    return FocusTrain(SMALL, **{"f_max_hz": 20e3, "voltage_max_v": 2000.0, **changes})


def loaded(setup, **finger):
    return felt_by(TimeReversalSensation(setup, criterion="loaded", **finger))


def felt_db(level, force_n=FAINTEST_N, **changes):
    return felt_by(TimeReversalSensation(SMALL)).sensation_db(train(**changes).at(level), Contact(force_n))


def test_the_level_is_the_unloaded_amplitude_of_the_focus():
    drive = train(level_unit="m").at(7e-6)
    heard = emitted(drive, SMALL.responses_at(*SMALL.focus_m))[0]
    assert heard[drive.samples.shape[1] - 1] == pytest.approx(7e-6, rel=1e-12)


@given(level=st.floats(-20, 30), higher_by=st.floats(-10, 10))
@settings(max_examples=20, deadline=None)
def test_the_sensation_level_rises_as_the_level_does(level, higher_by):
    assert felt_db(level + higher_by, 1.0) - felt_db(level, 1.0) == pytest.approx(higher_by, abs=1e-9)


def test_two_newton_finger_loss_matches_thesis():
    setup = Setup()
    free, pressed = (
        loaded(setup).sensation_db(FocusTrain(setup, f_max_hz=25e3).at(20.0), Contact(force_n))
        for force_n in (FAINTEST_N, 2.0)
    )
    assert 0.25 <= 1 - 10 ** ((pressed - free) / 20) <= 0.33


@given(forces_n=st.lists(st.floats(0.01, 10.0), min_size=2, max_size=2, unique=True).map(sorted))
@settings(max_examples=20, deadline=None)
def test_more_force_on_a_loaded_plate_never_adds_sensation(forces_n):
    gentle, firm = (loaded(SMALL).sensation_db(train().at(20.0), Contact(force_n)) for force_n in forces_n)
    assert firm <= gentle + 1e-9


def test_reference_focus_is_at_threshold_under_any_force():
    """The thesis found no effect; science note 5.3 keeps a force effect optional."""
    drive = train().at(20.0)
    felt = felt_by(TimeReversalSensation(SMALL))
    assert felt.sensation_db(drive, Contact(3.0)) == pytest.approx(0.0, abs=1e-3)
    assert felt.sensation_db(drive, Contact(0.5)) == felt.sensation_db(drive, Contact(5.0))


@pytest.mark.parametrize("changes", [{"moment_n_per_v": 2 * MOMENT_N_PER_V}, {"side_m": 20e-3}])
def test_stronger_transducers_need_less_voltage(changes):
    weak, strong = FocusTrain(SMALL, f_max_hz=20e3), FocusTrain(replace(SMALL, **changes), f_max_hz=20e3)
    assert strong.voltage_v(0.0) < 0.6 * weak.voltage_v(0.0)


def test_no_contact_and_no_voltage_are_not_felt():
    assert felt_db(20.0, 0.0) == -np.inf
    silence = Signal(np.zeros((8, 350)), SMALL.rate_hz, "V")
    assert felt_by(TimeReversalSensation(SMALL)).sensation_db(silence, Contact(1.0)) == -np.inf


@pytest.mark.parametrize(("mass_kg", "stiffness_n_per_m"), [(0.0, 0.0), (1e-4, 0.0), (0.0, 1e5)])
def test_finger_displacement_matches_loaded_plate(mass_kg, stiffness_n_per_m):
    drive = train().at(20.0)
    finger = Fingertip(mass_kg=mass_kg, stiffness_n_per_m=stiffness_n_per_m)
    heard = loaded_responses(
        SMALL.screen,
        [SMALL.focus_m],
        [finger.load(SMALL.focus_m)],
        rate_hz=SMALL.rate_hz,
        duration_s=SMALL.heard_s,
        f_max_hz=SMALL.modes_to_hz,
    )
    expected = emitted(drive, heard)[0]
    free = free_displacement(drive, SMALL, SMALL.focus_m)
    found = loaded_displacements(free[None], SMALL, [finger.load(SMALL.focus_m, 2.0)])[0]
    assert np.linalg.norm(found - expected) < 0.02 * np.linalg.norm(expected)


def test_a_pin_holds_the_plate_still():
    drive = train().at(20.0)
    free = free_displacement(drive, SMALL, SMALL.focus_m)
    pinned = loaded_displacements(free[None], SMALL, [PlateLoad(*SMALL.focus_m, stiffness_n_per_m=1e20)])[0]
    assert np.abs(pinned).max() < 1e-9 * np.abs(free).max()


def test_a_finger_elsewhere_feels_less_than_at_the_focus():
    drive = train().at(20.0)
    away = felt_by(TimeReversalSensation(SMALL, finger_x_m=0.2, finger_y_m=0.06))
    assert away.sensation_db(drive, Contact(0.5)) < felt_db(20.0, 0.5) - 6


@pytest.mark.parametrize("pattern", PATTERNS)
def test_the_foci_of_a_pattern_are_its_events(pattern):
    stimulus = train(pattern=pattern)
    drive = stimulus.at(20.0)
    displacement = free_displacement(drive, SMALL, SMALL.focus_m)
    times_s, peaks_m = events(displacement, SMALL.rate_hz)
    n = round(stimulus.emission_s * SMALL.rate_hz)
    expected_s = focus_samples(stimulus.foci, SMALL.rate_hz, n) / SMALL.rate_hz
    strong_s = expected_s[np.abs(stimulus.foci.weights) > 0.7]
    assert np.abs(np.subtract.outer(strong_s, times_s)).min(axis=1).max() < 2e-4
    assert peaks_m.max() == pytest.approx(10e-6, rel=0.3)


def test_pattern_drives_do_not_overlap_by_default():
    assert train(pattern="P4").emission_s == pytest.approx(2e-3)
    assert train(pattern="P4", reversal_s=5e-3).emission_s == 5e-3


def test_train_at_250_hz_feels_strongest():
    slow, best, fast = (felt_amplitude_m(np.arange(25) / f_hz, np.ones(25)) for f_hz in (40, 250, 600))
    assert best > 1.1 * max(slow, fast)


def test_foci_half_a_millisecond_apart_add_up():
    assert felt_amplitude_m([0.0, 0.5e-3], [1.0, 1.0]) > 1.7
    assert felt_amplitude_m([0.0, 2e-3], [1.0, 1.0]) == 1.0


def test_foci_a_second_apart_feel_like_one():
    one, two = (felt_db(20.0, pattern="P1", repetition_hz=1.0, train_s=n, duration_s=2.0) for n in (1.0, 2.0))
    assert two - one == pytest.approx(0.0, abs=0.05)


def test_side_lobes_are_events_and_reverberation_is_not():
    """Decaying noise of 1.5 % behind foci of 1, -0.2 and 0.13: those three, and what noise reaches by chance."""
    rng, rate_hz = np.random.default_rng(16), 100e3
    at, heights = np.array([1000, 2000, 3000]), np.array([1.0, -0.2, 0.13])
    course = rng.normal(0.0, 0.015, 6000) * np.exp(-np.arange(6000) / 4000)
    course[at] = heights
    times_s, peaks_m = events(course, rate_hz)
    assert set(at / rate_hz) <= set(times_s)
    assert len(peaks_m) <= len(at) + 6  # of noise 1 is expected, 7 are so with a probability of 1e-4


def test_only_largest_peak_of_reverberation_is_felt():
    course = np.random.default_rng(16).uniform(-1.0, 1.0, 5000)
    _, peaks_m = events(course, 100e3)
    assert peaks_m.tolist() == [np.abs(course).max()]


@pytest.mark.parametrize("pattern", ["P2", "P3"])
def test_lobes_of_a_pattern_above_its_reverberation_are_events(pattern):
    stimulus = train(pattern=pattern)
    displacement = free_displacement(stimulus.at(20.0), SMALL, SMALL.focus_m)
    times_s, _ = events(displacement, SMALL.rate_hz)
    n = round(stimulus.emission_s * SMALL.rate_hz)
    lobes_s = focus_samples(stimulus.foci, SMALL.rate_hz, n)[np.abs(stimulus.foci.weights) > 0.2] / SMALL.rate_hz
    assert len(lobes_s) > 3
    assert np.abs(np.subtract.outer(lobes_s, times_s)).min(axis=1).max() < 2e-4


def test_events_within_a_millisecond_count_as_one():
    times_s, peaks_m = events(np.array([0, 1.0, 0, 0, 0, 2.0, 0]), 10e3)
    assert (times_s.tolist(), peaks_m.tolist()) == ([5e-4], [2.0])
    times_s, peaks_m = events(np.array([0, 2.0, 0, 0.9, 0, 1.1, 0]), 1e3)
    assert (times_s.tolist(), peaks_m.tolist()) == ([1e-3, 3e-3, 5e-3], [2.0, 0.9, 1.1])


@given(
    x=st.lists(st.integers(0, 5), min_size=1, max_size=60),
    scale=st.floats(1e-12, 1e12),
    height=st.floats(0, 5),
    apart=st.integers(1, 12),
)
def test_peaks_match_scipy(x, scale, height, apart):
    """Few values, so that many are equal and flat."""
    signal = scale * np.array([0, *x, 0])
    expected, _ = find_peaks(signal, height=scale * height, distance=apart)
    np.testing.assert_array_equal(peaks(signal, scale * height, apart), expected)


def test_setup_passes_shear_factor_and_inset_to_screen():
    screen = replace(SMALL, shear_factor=5 / 6, inset_m=20e-3).screen
    assert screen.shear_factor == 5 / 6
    assert min(min(patch.x_m, patch.y_m) for patch in screen.sources) == pytest.approx(20e-3)


def test_heard_duration_covers_60_db_and_learnt_duration():
    short = replace(SMALL, tau_s=1e-4)
    assert short.heard_s == short.learnt_s == short.learnt().duration_s == 7e-3
    assert SMALL.heard_s == pytest.approx(np.log(1000) * SMALL.tau_s)


def test_events_are_timed_to_the_sample():
    times_s, peaks_m = events(np.array([0, 0, 1.0, 0, 0, 0, -2.0]), 1000.0)
    assert times_s.tolist() == [0.002, 0.006]
    assert peaks_m.tolist() == [1.0, 2.0]


NAMED = {"one_bit": OneBit(), "analogue": Analogue(), "sigma_delta_1": SigmaDelta(1), "sigma_delta_2": SigmaDelta(2)}


@pytest.mark.parametrize("name", NAMED)
def test_a_named_drive_is_its_quantiser(name):
    found = train(drive=name, f_max_hz=2e3).at(-40.0)
    expected = reversed_drive(band_limited(SMALL.learnt(), Band(200.0, 2e3)), 1.0, NAMED[name])
    assert found.samples / found.peak == pytest.approx(expected.samples / expected.peak, abs=1e-12)


@pytest.mark.parametrize("name", ["rectangular", "raised_cosine", "exponential", "sinc"])
def test_envelope_name_selects_its_class(name):
    assert type(train(pattern="P1", envelope=name).foci.envelope).__name__ == name.title().replace("_", "")


def test_measured_responses_need_same_voltage_with_short_reversal():
    short = train(reversal_s=3e-3)
    assert measured(short, SMALL.responses_at(*SMALL.focus_m)).voltage_v(0.0) == short.voltage_v(0.0)


def test_replaced_parts_of_a_pattern_are_used():
    foci = train(pattern="P6", repetition_hz=100.0, train_s=0.1, envelope="raised_cosine").foci
    assert foci.n_foci == 10
    assert foci.weights[0] == pytest.approx((1 - np.cos(np.pi / 10)) / (1 - np.cos(np.pi * 0.9)))


def test_drive_above_amplifier_limit_is_refused_before_playback():
    stimulus = train(voltage_max_v=200.0)
    with pytest.raises(LimitExceeded, match=r"above the 200 V of the amplifier"):
        stimulus.at(stimulus.level_max + 0.1)
    assert stimulus.at(stimulus.level_max).peak == pytest.approx(200.0)
    assert stimulus.voltage_v(10.0) == pytest.approx(stimulus.at(10.0).peak, rel=1e-12)


def test_stimulus_and_sensation_are_built_from_tables():
    table = {"setup": {"n_transducers": 8, "modes_to_hz": 22e3, "rate_hz": 50e3}, "f_max_hz": 20e3, "pattern": "P3"}
    table["voltage_max_v"] = 2000
    stimulus = build(FocusTrain, table, "stimulus")
    assert stimulus == train(pattern="P3")
    assert build(TimeReversalSensation, {}, "sensation", setup=stimulus.setup) == TimeReversalSensation(SMALL)


def test_study_train_accepts_table_and_bursts():
    setup = Setup(n_transducers=4, modes_to_hz=5e3, rate_hz=10e3, learnt_s=5e-3)
    train = FocusTrain(
        setup, f_max_hz=4e3, repetition_hz=100.0, train_s=0.03, envelope_table=(1.0, 0.2), modulation="burst"
    )
    assert train.foci.weights == pytest.approx([1.0, 0.6 / 0.8666667, 0.3333333 / 0.8666667])
    on = [np.count_nonzero(part) for part in np.split(train.at(-20.0).samples[0], [100, 200])]
    assert on == sorted(on, reverse=True)
    assert len(set(np.abs(train.at(-20.0).samples[0]).round(9))) == 2
