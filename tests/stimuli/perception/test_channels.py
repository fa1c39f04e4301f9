"""Receptor channels, spatial summation, and their effect in a scene."""

import numpy as np
import pytest
from scene_cases import LEVEL, effect, panel

from tactometry.errors import InvalidParameter
from tactometry.stimuli.perception.channels import (
    NP_I,
    NP_III,
    P,
    channel_levels_db,
    channel_thresholds_db,
    summation_db,
)
from tactometry.stimuli.perception.detection import Components


@pytest.mark.parametrize(("frequency_hz", "channel"), [(1.0, NP_III), (20.0, NP_I), (60.0, P), (250.0, P), (500.0, P)])
def test_expected_channel_has_lowest_threshold(frequency_hz, channel):
    assert channel_thresholds_db(frequency_hz)[:, 0].argmin() == channel


def test_lowest_threshold_is_pacinian_at_250_hz():
    f_hz = np.geomspace(0.5, 790.0, 400)
    best = channel_thresholds_db(f_hz).min(axis=0)
    assert channel_thresholds_db(250.0)[P, 0] == 0
    assert best.min() >= 0
    assert abs(f_hz[best.argmin()] - 250) < 5


def test_channels_are_silent_above_their_range():
    assert channel_levels_db(Components(np.array([2000.0]), np.array([1.0])), 1.0).max() == -np.inf
    assert channel_levels_db(Components(np.zeros(0), np.zeros(0)), 1.0).max() == -np.inf


@pytest.mark.parametrize("frequency_hz", [0.0, -1.0, np.nan, np.inf])
def test_a_frequency_outside_of_the_domain_is_refused(frequency_hz):
    with pytest.raises(InvalidParameter, match=r"frequency_hz: found"):
        channel_thresholds_db(frequency_hz)


@pytest.mark.parametrize(("area_m2", "reference_m2"), [(0.0, 1.0), (1.0, np.inf)])
def test_an_area_outside_of_the_domain_is_refused(area_m2, reference_m2):
    with pytest.raises(InvalidParameter, match=r"summation_db\.(area|reference)_m2: found"):
        summation_db(area_m2, reference_m2)


def felt(*effects):
    return panel(effect("friction"), *effects, outputs=("sensation_db",)).resolve().run(LEVEL)["sensation_db"]


def test_pacinian_gain_is_3_db_per_area_doubling():
    plain = felt(effect("receptors"))
    doubled = felt(effect("receptors"), effect("summation", reference_m2=0.5e-4))
    assert doubled - plain == pytest.approx(10 * np.log10(2), abs=1e-9)


def test_masker_lowers_level_by_its_threshold_rise():
    masked = felt(effect("sensitivity"), effect("masking", level_db_re_threshold=25.0))
    assert felt(effect("sensitivity")) - masked == pytest.approx(13.0, abs=1e-9)
