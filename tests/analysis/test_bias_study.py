"""Tests of operating characteristics of statuses (in full: the soak, and docs/reference/analysis.md).

Tolerances are standard errors at 1e-4. A mean of chances below a bound has at most the binomial's variance at it.
"""

import math
import re

import numpy as np
import pandas as pd
import pytest
from benchmark_modules import benchmark_module
from places import ROOT
from scipy.stats import binom
from soak import SOAK

from tactometry.analysis.threshold.fitting import Status, fit_many
from tactometry.experiments.bias_study import estimates
from tactometry.experiments.bias_study.lapses import RULES, track
from tactometry.experiments.bias_study.participants import INSIDE, PLACES, PROCEDURES, TASKS
from tactometry.experiments.bias_study.statuses import N_TRIALS, OUT, TOLD, outcomes_of, settings, summary
from tactometry.psychometric import PsychometricFunction

pytestmark = pytest.mark.slow

AT_1E_4 = 3.72
"""One-sided normal quantile of 1e-4."""
MANY = (40, 80, 160) if SOAK else (40,)
FAR = ("2 below", "2 above")
RULES_TRIED = ("constant stimuli", "1 up 3 down", "weighted, 0.75", "QUEST", "QUEST+, threshold first")
REDUCED = settings(RULES_TRIED, TASKS[1:3], (INSIDE, *FAR))


@pytest.fixture(scope="module")
def outcomes() -> pd.DataFrame:
    chosen, n_sets, n_trials = (settings(), 50, N_TRIALS) if SOAK else (REDUCED, 14, (30, 40))
    return pd.concat(outcomes_of(chosen, n_sets, np.random.default_rng(), n_trials=n_trials))


@pytest.mark.parametrize(("n_trials", "most"), [(30, 0.05), *((n, 0.02) for n in MANY)])
def test_inner_thresholds_are_seldom_out_of_range(outcomes, n_trials, most) -> None:
    inside = outcomes[(outcomes["place"] == INSIDE) & (outcomes["n_trials"] == n_trials)]
    assert inside["status"].isin(OUT).sum() <= binom.ppf(1 - 1e-4, len(inside), most)


@pytest.mark.parametrize("n_trials", [30, *MANY])
def test_outer_thresholds_are_seldom_ok(outcomes, n_trials) -> None:
    outside = outcomes[outcomes["place"].isin(FAR) & (outcomes["n_trials"] == n_trials)]
    assert (outside["status"] == Status.OK).sum() <= binom.ppf(1 - 1e-4, len(outside), 0.02)


@pytest.mark.parametrize("n_trials", [30, *MANY])
@pytest.mark.parametrize("chosen", ["ok", "all"])
def test_intervals_contain_the_truth(outcomes, chosen, n_trials) -> None:
    """Coverage is at least 93.5 %; that of few trials is higher (see docs)."""
    some = outcomes[outcomes["n_trials"] == n_trials]
    some = some[some["status"] == Status.OK] if chosen == "ok" else some
    missed = (~some["true_db"].between(some["low_db"], some["high_db"])).sum()
    assert missed <= binom.ppf(1 - 1e-4, len(some), 0.065)


def test_few_inner_thresholds_are_flat(outcomes) -> None:
    inside = outcomes[(outcomes["place"] == INSIDE) & (outcomes["n_trials"] == 40)]
    assert (inside["status"] == Status.FLAT).sum() <= binom.ppf(1 - 1e-4, len(inside), 0.1)


def test_mode_of_constant_stimuli_is_nearly_unbiased() -> None:
    rng, n_sets, levels = np.random.default_rng(), 4000 if SOAK else 300, np.linspace(-2.5, 2.5, 6)
    curve = PsychometricFunction("normal", 0.3, 4.0, 0.5, 0.02)
    n_yes = rng.binomial(40, [curve.probability(float(x)) for x in levels], (n_sets, 6))
    found = fit_many(levels, n_yes, 40, shape="normal", guess_rate=0.5, scale_free_width=True)
    errors = np.array([one.threshold for one in found if one.status in TOLD]) - 0.3
    assert len(errors) > 0.95 * n_sets
    assert abs(errors.mean() / errors.std()) <= 0.1 + AT_1E_4 / math.sqrt(len(errors))


def test_adaptive_estimates_are_within_quarter_standard_deviation(outcomes) -> None:
    """QUEST is excluded, as it stays at one level (see docs)."""
    adaptive = outcomes[(outcomes["place"] == INSIDE) & ~outcomes["procedure"].isin(("QUEST", "constant stimuli"))]
    longest = adaptive[adaptive["n_trials"] == adaptive["n_trials"].max()]
    (found,) = summary(longest, ["place"]).itertuples()
    assert abs(found.bias_sd) <= 0.25 + AT_1E_4 / math.sqrt(0.8 * found.n)


@pytest.mark.parametrize(
    "design", [design for design in estimates.DESIGNS if design.task.told], ids=lambda each: each.name
)
def test_forced_choice_estimates_reach_their_goal_with_lapses(design) -> None:
    """The truth is normal with 2 % lapses; the fitted shape differs."""
    n_sets = 1000 if SOAK else 60
    options = {"designs": [design], "lapse_rates": [0.02], "truths": ["normal"]}
    tables = estimates.outcomes_of(n_sets, np.random.default_rng(), **options)
    found = estimates.summary(pd.concat(tables)).set_index("fit").loc["now"]
    goal = 0.1 if design.n_trials == 120 else 0.25
    assert abs(found["bias"]) <= goal + AT_1E_4 / math.sqrt(0.8 * n_sets)


def test_docs_have_the_tables_of_the_benchmark(outcomes) -> None:
    status_table = benchmark_module("bias_study").status_table
    docs = (ROOT / "docs" / "reference" / "analysis.md").read_text("utf-8")
    n_sets = int(re.search(r"python benchmarks/bias_study.py statuses --n (\d+)", docs)[1])
    whole = len(PROCEDURES) * len(TASKS) - 1
    made = status_table(outcomes, ["place", "n_trials"]).splitlines()
    rows = [line.split(" | ") for line in docs.split(made[0])[1].strip().splitlines()[1:]]
    shown = [(place, n) for place in PLACES for n in N_TRIALS if n == 40 or place[-5:] not in ("below", "above")]
    rows = rows[: len(shown)]
    assert [(row[0].lstrip("| "), int(row[1])) for row in rows] == shown
    assert {int(row[2]) for row in rows} == {n_sets * whole}
    for name in ("procedure", "task"):
        assert status_table(outcomes[outcomes["n_trials"] == 40], [name]).splitlines()[0] in docs


def test_shares_of_statuses_sum_to_one(outcomes) -> None:
    found = summary(outcomes, ["procedure", "task"])
    assert found[["ok", "separated", "out", "flat", "other"]].sum(axis=1).to_numpy() == pytest.approx(1.0)
    assert found["n"].sum() == len(outcomes)
    assert found["procedure"].tolist()[0] == outcomes["procedure"].iloc[0]


def test_simulated_easy_trials_are_at_highest_level():
    function = PsychometricFunction("gumbel", 10.0, 6.0, 0.5, 0.0)
    for share, n_easy in ((0.0, 0), (0.2, 8)):
        levels, answers = track(RULES["1 up 3 down"], share, function, np.random.default_rng(1))
        assert len(levels) == len(answers) == 40
        assert levels.count(40.0) == n_easy
