"""Tests of goodness of fit: error rates and power."""

import re

import numpy as np
import pandas as pd
import pytest
from command_line import output
from scipy.special import ndtr
from scipy.stats import binom, norm
from soak import SOAK

from tactometry.analysis.pipeline import analyse
from tactometry.analysis.report.summary import summary
from tactometry.analysis.tasks.goodness import P_COLUMNS, TESTS, goodness_table, goodness_warnings
from tactometry.analysis.threshold.counts import normalise
from tactometry.analysis.threshold.fitting import fit
from tactometry.analysis.threshold.goodness import ENOUGH, STATISTICS, Sequences, _Tally, goodness, statistics
from tactometry.analysis.threshold.log_posterior import LogPosterior, Prior
from tactometry.analysis.threshold.mode import find_mode
from tactometry.psychometric import SHAPES

N_SETS = 2000 if SOAK else 250
LEVELS = np.arange(1.0, 8.0)
TRUTH, WIDTH, LAPSE, RARE = 3.7, 1.2, 0.02, 1e-4
FORCED, FREE = 0.5, None


def chance(x, guess, threshold=TRUTH):
    low = 0.03 if guess is None else guess
    return low + (1 - low - LAPSE) * ndtr((x - threshold) / WIDTH)


def constant(n_each, rng, n_sets=N_SETS):
    """Draw levels (n_sets, n_trials) of constant stimuli in random order."""
    return np.stack([rng.permutation(np.repeat(LEVELS, n_each)) for _ in range(n_sets)])


def staircases(n_trials, guess, n_down, rng):
    """Simulate staircases that go down after `n_down` correct answers."""
    levels, answers = np.empty((N_SETS, n_trials)), np.empty((N_SETS, n_trials))
    level, run = np.full(N_SETS, 8.0), np.zeros(N_SETS)
    for t in range(n_trials):
        levels[:, t] = level
        answers[:, t] = yes = rng.random(N_SETS) < chance(level, guess)
        run = np.where(yes, run + 1, 0)
        level = np.where(yes, np.where(run == n_down, level - 0.5, level), level + 0.5).clip(0.0, 8.0)
        run = np.where(run == n_down, 0, run)
    return levels, answers


def problem(levels, answers, guess, n_catch=0, rng=None):
    """Return the posterior, and answers in stretches of ten."""
    n_sets, n_trials = levels.shape
    every = np.unique(levels)
    where = (
        np.repeat(np.arange(n_sets), n_trials),
        np.tile(np.arange(n_trials) // 10, n_sets),
        np.searchsorted(every, levels).ravel(),
    )
    yes, n = (np.zeros((n_sets, n_trials // 10, len(every))) for _ in range(2))
    np.add.at(yes, where, answers.ravel())
    np.add.at(n, where, 1.0)
    order = np.argsort(n.sum(axis=1) == 0, axis=1, kind="stable")  # levels that a track never met stand last
    yes, n = (np.take_along_axis(part, order[:, None], 2) for part in (yes, n))
    counts = normalise(every[order], yes.sum(axis=1), n.sum(axis=1), robust_range=True)
    alarms = rng.binomial(n_catch, 0.03, n_sets) if n_catch else np.zeros(n_sets)
    prior = Prior(counts.gap, None, guess, alarms.astype(float), np.full(n_sets, n_catch), scale_free_width=True)
    return LogPosterior(SHAPES["normal"], counts, prior), Sequences(yes, n)


def shares(levels, answers, guess, rng, *, bound, follows=False, n_catch=0):
    """Return the share of data sets with p at most the bound, by test."""
    posterior, sequences = problem(levels, answers, guess, n_catch, rng)
    theta = find_mode(posterior).theta
    found = goodness(posterior, theta, sequences, np.full(len(levels), follows), rng)
    assert np.isfinite(found.statistics).all()
    assert ((found.p > 0) & (found.p <= 1)).all()
    return dict(zip(TESTS, (found.p <= bound).mean(axis=0), strict=True))


def most(share):
    """Return the most data sets whose p may be below its bound by chance."""
    return binom.ppf(1 - RARE, N_SETS, share) / N_SETS


@pytest.mark.slow
@pytest.mark.parametrize(("n_each", "guess", "n_catch"), [(10, FORCED, 0), (10, FREE, 20), (3, FORCED, 0)])
def test_goodness_tests_have_nominal_error_rate(n_each, guess, n_catch):
    rng = np.random.default_rng()
    levels = constant(n_each, rng)
    if n_each == 3:
        levels = levels[:, :20]
    answers = rng.random(levels.shape) < chance(levels, guess)
    found = shares(levels, answers, guess, rng, bound=0.05, n_catch=n_catch)
    assert max(found.values()) <= most(0.05), found


@pytest.mark.slow
@pytest.mark.parametrize(("n_trials", "guess", "n_down"), [(40, FORCED, 3), (80, FREE, 1)])
def test_goodness_tests_hold_error_rate_in_staircases(n_trials, guess, n_down):
    rng = np.random.default_rng()
    levels, answers = staircases(n_trials, guess, n_down, rng)
    found = shares(levels, answers, guess, rng, bound=0.05, follows=True)
    assert max(found.values()) <= most(0.05), found


FAULTS = {
    "overdispersion": lambda x: np.where(np.isin(np.arange(140), range(40, 65)), 0.5, chance(x, FREE)),
    "order": lambda x: chance(x, FREE, TRUTH + 2.5 * (0.5 - np.arange(140) / 140)),
    "deviance": lambda x: np.where(x >= 6, 0.4, chance(x, FREE)),
}
"""Lapses in a row, learning, and a fall at the highest levels."""


@pytest.mark.slow
@pytest.mark.parametrize(("test", "power"), [("overdispersion", 0.25), ("order", 0.5), ("deviance", 0.5)])
def test_each_fault_is_found_by_its_test(test, power):
    rng = np.random.default_rng()
    levels = constant(20, rng, N_SETS // 3)
    found = shares(levels, rng.random(levels.shape) < FAULTS[test](levels), FREE, rng, bound=0.01)
    assert found[test] >= power, found


def test_goodness_deviance_equals_deviance_of_fit():
    k, n = np.array([10, 11, 12, 15, 18, 16, 20]), 20
    found = fit(LEVELS, k, n, shape="normal", guess_rate=0.5)
    counts = normalise(LEVELS[None], k[None].astype(float), np.full((1, 7), 20.0))
    zero = np.zeros(1)
    theta = find_mode(LogPosterior(SHAPES["normal"], counts, Prior(counts.gap, None, 0.5, zero, zero))).theta
    values = statistics(SHAPES["normal"], counts, theta, Sequences(counts.n_yes[:, None], counts.n_trials[:, None]))
    assert values[0, 0] == pytest.approx(found.deviance, rel=1e-9)


def test_residual_order_and_dispersion_have_closed_form():
    counts = normalise(np.zeros((1, 1)), np.array([[20.0]]), np.array([[40.0]]))
    theta = np.array([[0.0, 0.0, 0.0, 0.0]])
    answers = Sequences(np.array([[[0.0], [0.0], [10.0], [10.0]]]), np.full((1, 4, 1), 10.0))
    found = dict(zip(STATISTICS, statistics(SHAPES["normal"], counts, theta, answers)[0], strict=True))
    off, away = 5.0 * np.array([-1, -1, 1, 1]), np.array([-1.5, -0.5, 0.5, 1.5])
    assert found["residual_order_z"] == pytest.approx((off * away).sum() / np.sqrt((2.5 * away**2).sum()))
    assert found["dispersion"] == pytest.approx((off**2).sum() / (4 * 2.5) / 2)
    assert found["deviance"] == pytest.approx(0.0)


@pytest.mark.parametrize("share", [0.02, 0.3])
def test_early_stopped_monte_carlo_p_is_valid(share):
    """Besag and Clifford 1991; here p itself is known."""
    rng = np.random.default_rng()
    tally = _Tally(*(np.zeros((4000, 4), dtype=np.int64) for _ in range(2)))
    for n_draws in (20, 79, 900):
        sets = tally.is_open()
        tally.add(sets, rng.random((len(sets), n_draws, 4)) < share)
    p = tally.p()
    n = tally.n_drawn.mean()
    assert (tally.n_extreme[tally.n_drawn < 999] == ENOUGH).all()
    assert n == pytest.approx(min(ENOUGH / share, 999), rel=0.05)
    assert np.median(p) == pytest.approx(share, rel=0.3)


def table_of(path, burst, n_participants=6):
    """Write constant stimuli; participants in `burst` guess a third of the trials in a row."""
    rng = np.random.default_rng()
    rows = ["participant,session,study,block,trial,force_n,procedure,level,level_unit,task,response"]
    for who in range(n_participants):
        levels = rng.permutation(np.repeat(LEVELS, 20))
        p = norm.cdf(levels, TRUTH, WIDTH / 2)
        if who in burst:
            p[50:90] = 1 - p[50:90]
        for n, (level, yes) in enumerate(zip(levels, rng.random(140) < p, strict=True), 1):
            rows.append(f"P{who + 1},1,x,1,{n},1,constant_stimuli,{level:g},V,yes_no,{int(yes)}")
    path.write_text("\n".join(rows) + "\n")
    return path


def test_burst_of_guesses_is_reported_as_overdispersion(tmp_path, capsys):
    path, page = table_of(tmp_path / "t.csv", burst=(2,)), tmp_path / "r.html"
    text = " ".join(output(capsys, "analyse", path, "--report", page).split())
    # Each of the others has p <= 0.01 by chance once in a hundred sets.
    assert re.search(r"! [123] of 6 fitted functions have p <= 0.01 in the test of overdispersion", text)
    thresholds = pd.read_csv(tmp_path / "r_tables" / "thresholds.csv").set_index("participant")
    assert "overdispersion" in thresholds.loc["P3", "misfit"]
    assert thresholds["dispersion"].idxmax() == "P3"
    for text in ("Goodness of fit", "Wichmann, F. A., &amp; Hill, N. J. (2001)"):
        assert text in page.read_text()


def test_goodness_results_are_repeatable_and_in_json(tmp_path):
    path = table_of(tmp_path / "t.csv", burst=())
    one, other = (analyse(path) for _ in range(2))
    assert [row["test"] for row in summary(one)["goodness"]] == list(TESTS)
    assert {row["n_tested"] for row in summary(one)["goodness"]} == {6}
    pd.testing.assert_frame_equal(one.tables["thresholds"], other.tables["thresholds"])


def test_flags_that_chance_explains_are_no_warning():
    table = pd.DataFrame({"participant": [f"P{n}" for n in range(200)]} | dict.fromkeys(P_COLUMNS.values(), 0.5))
    table.loc[:3, "deviance_p"] = 0.009
    assert list(goodness_warnings(table, ())) == []
    assert goodness_table(table).set_index("test").loc["deviance", ["n_flagged", "n_by_chance"]].tolist() == [4, 2.0]
    table.loc[:8, "deviance_p"] = 0.009
    (warning,) = goodness_warnings(table, ())
    assert warning.startswith("9 of 200 fitted functions have p <= 0.01 in the test of deviance (by chance about 2.0")


def test_a_cell_without_a_function_has_no_test(tmp_path):
    path = tmp_path / "t.csv"
    table_of(path, burst=(), n_participants=2)
    rows = [line.rpartition(",")[0] + ",1" if line.startswith("P2") else line for line in path.read_text().split("\n")]
    path.write_text("\n".join(rows))
    found = analyse(path).tables["thresholds"].set_index("participant")
    assert found.loc["P2", [*P_COLUMNS.values()]].isna().all()
    assert found.loc["P1", [*P_COLUMNS.values()]].notna().all()
    assert found.loc["P2", "misfit"] == ""
