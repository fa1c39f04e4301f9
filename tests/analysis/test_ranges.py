"""Tests of intervals of means within the possible values."""

import json

import numpy as np
import pandas as pd
import pytest
from command_line import output
from hypothesis import given, strategies as st
from scipy.special import logit

from tactometry.analysis.anova.group_means import group_table
from tactometry.analysis.means import RATE, Range, mean_with_interval

RANGES = [Range(0.0, 1.0), Range(-3.0, 3.0), Range(0.0), Range(high=1.0)]


@pytest.mark.parametrize("possible", RANGES)
@given(place=st.floats(0.01, 0.99), half=st.floats(0, 20))
def test_interval_stays_in_range_around_mean(possible, place, half):
    low, high = max(possible.low, -50.0), min(possible.high, 50.0)
    mean = low + place * (high - low)
    found = possible.around(mean, half)
    assert possible.low <= found[0] <= mean + 1e-9
    assert mean - 1e-9 <= found[1] <= possible.high


def test_rate_interval_is_symmetric_on_logit():
    found = mean_with_interval(np.array([0.5, 0.8, 0.9, 0.6]), possible=RATE)
    low, mean, high = (logit(found[name]) for name in ("mean_low", "mean", "mean_high"))
    assert high - mean == pytest.approx(mean - low)


@pytest.mark.parametrize("dependent", ["rate_correct", "jnd"])
@pytest.mark.parametrize(("n", "has_interval"), [(2, False), (3, True)])
def test_bounded_mean_needs_three_participants(dependent, n, has_interval):
    values = {"participant": list("abc")[:n], dependent: [0.2, 0.9, 0.95][:n]}
    assert group_table(pd.DataFrame(values), [], dependent)["mean_low"].notna().tolist() == [has_interval]


@pytest.mark.parametrize(
    ("study", "key", "bounds"),
    [("time-reversal-localisation", "outcomes", (0, 1)), ("hybrid-button", "questionnaires", (0, 100))],
)
def test_analyse_reports_possible_intervals(tmp_path, capsys, study, key, bounds):
    output(capsys, "simulate", study, "--participants", "3", "--seed", "2", "--out", tmp_path / "data")
    found = json.loads(output(capsys, "analyse", tmp_path / "data", "--json"))[key]
    ends = [row[end] for row in rows_of(found) for end in ("mean_low", "mean_high") if row[end] is not None]
    assert ends
    assert all(bounds[0] <= end <= bounds[1] for end in ends)


def rows_of(found):
    """Every row of a table of means, at any depth."""
    if isinstance(found, dict):
        return [found] if "mean_low" in found else [row for value in found.values() for row in rows_of(value)]
    return [row for value in found for row in rows_of(value)] if isinstance(found, list) else []
