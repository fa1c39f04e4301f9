"""QUEST+: published sequence, peer packages, edges and efficiency."""

import math

import numpy as np
import pytest
from followed_rule import follow
from hard_cases import exact_case, hard_case
from hypothesis import given, settings, strategies as st
from scipy.stats import norm

from tactometry.errors import InvalidParameter
from tactometry.protocols import QuestPlus
from tactometry.protocols.bayesian.parameter_grid import ParameterGrid
from tactometry.psychometric import shape_named

LEVELS = tuple(float(x) for x in range(-40, 1))


def test_the_published_sequence():
    """Watson (2017), example 1, as in the tests of the package questplus.

    His Weibull in decibels is 1 - l - (1 - g - l) exp(-10^(slope (x - t) / 20)).
    """
    answers = "CCCC" + "II" + "C" * 8 + "I" + "CC" + "I" + "CC" + "I" + "C" * 11
    expected = [-18, -22, -25, -28, -30, -22, -13, -15, -16, -18, -19, -20, -21, -22, -23, -19, -20, -20, -18, -18]
    expected += [-19, -17, -17, -18, -18, -18, -19, -19, -19, -19, -19, -19]
    scale = 20 / (3.5 * math.log(10))
    shift = scale * math.log(math.log(2))  # from his threshold, the 63 % point, to ours, the half
    width = shape_named("gumbel").z_width * scale
    grid = ParameterGrid(tuple(x + shift for x in LEVELS), (width,), (0.5,), (0.02,))
    levels, rule = follow(QuestPlus(LEVELS, grid, n_trials=100), [a == "C" for a in answers])
    assert levels == expected
    assert grid.thresholds[int(rule.posterior.sum(axis=1).argmax())] - shift == pytest.approx(-20)
    assert rule.threshold - shift == pytest.approx(-20.3936, abs=1e-4)


def small(aim="parameters", **options):
    grid = ParameterGrid(tuple(np.linspace(0, 40, 21)), (4.0, 8.0, 16.0), (0.5,), (0.0, 0.02, 0.06))
    return QuestPlus(tuple(np.linspace(-5, 45, 26)), grid, aim=aim, **options)


@pytest.mark.parametrize("aim", ["parameters", "threshold"])
@given(answers=st.lists(st.booleans(), min_size=1, max_size=30))
@settings(max_examples=20)
def test_expected_entropy_equals_mean_entropy_of_posteriors(aim, answers):
    _, rule = follow(small(aim, n_trials=100), answers)
    n = len(rule.rule.levels) // 2
    level = rule.rule.levels[n]
    yes = float(np.exp(rule.rule.grid.log_likelihood(level, 1)) @ rule.posterior.ravel())
    expected = yes * entropy(rule.after(1, level), aim) + (1 - yes) * entropy(rule.after(0, level), aim)
    found = rule.expected_loss()[n]
    hard_case("expected entropy of any answers (nat)", found, expected, 1e-12, against="the posteriors", floor=1)


def entropy(rule, aim):
    weights = rule.posterior.ravel() if aim == "parameters" else rule.posterior.sum(axis=1)
    return float(-(weights[weights > 0] * np.log(weights[weights > 0])).sum())


@given(answers=st.lists(st.tuples(st.booleans(), st.floats(-5, 45)), min_size=2, max_size=20))
@settings(max_examples=30)
def test_posterior_is_independent_of_answer_order(answers):
    forth, back = small(n_trials=100), small(n_trials=100)
    for (answer, level), (other, its_level) in zip(answers, reversed(answers), strict=True):
        forth, back = forth.after(answer, delivered=level), back.after(other, delivered=its_level)
    hard_case("answers in another order", forth.posterior, back.posterior, 1e-12, against="this order", floor=1)


def test_a_delivered_level_off_the_grid_counts():
    assert not np.array_equal(small().after(1, delivered=20.123).posterior, small().after(1, delivered=20.0).posterior)


@pytest.mark.parametrize(("answer", "ended"), [(1, "censored_below"), (0, "censored_above")])
def test_a_hundred_equal_answers_end_as_censored(answer, ended):
    _, rule = follow(small(n_trials=100), [answer] * 100)
    assert (rule.ending, rule.threshold) == (ended, None)
    assert np.isfinite(rule.posterior).all()
    exact_case("100 equal answers to QUEST+", against="censored, no number")


@pytest.mark.parametrize(("answer", "ended"), [(1, "censored_below"), (0, "censored_above")])
def test_both_thresholds_are_edges_on_two_point_grid(answer, ended):
    rule = QuestPlus((10.0, 20.0), ParameterGrid((10.0, 20.0), (5.0,), (0.5,)), n_trials=2)
    assert follow(rule, [answer] * 2)[1].ending == ended


def test_run_converges_at_requested_standard_deviation():
    rng = np.random.default_rng()
    rule = small("threshold", n_trials=2000, sd_stop=1.5)
    while not rule.finished:
        rule = rule.after(bool(rng.random() < 0.5 + 0.5 * norm.cdf((rule.level - 20) / 3)))
    assert rule.ending == "converged"
    assert rule.threshold_sd <= 1.5


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: ParameterGrid((), (1.0,)), "ParameterGrid.thresholds: found none"),
        (lambda: ParameterGrid((1.0,), (0.0,)), r"ParameterGrid.widths\[0\]: found 0.0, expected a finite number bet"),
        (lambda: ParameterGrid((1.0, 1.0), (1.0,)), r"ParameterGrid.thresholds\[1\]: found 1 twice"),
        (lambda: ParameterGrid((1.0,), (1.0,), (0.6,), (0.5,)), "found guess and lapse rates that add up to 1.1"),
        (lambda: ParameterGrid((1.0,), (1.0,), shape="norml"), "norml"),
        (lambda: QuestPlus((1.0,), ParameterGrid((1.0,), (1.0,))), "QuestPlus.levels: found 1 levels"),
        (lambda: QuestPlus((1.0, 1.0), ParameterGrid((1.0,), (1.0,))), "QuestPlus.levels: found 2 levels, 1 of them"),
        (lambda: small().after(1, delivered=math.nan), "found the delivered level nan"),
        (lambda: small(n_trials=0), "QuestPlus.n_trials: found 0, expected a whole number"),
        (lambda: small(criterion="entropie"), "QuestPlus.criterion: found 'entropie', .*did you mean 'entropy'"),
    ],
)
def test_an_impossible_grid_is_refused(build, message):
    with pytest.raises(InvalidParameter, match=message):
        build()
