"""What the rule that puts the threshold first promises, in reduced form: benchmarks/procedures.py has it in full.

A cumulative normal observer with 2 % lapses; slope (log-normal, factor 1.5) and lapse rate unknown; everything in units
of the observer's standard deviation.
"""

import doctest
import math
import os
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ndtr

from tactometry.protocols import QuestPlusSettings

N = 1000 if os.environ.get("TACTOMETRY_SOAK") == "1" else 40
AT_1E_4 = 3.72
"""One-sided normal quantile of 1e-4."""
NORMAL_WIDTH = 2 * 1.6448536269514722
TASKS = {"2AFC": (0.5, 0.19), "yes/no": (0.02, 0.115)}


def rule(guess, n_trials, sd_stop=None):
    return QuestPlusSettings(
        low=-3.0,
        high=3.0,
        n_levels=31,
        width_low=NORMAL_WIDTH / 2,
        width_high=NORMAL_WIDTH * 2,
        n_widths=7,
        width_prior_factor=1.5,
        shape="normal",
        guess_rates=(guess,),
        lapse_rates=(0.0, 0.02, 0.04),
        n_trials=n_trials,
        sd_stop=sd_stop,
        criterion="variance",
    ).procedure()


def runs(start, guess, rng):
    """The end of each observer's run, and its error."""
    for truth in rng.uniform(-1.5, 1.5, N):
        at = start
        while not at.finished:
            at = at.after(bool(rng.random() < guess + (0.98 - guess) * ndtr(at.level - truth)))
        yield at, at.mean("threshold") - truth


@pytest.mark.parametrize("task", TASKS)
def test_the_error_after_160_trials_is_near_the_bound(task):
    guess, most = TASKS[task]
    errors = np.array([error for _, error in runs(rule(guess, 160), guess, np.random.default_rng())])
    assert math.sqrt(np.mean(errors**2)) <= most * (1 + AT_1E_4 / math.sqrt(2 * N))


@pytest.mark.parametrize("task", TASKS)
def test_a_stop_at_a_spread_is_reached_and_honest(task):
    guess, _ = TASKS[task]
    ends = list(runs(rule(guess, 400, sd_stop=0.25), guess, np.random.default_rng()))
    share = np.mean([at.ended == "converged" for at, _ in ends])
    assert share >= 0.9 - AT_1E_4 * math.sqrt(0.9 * 0.1 / N)
    errors = np.array([error for at, error in ends if at.ended == "converged"])
    assert math.sqrt(np.mean(errors**2)) <= 0.25 * (1 + AT_1E_4 / math.sqrt(2 * len(errors)))


def test_the_page_on_procedures_says_what_is_true():
    page = Path(__file__).resolve().parents[1] / "docs" / "procedures.md"
    assert doctest.testfile(str(page), module_relative=False).failed == 0
