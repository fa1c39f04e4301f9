"""Efficiency of QUEST+ with the threshold first (see benchmarks).

A cumulative normal observer with 2 % lapses; slope (log-normal, factor 1.5) and lapse rate unknown; everything in units
of the observer's standard deviation.
"""

import math
from functools import cache

import numpy as np
import pytest
from benchmark_modules import benchmark_module
from scipy.special import ndtr
from soak import SOAK

from tactometry.protocols import QuestPlusSettings

N, N_TOGETHER = (1000, 10_000) if SOAK else (30, 500)
AT_1E_4 = 3.72
"""One-sided normal quantile of 1e-4."""
NORMAL_WIDTH = 2 * 1.6448536269514722
TASKS = {"2AFC": (0.5, 0.19), "yes/no": (0.02, 0.115)}
FIRST = "threshold first, variance"


@pytest.fixture(scope="module")
def benchmark():
    return benchmark_module("procedures")


@cache
def errors_after_160(benchmark, guess, name):
    rng, task = np.random.default_rng(), benchmark.Task("", guess)
    truths_db = rng.uniform(-benchmark.SPAN_DB, benchmark.SPAN_DB, N_TOGETHER)
    found_db = benchmark.estimates_db(benchmark.rules(task)[name], task, truths_db, rng, n_max=160)[:, -1]
    return (found_db - truths_db) / benchmark.SD_DB


@pytest.mark.slow
@pytest.mark.parametrize("task", TASKS)
def test_error_after_160_trials_is_near_bound(benchmark, task):
    guess, most = TASKS[task]
    squares = errors_after_160(benchmark, guess, FIRST) ** 2
    assert squares.mean() - AT_1E_4 * squares.std() / math.sqrt(N_TOGETHER) <= most**2


@pytest.mark.slow
def test_threshold_aim_beats_aim_at_all_parameters(benchmark):
    first, whole = (errors_after_160(benchmark, 0.5, name) ** 2 for name in (FIRST, "QUEST+"))
    assert first.mean() < whole.mean()


@pytest.mark.parametrize(("guess", "known", "unknown"), [(0.5, 0.1737, 0.1855), (0.02, 0.1032, 0.1054)])
def test_efficiency_bounds_equal_published_and_computed_values(benchmark, guess, known, unknown):
    task = benchmark.Task("", guess)
    assert math.sqrt(task.bound() / 160) == pytest.approx(known, abs=5e-5)
    assert task.bound_unknown(160) == pytest.approx(unknown, abs=5e-5)


def rule(guess, sd_stop):
    levels = {"low": -3.0, "high": 3.0, "n_levels": 31, "shape": "normal", "guess_rates": (guess,)}
    widths = {"width_low": NORMAL_WIDTH / 2, "width_high": NORMAL_WIDTH * 2, "n_widths": 7, "width_prior_factor": 1.5}
    rates = {"lapse_rates": (0.0, 0.02, 0.04), "n_trials": 400, "criterion": "variance"}
    return QuestPlusSettings(**levels, **widths, **rates, sd_stop=sd_stop).procedure()


def runs(start, guess, rng):
    """Yield the final run of each observer and its error."""
    for truth in rng.uniform(-1.5, 1.5, N):
        at = start
        while not at.finished:
            at = at.after(bool(rng.random() < guess + (0.98 - guess) * ndtr(at.level - truth)))
        yield at, at.mean("threshold") - truth


@pytest.mark.slow
@pytest.mark.parametrize("task", TASKS)
def test_stop_at_standard_deviation_is_reached_and_accurate(task):
    guess, _ = TASKS[task]
    ends = list(runs(rule(guess, sd_stop=0.25), guess, np.random.default_rng()))
    share = np.mean([at.ending == "converged" for at, _ in ends])
    assert share >= 0.9 - AT_1E_4 * math.sqrt(0.9 * 0.1 / N)
    errors = np.array([error for at, error in ends if at.ending == "converged"])
    assert math.sqrt(np.mean(errors**2)) <= 0.25 * (1 + AT_1E_4 / math.sqrt(2 * len(errors)))
