"""Tests of modes of very many tracks."""

import numpy as np
import pytest

from tactometry.analysis.threshold.fitting import Status, fit_many
from tactometry.analysis.threshold.track_modes import fit_modes
from tactometry.errors import InvalidParameter
from tactometry.experiments.bias_study.batches import BATCH, Respondents, fitted_tracks
from tactometry.protocols import ConstantStimuli, Quest, Staircase
from tactometry.protocols.batch.answers import LevelTable, criteria
from tactometry.protocols.batch.tracks import tracks

STAIRCASE = Staircase(36.0, (8.0, 4.0, 2.0), 0.0, 40.0, n_reversals=1000, n_trials=100, n_at_bound=1000)
PEOPLE = Respondents(20.0, 3.0, 8.0, guess_rate=0.5, lapse_rate=0.02)
GIVEN = {"shape": "gumbel", "guess_rate": 0.5, "lapse_rate": 0.02, "scale_free_width": True}


@pytest.mark.parametrize(
    "rule", [STAIRCASE, Quest(20.0, 10.0, 0.0, 40.0, 0.5, n_trials=100)], ids=["shared", "anywhere"]
)
def test_track_mode_equals_that_of_single_fit(rule):
    drawn = criteria(np.random.default_rng().random((60, 100)), "gumbel", 20.0, 8.0, 0.5, 0.02)
    made = tracks(rule, drawn)
    found = fit_modes(made.levels, made.answers, **GIVEN)
    single = fit_many(made.levels, made.answers, 1, **GIVEN)
    held = np.array([one.status is Status.OK for one in single]) & found.regular
    thresholds = np.array([np.nan if one.threshold is None else one.threshold_mode for one in single])
    widths = np.array([np.nan if one.width is None else one.width for one in single])
    assert held.sum() > 40
    np.testing.assert_allclose(found.thresholds[held], thresholds[held], atol=1e-5)
    np.testing.assert_allclose(found.widths[held], widths[held], rtol=1e-4)


def test_track_modes_have_stated_standard_errors():
    (made,) = fitted_tracks(STAIRCASE, PEOPLE, (0,), int(np.random.default_rng().integers(2**32)), n_trials=100)
    modes = made.modes
    z = ((modes.thresholds - made.thresholds) / modes.standard_errors)[modes.regular]
    assert len(z) > 0.9 * BATCH
    assert abs(np.median(z)) < 0.2
    assert 0.8 < np.subtract(*np.quantile(z, (0.8413, 0.1587))) / 2 < 1.4


def test_levels_felt_through_table_are_fitted_unchanged():
    """If a stimulus feels 6 dB weaker, its threshold is 6 dB higher."""
    weaker = LevelTable(np.array([0.0, 40.0]), np.array([-6.0, 34.0]))
    rule = ConstantStimuli(tuple(np.arange(8.0, 37.0, 4.0).tolist()), 12)
    (plain,), (made,) = (fitted_tracks(rule, PEOPLE, (3,), 1, n_trials=96, table=table) for table in (None, weaker))
    median, of_plain = (np.median(each.modes.thresholds[each.modes.regular]) for each in (made, plain))
    assert median - of_plain == pytest.approx(6.0, abs=0.4)


@pytest.mark.parametrize(
    ("levels", "answers", "shape", "sentence"),
    [
        (np.zeros(3), np.zeros(3), "normal", r"fit_modes: found shapes \(3,\), \(3,\), expected two arrays of shape"),
        (np.zeros((1, 3)), np.full((1, 3), 2), "normal", "fit_modes.answers: found another value, expected 1 or 0"),
        (np.zeros((1, 3)), np.zeros((1, 3)), "weibull", "fit_modes.shape: found weibull"),
    ],
)
def test_invalid_tracks_are_rejected(levels, answers, shape, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        fit_modes(levels, answers, shape=shape, guess_rate=0.5)
