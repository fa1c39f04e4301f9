"""QUEST+ with other models: parameters, outcomes, variance and priors."""

import itertools
import math
from dataclasses import replace

import mpmath
import numpy as np
import pytest
from hard_cases import exact_case, hard_case
from hypothesis import given, settings, strategies as st

from tactometry.errors import InvalidParameter
from tactometry.protocols import QuestPlus, QuestPlusSettings
from tactometry.protocols.bayesian.outcome_model import FunctionModel
from tactometry.protocols.bayesian.parameter_grid import ParameterGrid
from tactometry.protocols.bayesian.settings import PsiSettings, grid_values
from tactometry.psychometric import PsychometricFunction

LEVELS = tuple(np.linspace(-5, 45, 26))
GRID = ParameterGrid(tuple(np.linspace(0, 40, 21)), (4.0, 8.0, 16.0), (0.5,), (0.0, 0.02, 0.06))


def as_function(grid):
    """Return a grid as a function of one level and outcome."""

    def log_probability(level, outcome, *, threshold, width, guess_rate, lapse_rate):
        def one(t, w, g, lapse):
            return PsychometricFunction(grid.shape, t, w, g, lapse).log_probability(level, outcome)

        return np.vectorize(one)(threshold, width, guess_rate, lapse_rate)

    return FunctionModel(grid.parameters, 2, log_probability)


GENERAL = as_function(GRID)


def similarity(level, outcome, *, centre, spread):
    """Return log probabilities of lower, same and higher than a centre."""
    lower, higher = (1 / (1 + np.exp((side * (level - centre) + 2 * spread) / spread)) for side in (1, -1))
    return np.log(np.stack([lower, 1 - lower - higher, higher])[outcome])


THREE = FunctionModel({"centre": tuple(np.linspace(0, 10, 11)), "spread": (0.5, 1.0, 2.0)}, 3, similarity)


def losses(run, aim, criterion):
    """Return the expected loss of a run under another criterion."""
    return replace(run, rule=replace(run.rule, aim=aim, criterion=criterion)).expected_loss()


def test_function_model_losses_equal_those_of_same_grid():
    rng, levels = np.random.default_rng(), LEVELS[::5]
    grid, general = QuestPlus(levels, GRID).begin(), QuestPlus(levels, GENERAL).begin()
    for _ in range(2):
        for aim, criterion in itertools.product(("parameters", "threshold"), ("entropy", "variance")):
            ours, theirs = (losses(run, aim, criterion) for run in (grid, general))
            np.testing.assert_allclose(ours, theirs, atol=1e-9)
        answer, level = bool(rng.random() < 0.7), float(rng.uniform(0, 40))
        grid, general = grid.after(answer, level), general.after(answer, level)
    np.testing.assert_allclose(grid.posterior, general.posterior, atol=1e-12)


@pytest.mark.parametrize("levels", [LEVELS, (0.0, 3.0, 3.5, 20.0), tuple(np.linspace(-5, 45, 27))])
def test_diagonal_costs_equal_full_table_costs(levels):
    weights = np.random.default_rng().dirichlet(np.ones(math.prod(GRID.size)))
    chances = np.stack([[np.exp(GRID.log_likelihood(level, r)) for level in levels] for r in (0, 1)])
    expected = (chances * np.log(np.maximum(chances, 1e-300))).sum(axis=0) @ weights
    np.testing.assert_allclose(GRID.likelihoods(levels).certainty(weights), expected, rtol=1e-10)


@pytest.mark.parametrize("levels", [LEVELS, tuple(np.linspace(0, 40, 21)), (0.0, 3.0, 3.5, 20.0)])
@pytest.mark.parametrize("outcome", [0, 1])
def test_posterior_after_answer_at_candidate_equals_model_likelihood(levels, outcome):
    rule = QuestPlus(levels, GRID)
    for level in levels:
        expected = np.exp(GRID.log_likelihood(level, outcome)).reshape(GRID.size)
        np.testing.assert_allclose(rule.after(outcome, level).posterior, expected / expected.sum(), rtol=1e-11)


@pytest.mark.parametrize("aim", ["parameters", "threshold"])
@pytest.mark.parametrize("criterion", ["entropy", "variance"])
@given(answers=st.lists(st.tuples(st.integers(0, 2), st.floats(-2, 12)), max_size=12))
@settings(max_examples=15)
def test_three_outcome_loss_equals_mean_posterior_loss(aim, criterion, answers):
    rule = QuestPlus((0.0, 2.5, 5.0, 10.0), THREE, aim=aim, criterion=criterion, n_trials=100).begin()
    for answer, level in answers:
        rule = rule.after(answer, level)
    level = 2.5
    chances = [float(np.exp(THREE.log_likelihood(level, r)) @ rule.posterior.ravel()) for r in range(3)]
    expected = sum(p * loss(rule.after(r, level)) for r, p in enumerate(chances))
    assert rule.expected_loss()[1] == pytest.approx(expected, rel=1e-9, abs=1e-12)


def loss(rule):
    """Return entropy or variance of a posterior from its definition."""
    if rule.rule.criterion == "entropy":
        weights = rule.posterior.ravel() if rule.rule.aim == "parameters" else rule.posterior.sum(axis=1)
        return float(-(weights[weights > 0] * np.log(weights[weights > 0])).sum())
    if rule.rule.aim == "threshold":
        return rule.threshold_sd**2
    return sum(variance(rule, name) / np.var(values) for name, values in rule.rule.grid.parameters.items())


def variance(rule, name):
    away = np.asarray(rule.rule.grid.parameters[name]) - rule.mean(name)
    return float(rule.marginal(name) @ away**2)


@pytest.mark.parametrize("answer", [-1, 3, 1.5, None, "1"])
def test_three_outcome_rule_rejects_other_answers(answer):
    rule = QuestPlus((0.0, 5.0), THREE)
    with pytest.raises(InvalidParameter, match="expected a whole number from 0 to 2"):
        rule.after(answer)
    assert [rule.after(kept).responses for kept in (0, 1, np.int64(2))] == [(0,), (1,), (2,)]


def test_three_outcome_rule_recovers_true_centre():
    rng, found = np.random.default_rng(), []
    for _ in range(15):
        rule = QuestPlus(tuple(np.linspace(0, 10, 21)), THREE, n_trials=60)
        while not rule.finished:
            chances = [float(np.exp(similarity(rule.level, r, centre=6.0, spread=1.0))) for r in range(3)]
            rule = rule.after(int(rng.choice(3, p=chances)))
        found.append(rule.mean("centre"))
    assert abs(np.mean(found) - 6.0) <= 3.89 * np.std(found) / math.sqrt(len(found)) + 0.05


def test_weibull_on_log_levels_equals_gumbel():
    widths = {"n_levels": 21, "width_low": 0.5, "width_high": 2.0, "n_widths": 3}
    log = QuestPlusSettings(0.1, 10.0, spacing="log", shape="weibull", **widths).procedure()
    linear = QuestPlusSettings(math.log(0.1), math.log(10), **widths).procedure()
    for answer in (1, 1, 0, 1, 0, 0, 1):
        assert math.log(log.level) == pytest.approx(linear.level, abs=1e-9)
        log, linear = log.after(answer), linear.after(answer)
    np.testing.assert_allclose(log.posterior, linear.posterior, atol=1e-10)


def test_psi_grid_has_twenty_geometrically_spaced_deviations():
    """Kontsevich and Tyler (1999); a normal is 2 * 1.6449 standard deviations wide from 0.05 to 0.95."""
    widths = PsiSettings(low=0.0, high=40.0, n_levels=5, sd_low=1.0, sd_high=8.0).procedure().grid.widths
    np.testing.assert_allclose(np.array(widths) / 3.2897072539, np.geomspace(1, 8, 20), rtol=1e-9)


def test_width_prior_is_log_normal_with_given_factor():
    settings = QuestPlusSettings(0.0, 40.0, 11, width_low=2.0, width_high=32.0, n_widths=5, width_prior_factor=2.0)
    weights = settings.procedure().begin().marginal("width")
    np.testing.assert_allclose(weights / weights[2], np.exp([-2.0, -0.5, 0.0, -0.5, -2.0]))


def test_zero_prior_weight_stays_zero():
    rule = QuestPlus(LEVELS, GRID, prior={"width": (0.0, 1.0, 1.0)}).after(1).after(0)
    assert rule.marginal("width")[0] == 0
    assert rule.marginal("width").sum() == pytest.approx(1)


def test_prior_equals_answers_with_same_likelihood():
    grid = ParameterGrid(GRID.thresholds, (8.0,), (0.5,), (0.02,))
    answered = QuestPlus(LEVELS, grid).after(1, 20.0).after(0, 10.0)
    prior = tuple(np.exp(grid.log_likelihood(20.0, 1) + grid.log_likelihood(10.0, 0)))
    taught = QuestPlus(LEVELS, grid, prior={"threshold": prior}).begin()
    np.testing.assert_allclose(taught.posterior, answered.posterior)


@pytest.mark.parametrize("answers", [[1, 0] * 60, [1] * 150 + [0] * 150, [0] * 150 + [1] * 150])
def test_underflowing_posterior_equals_fifty_digit_reference(answers):
    """In linear space, cells of these runs fall below 1e-308 temporarily."""
    grid = ParameterGrid((0.0, 15.0, 30.0), (3.0, 12.0), (0.0,), (1e-12, 0.01), shape="logistic")
    levels = [float(x) for x in np.linspace(-20, 50, len(answers))]
    rule = QuestPlus((0.0, 30.0), grid, n_trials=10**4)
    for answer, level in zip(answers, levels, strict=True):
        rule = rule.after(answer, level)
    exact = exact_log_weights(grid, answers, levels)
    assert min(exact) < -700
    found = rule.state.log_weights
    hard_case("QUEST+ with weights below 1e-308", found, exact, 1e-11, against="50 digits", floor=10)


def exact_log_weights(grid, answers, levels):
    mpmath.mp.dps = 50
    cells = [(t, w, lapse) for t in grid.thresholds for w in grid.widths for lapse in grid.lapse_rates]
    totals = [
        mpmath.fsum(exact_log_chance(*cell, x, r) for r, x in zip(answers, levels, strict=True)) for cell in cells
    ]
    norm = mpmath.log(mpmath.fsum(mpmath.e ** (total - max(totals)) for total in totals)) + max(totals)
    return [float(total - norm) for total in totals]


def exact_log_chance(threshold, width, lapse, level, answer):
    z = (mpmath.mpf(level) - threshold) / width * 2 * mpmath.log(mpmath.mpf(19))
    s, rest = 1 / (1 + mpmath.exp(-z)), 1 / (1 + mpmath.exp(z))
    span = 1 - mpmath.mpf(lapse)
    return mpmath.log(span * s if answer else lapse + span * rest)


def test_ten_thousand_contradictory_answers_stay_finite():
    grid = ParameterGrid((0.0, 20.0, 40.0), (0.5, 8.0), (0.0,), (1e-6, 0.02))
    rule = QuestPlus((0.0, 20.0, 40.0), grid, n_trials=10**6)
    for n in range(10_000):
        rule = rule.after(n % 2, 40.0 if n % 2 == 0 else 0.0)
    assert np.isfinite(rule.posterior).all()
    assert np.isfinite(rule.state.log_weights).all()
    for aim, criterion in itertools.product(("parameters", "threshold"), ("entropy", "variance")):
        assert np.isfinite(losses(rule, aim, criterion)).all()
    exact_case("10 000 contradictory answers", against="all finite")


def test_remark_explains_answers_impossible_on_grid():
    grid = ParameterGrid((10.0, 20.0), (0.1,), (0.0,), (0.0,), shape="normal")
    rule = QuestPlus((0.0, 30.0), grid, n_trials=10).after(0, delivered=1e200)
    assert rule.remark == (
        "QuestPlus.grid: found answer 0 at level 1e+200 in trial 1, which with the answers before it no cell of the "
        "grid allows, expected a grid that can; give it guess and lapse rates above 0 or a wider range"
    )
    assert (rule.ending, rule.threshold) == ("aborted", None)
    assert np.isfinite(rule.posterior).all()
    exact_case("an answer that no cell allows", against="one sentence")


def test_equal_answers_on_fine_grid_end_as_censored():
    grid = ParameterGrid(tuple(np.linspace(0, 40, 401)), (10.0,), (0.5,), (0.02,))
    rule = QuestPlus(LEVELS, grid, n_trials=15)
    while not rule.finished:
        rule = rule.after(1)
    assert (rule.ending, rule.threshold) == ("censored_below", None)
    assert rule.remark == "QuestPlus: the first threshold of the grid is the likeliest; the true one may lie below it"
    assert rule.posterior.max() < 0.5


WEIBULL = ParameterGrid((1.0,), (1.0,), shape="weibull")


def settings_of(low, high, **options):
    return QuestPlusSettings(low, high, 11, 1.0, 2.0, **options).procedure()


def summing_to(total):
    return FunctionModel({"bias": (0.5,)}, 2, lambda level, outcome, bias: np.log(total * bias))


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: QuestPlus((0.0, 1.0), summing_to(0.9)), "that add up to 0.9, expected a sum of 1 over all outcomes"),
        (lambda: FunctionModel({}, 2, similarity), "FunctionModel.parameters: found none"),
        (lambda: FunctionModel({"a": ()}, 2, similarity), r"FunctionModel.parameters\['a'\]: found none"),
        (lambda: FunctionModel({"a": (1.0,)}, 1, similarity), "FunctionModel.n_outcomes: found 1, expected a whole"),
        (lambda: QuestPlus((0.0, 5.0), THREE).after(3), "found the response 3, expected a whole number from 0 to 2"),
        (lambda: QuestPlus(LEVELS, GRID, prior={"slope": (1.0,)}), "QuestPlus.prior: found 'slope', expected"),
        (lambda: QuestPlus(LEVELS, GRID, prior={"width": (1.0,)}), r"QuestPlus.prior\['width'\]: found 1 weights"),
        (lambda: QuestPlus(LEVELS, GRID, prior={"width": (0.0,) * 3}), "expected 3 finite numbers from 0, not all 0"),
        (lambda: QuestPlus(LEVELS, GRID).begin().marginal("slope"), "QuestPlus.marginal: found 'slope', expected one"),
        (lambda: ParameterGrid((0.0,), (1.0,), shape="weibull"), r"ParameterGrid.thresholds\[0\]: found 0.0"),
        (lambda: WEIBULL.log_likelihood(-1.0, 1), "ParameterGrid: found the level -1, expected levels from 0 on"),
        (lambda: settings_of(0.0, 1.0, spacing="log"), "QuestPlusSettings.low: found 0, expected above 0"),
        (lambda: settings_of(1.0, 0.0), "QuestPlusSettings.low: found 1, expected less than high"),
        (lambda: settings_of(0.0, 1.0, width_prior_factor=1.0), "width_prior_factor: found 1.0, expected a number"),
    ],
)
def test_invalid_model_is_refused(build, message):
    with pytest.raises(InvalidParameter, match=message):
        build()


@pytest.mark.parametrize(
    ("low", "high", "n", "found"),
    [
        (math.nan, 1.0, 3, "grid.low: found nan"),
        (0.0, math.inf, 3, "grid.high: found inf"),
        (0.0, 1.0, 0, "grid.n: found 0"),
        (1.0, 1.0, 2, "grid.low: found 1, expected less than high"),
        (2.0, 1.0, 2, "grid.low: found 2, expected less than high"),
    ],
)
def test_values_that_make_no_rising_grid_are_refused(low, high, n, found):
    with pytest.raises(InvalidParameter, match=found):
        grid_values("grid", "linear", low=low, high=high, n=n)
