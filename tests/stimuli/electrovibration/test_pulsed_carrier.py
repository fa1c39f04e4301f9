"""Pulse-width carrier: mean square per half period, and sensation."""

import numpy as np
import pytest
from felt_models import felt_by
from hypothesis import given, strategies as st

from tactometry.contact import Contact
from tactometry.errors import LimitExceeded
from tactometry.stimuli.electrovibration import AmplitudeModulated
from tactometry.stimuli.electrovibration.sensation import ElectrovibrationSensation
from tactometry.stimuli.electrovibration.waveforms.amplitude_modulated import of_supply

SUPPLY_V = 100.0


def pulsed(**fields):
    return of_supply(AmplitudeModulated(**{"frequency_hz": 120.0, "duration_s": 0.2, **fields}), 250e3, SUPPLY_V)


@given(st.floats(26.0, 42.0), st.floats(20.0, 400.0), st.sampled_from(["square_root", "full", "suppressed_carrier"]))
def test_pulsed_carrier_energy_error_is_below_half_sample(level, frequency_hz, modulation):
    stimulus = pulsed(frequency_hz=frequency_hz, modulation=modulation)
    asked, made = stimulus.waveform.at(level).samples[0], stimulus.at(level).samples[0]
    assert set(np.unique(made)) == {-SUPPLY_V, 0.0, SUPPLY_V}
    zeros = np.flatnonzero(np.diff(np.sign(asked)))
    ahead = np.cumsum(made**2 - asked**2)[zeros] / SUPPLY_V**2
    assert np.abs(ahead).max() <= 0.5 + 1e-6
    assert np.all(made * asked >= 0)


@pytest.mark.parametrize("level", [28.0, 34.0, 36.0, 40.0])
def test_it_feels_as_the_carrier_does(level):
    """Within 0.6 dB: steep flanks lose less through the skin than a sine does."""
    stimulus, model, contact = pulsed(duration_s=0.5), felt_by(ElectrovibrationSensation()), Contact(1.0, 0.05)
    asked_db, made_db = (model.sensation_db(each.at(level), contact) for each in (stimulus.waveform, stimulus))
    assert made_db == pytest.approx(asked_db, abs=0.6)


def test_levels_above_supply_are_refused_with_fix():
    assert (pulsed().level_unit, pulsed().duration_s) == ("dB re 1 V", 0.2)
    with pytest.raises(
        LimitExceeded, match="found an effective voltage of 141.. V, above the 100 V of the supply; low"
    ):
        pulsed().at(46.0)
    with pytest.raises(LimitExceeded, match="level: found 9.998 V, expected at least 17.89 V, which pulses of 1 s"):
        pulsed(ramp_s=0.0).at(20.0)
