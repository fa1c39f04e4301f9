"""Foci and friction at once: the channels of both, and what a finger feels of them."""

from dataclasses import replace

import numpy as np
import pytest
from felt_models import felt_by

from tactometry.contact import Contact
from tactometry.errors import InvalidParameter
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import load
from tactometry.stimuli.electrovibration import AmplitudeModulated
from tactometry.stimuli.electrovibration.sensation import ElectrovibrationSensation
from tactometry.stimuli.hybrid import Hybrid, HybridSensation
from tactometry.stimuli.time_reversal.stimulus.focus_train import FocusTrain
from tactometry.stimuli.time_reversal.stimulus.sensation import TimeReversalSensation
from tactometry.stimuli.time_reversal.stimulus.setup import Setup

SETUP = Setup(n_transducers=8, modes_to_hz=22e3, rate_hz=50e3)
FOCUS = FocusTrain(SETUP, f_max_hz=20e3)
FRICTION = AmplitudeModulated(frequency_hz=120.0, duration_s=0.5, rate_hz=50e3)
SLIDING, AT_REST = Contact(1.0, 0.05), Contact(1.0)


def test_every_channel_is_that_of_its_own_kind():
    signal = Hybrid(FOCUS, FRICTION, electrode_offset_db=4.0).at(20.0)
    foci, friction = FOCUS.at(20.0).samples, FRICTION.at(24.0).samples
    np.testing.assert_array_equal(signal.samples[:-1, : foci.shape[1]], foci)
    assert not signal.samples[:-1, foci.shape[1] :].any()
    np.testing.assert_array_equal(signal.samples[-1:], friction)


@pytest.mark.parametrize("offset_db", [-40.0, 20.0])
def test_the_stronger_one_is_felt(offset_db):
    signal = Hybrid(FOCUS, FRICTION, offset_db).at(20.0)
    foci = felt_by(TimeReversalSensation(SETUP)).sensation_db(FOCUS.at(20.0), SLIDING)
    friction = felt_by(ElectrovibrationSensation()).sensation_db(FRICTION.at(20.0 + offset_db), SLIDING)
    assert (foci > friction) == (offset_db < 0)
    assert felt_by(HybridSensation(SETUP)).sensation_db(signal, SLIDING) == pytest.approx(max(foci, friction), abs=1e-6)


def test_a_finger_at_rest_feels_the_foci_alone():
    signal = Hybrid(FOCUS, FRICTION, 20.0).at(20.0)
    foci = felt_by(TimeReversalSensation(SETUP)).sensation_db(FOCUS.at(20.0), AT_REST)
    assert felt_by(HybridSensation(SETUP)).sensation_db(signal, AT_REST) == pytest.approx(foci, abs=1e-6)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Hybrid(FOCUS, replace(FRICTION, rate_hz=20e3)), "friction.rate_hz: found 20000.0, expected 50000.0"),
        (lambda: Hybrid(FOCUS, replace(FRICTION, duration_s=0.4)), "friction.duration_s: found 0.4, expected 0.5"),
        (lambda: Hybrid(FOCUS, replace(FRICTION, level_unit="V")), "friction.level_unit: found V, expected dB re 1 V"),
        (lambda: Hybrid(replace(FOCUS, level_unit="m"), FRICTION), "focus.level_unit: found m, expected dB re 1 um"),
        (lambda: Hybrid(FOCUS, FRICTION, np.nan), "electrode_offset_db: found nan, expected a finite number"),
        (lambda: felt_by(HybridSensation(SETUP)).sensation_db(FOCUS.at(20.0), SLIDING), "found 7 channels"),
    ],
)
def test_incompatible_hybrid_parts_are_refused(build, message):
    with pytest.raises(InvalidParameter, match=message):
        build()


def test_the_study_plays_both_at_once_under_a_finger_that_slides():
    made = wire(load("hybrid-button")[0], "hybrid-button")
    cell = next(cell for cell in made.cells.values() if cell.condition.factors["feedback"] == "both")
    samples = cell.stimulus.at(24.0).samples
    assert cell.condition.speed_m_per_s == 0.05
    assert np.abs(samples).max(axis=1).all()
    assert samples.shape[0] == cell.stimulus.setup.n_transducers + 1
