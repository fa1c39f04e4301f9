"""The method of limits: series, transitions and missing bounds."""

import numpy as np
import pytest
from followed_rule import follow
from hypothesis import given, strategies as st
from scipy.stats import norm

from tactometry.errors import InvalidParameter
from tactometry.protocols import MethodOfLimits

RULE = MethodOfLimits(low=0.0, high=10.0, step=2.0, n_series=4)


def test_alternating_series_fall_then_rise():
    levels, rule = follow(RULE, [1, 1, 0, 0, 0, 1, 1, 0, 0, 1])
    assert levels == [10.0, 8.0, 6.0, 0.0, 2.0, 4.0, 10.0, 8.0, 0.0, 2.0]
    assert rule.transitions == (7.0, 3.0, 9.0, 1.0)
    assert (rule.ending, rule.threshold) == ("trials", 5.0)


@pytest.mark.parametrize(
    ("direction", "answers", "levels", "transitions"),
    [
        ("ascending", [0, 1, 0, 0, 1], [0.0, 5.0, 0.0, 5.0, 10.0], (2.5, 7.5)),
        ("descending", [1, 0, 1, 1, 0], [10.0, 5.0, 10.0, 5.0, 0.0], (7.5, 2.5)),
    ],
)
def test_series_go_one_way(direction, answers, levels, transitions):
    rule = MethodOfLimits(low=0.0, high=10.0, step=5.0, n_series=2, direction=direction)
    asked, rule = follow(rule, answers)
    assert (asked, rule.transitions) == (levels, transitions)


def test_transition_lies_between_delivered_levels():
    rule = MethodOfLimits(low=0.0, high=10.0, step=5.0, n_series=1, direction="ascending")
    rule = rule.after(0, delivered=0.5).after(1, delivered=4.5)
    assert (rule.threshold, rule.delivered) == (2.5, (0.5, 4.5))


@pytest.mark.parametrize("direction", ["ascending", "descending", "alternating"])
@pytest.mark.parametrize(("answer", "ended"), [(1, "censored_below"), (0, "censored_above")])
def test_equal_answers_end_as_censored(direction, answer, ended):
    rule = MethodOfLimits(low=0.0, high=10.0, step=2.0, n_series=4, direction=direction)
    while not rule.finished:
        rule = rule.after(answer)
    assert (rule.ending, rule.threshold) == (ended, None)


def test_series_that_contradict_each_other_have_no_bound():
    """Strong levels are never felt, weak ones always: no bound is valid."""
    _, rule = follow(RULE, [0, 1, 0, 1])
    assert rule.transitions == (None,) * 4
    assert (rule.ending, rule.threshold) == ("aborted", None)


def test_threshold_exists_with_half_of_series_without_transition():
    _, rule = follow(RULE, [0, 0, 1, 0, 0, 1])
    assert rule.transitions == (None, 1.0, None, 1.0)
    assert (rule.ending, rule.threshold) == ("trials", 1.0)


def test_starts_are_drawn_inwards_by_whole_steps():
    rule = MethodOfLimits(low=0.0, high=10.0, step=1.0, n_series=200, n_start_steps=3, direction="ascending")
    starts = {rule.level for rule in firsts(rule.begin(np.random.default_rng()))}
    assert starts == {0.0, 1.0, 2.0, 3.0}


def firsts(rule):
    """Return the rule at the start of each series, if every answer is 1."""
    while not rule.finished:
        yield rule
        rule = rule.after(1)


@given(answers=st.lists(st.booleans(), max_size=80))
def test_levels_lie_whole_steps_from_the_lowest(answers):
    rule = MethodOfLimits(low=-1.0, high=1.0, step=0.3, n_series=30)
    for answer in answers:
        assert -1 <= rule.level <= 1
        assert (rule.level + 1) / 0.3 == pytest.approx(round((rule.level + 1) / 0.3))
        rule = rule if rule.finished else rule.after(answer)


def test_alternating_limits_recover_the_half_point():
    rng, found = np.random.default_rng(), []
    for _ in range(40):
        rule = MethodOfLimits(low=-6.0, high=6.0, step=0.5, n_series=10)
        while not rule.finished:
            rule = rule.after(bool(rng.random() < norm.cdf(rule.level - 0.5)))
        found.append(rule.threshold)
    assert abs(np.mean(found) - 0.5) <= 3.89 * np.std(found) / np.sqrt(len(found)) + 0.05


STEPS = "expected above 0, low below high, and at most 10000 steps between them"
SERIES = "steps inwards, expected at least one series of at least two levels"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"step": 0.0}, f"step: found 0 from low 0 to high 10, {STEPS}"),
        ({"high": 0.0}, f"step: found 2 from low 0 to high 0, {STEPS}"),
        ({"direction": "up"}, "direction: found 'up', expected one of ascending, descending, alternating"),
        ({"n_series": 0}, f"n_series: found 0 series over 5 steps with starts up to 0 {SERIES}"),
        ({"n_start_steps": 5}, f"n_series: found 4 series over 5 steps with starts up to 5 {SERIES}"),
    ],
)
def test_impossible_limits_are_refused(options, message):
    with pytest.raises(InvalidParameter) as refused:
        MethodOfLimits(**({"low": 0.0, "high": 10.0, "step": 2.0, "n_series": 4} | options))
    assert str(refused.value) == f"MethodOfLimits.{message}"
