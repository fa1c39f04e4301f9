"""Staircases, constant stimuli (also compared with PsychoPy), and the method of limits."""

import re
import warnings
from dataclasses import replace

import numpy as np
import pytest
from followed_rule import follow
from hypothesis import given, strategies as st
from scipy.stats import norm

from tactometry.errors import InvalidParameter
from tactometry.protocols import ConstantStimuli, MethodOfLimits, Staircase, WeightedStaircase


def psychopy_staircase(**options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from psychopy.data import StairHandler
    return StairHandler(stepType="lin", autoLog=False, **options)


def psychopy_levels(answers, **options):
    handler = psychopy_staircase(**options)
    levels = []
    for answer in answers:
        levels.append(next(handler))
        handler.addResponse(int(answer))
        if handler.finished:
            break
    return levels, handler


@pytest.mark.slow
@given(
    answers=st.lists(st.booleans(), min_size=1, max_size=80),
    n_up=st.integers(1, 3),
    n_down=st.integers(1, 4),
    steps=st.lists(st.sampled_from([1.0, 2.0, 4.0, 8.0]), min_size=2, max_size=4),
    initial_rule=st.booleans(),
)
def test_sequences_equal_those_of_psychopy(answers, n_up, n_down, steps, initial_rule):
    of_rule = {"n_up": n_up, "n_down": n_down, "initial_rule": initial_rule, "n_reversals": 1000, "n_trials": 1000}
    ours, end = follow(Staircase(start=30.0, steps=tuple(steps), low=-1000.0, high=1000.0, **of_rule), answers)
    of_handler = {"nUp": n_up, "nDown": n_down, "applyInitialRule": initial_rule, "nReversals": 1000, "nTrials": 1000}
    theirs, handler = psychopy_levels(answers, startVal=30.0, stepSizes=list(steps), **of_handler)
    assert ours == theirs
    assert list(end.reversals) == handler.reversalIntensities


@pytest.mark.slow
@given(answers=st.lists(st.booleans(), min_size=1, max_size=60), n_down=st.integers(1, 3))
def test_levels_at_bounds_equal_psychopy_until_censoring(answers, n_down):
    rule = Staircase(4.0, (4.0, 2.0), low=0.0, high=10.0, n_down=n_down, n_reversals=1000, n_trials=1000)
    ours, _ = follow(rule, answers)
    options = {"stepSizes": [4.0, 2.0], "nReversals": 1000, "nTrials": 1000, "nDown": n_down, "minVal": 0, "maxVal": 10}
    theirs, _ = psychopy_levels(answers, startVal=4.0, **options)
    assert ours == theirs[: len(ours)]


@pytest.mark.slow
def test_staircase_ends_at_first_count_unlike_psychopy():
    answers = [True, False] * 40
    options = {"startVal": 10.0, "stepSizes": [2.0, 1.0], "nReversals": 6, "nTrials": 30, "nDown": 1}
    theirs, _ = psychopy_levels(answers, **options)
    rule = Staircase(start=10.0, steps=(2.0, 1.0), low=-100.0, high=100.0, n_down=1, n_reversals=6, n_trials=30)
    ours, end = follow(rule, answers)
    assert (len(theirs), len(ours), end.ending) == (30, 7, "converged")


@pytest.mark.slow
def test_staircase_steps_from_delivered_level_unlike_psychopy():
    handler = psychopy_staircase(startVal=10.0, stepSizes=[2.0, 1.0], nTrials=9, nDown=1)
    next(handler)
    handler.addResponse(1, intensity=7.0)
    rule = Staircase(start=10.0, steps=(2.0, 1.0), low=-100.0, high=100.0, n_down=1).after(1, delivered=7.0)
    assert (next(handler), rule.level, rule.delivered) == (8.0, 5.0, (7.0,))


@pytest.mark.parametrize(("answer", "ended"), [(0, "censored_above"), (1, "censored_below")])
def test_run_pinned_at_bound_is_censored_without_threshold(answer, ended):
    rule = Staircase(start=20.0, steps=(8.0, 4.0), low=0.0, high=40.0, n_down=1, n_at_bound=3)
    levels, end = follow(rule, [answer] * 100)
    assert end.ending == ended
    assert end.threshold is None
    assert levels[-3:] == [40.0 if answer == 0 else 0.0] * 3


def test_run_leaving_its_ceiling_is_not_censored():
    rule = Staircase(start=40.0, steps=(2.0,), low=0.0, high=40.0, n_down=1, n_at_bound=3, n_reversals=4)
    _, end = follow(rule, [0, 0, 1, 0, 0, 1, 0, 0, 1])
    assert end.ending == "converged"


def test_a_censored_run_with_reversals_has_no_threshold():
    rule = Staircase(start=10.0, steps=(4.0,), low=0.0, high=40.0, n_down=1, n_reversals=20, n_at_bound=3)
    _, rule = follow(rule, (1, 0, 1, 0, 1, 0, 1, 1, 1, 1, 1, 1, 1))
    assert len(rule.reversals) >= 4
    assert (rule.ending, rule.threshold) == ("censored_below", None)


def test_responses_at_bound_count_only_in_succession():
    rule = Staircase(start=40.0, steps=(2.0,), low=0.0, high=40.0, n_down=1, n_reversals=99, n_at_bound=3)
    levels, end = follow(rule, (0, 0, 1, 0, 0, 0, 0, 0))
    assert (len(levels), end.ending) == (7, "censored_above")


@pytest.mark.parametrize(
    ("n_reversals", "answers", "reversals", "n_kept"),
    [
        (5, [1, 0, 1, 0, 1, 0, 1, 0], (6.0, 8.0, 6.0, 8.0, 6.0), 2),
        (5, [1, 0, 1, 0, 0, 1, 1, 0], (6.0, 8.0, 6.0, 10.0, 6.0), 2),
        (6, [1, 0, 1, 0, 0, 1, 1, 0, 1, 0], (6.0, 8.0, 6.0, 10.0, 6.0, 8.0), 4),
    ],
)
def test_threshold_averages_even_number_of_late_reversals(n_reversals, answers, reversals, n_kept):
    rule = Staircase(start=10.0, steps=(4.0, 2.0), low=0.0, high=40.0, n_down=1, n_reversals=n_reversals)
    _, end = follow(rule, answers)
    assert end.reversals == reversals
    assert end.threshold == sum(reversals[-n_kept:]) / n_kept


@pytest.mark.parametrize(
    ("up", "down", "n_down", "target"),
    [
        (3.0, 1.0, 1, 0.75),
        (1.0, 0.2845, 1, 0.7785),
        (1.0, 0.5488, 2, 0.8035),
        (1.0, 0.7393, 3, 0.8315),
        (1.0, 0.8415, 4, 0.8584),
        (1.0, 1.0, 2, 0.7071),
    ],
)
def test_the_targets_of_weighted_staircases(up, down, n_down, target):
    """Kaernbach (1991); Garcia-Perez (1998), with the ratios of his table."""
    rule = WeightedStaircase(0.0, (up,), (down,), low=-20.0, high=20.0, n_down=n_down)
    assert rule.target == pytest.approx(target, abs=6e-5)


def test_weighted_staircase_with_equal_steps_equals_staircase():
    answers = np.random.default_rng().random(60) < 0.7
    options = {"start": 10.0, "low": 0.0, "high": 40.0, "n_down": 2, "n_reversals": 9}
    weighted = WeightedStaircase(steps_up=(4.0, 2.0), steps_down=(4.0, 2.0), **options)
    ours, _ = follow(weighted, answers)
    plain, _ = follow(Staircase(steps=(4.0, 2.0), initial_rule=False, **options), answers)
    assert ours == plain


def test_constant_stimuli_repeats_contain_all_levels_in_changing_order():
    rule = ConstantStimuli(levels=(1.0, 2.0, 3.0, 4.0), repeats=50).begin(np.random.default_rng())
    levels, end = follow(rule, [1, 0] * 200)
    repeats = [tuple(levels[n : n + 4]) for n in range(0, 200, 4)]
    assert all(sorted(repeat) == [1.0, 2.0, 3.0, 4.0] for repeat in repeats)
    assert len(set(repeats)) > 1
    assert end.ending == "trials"


ENDLESS = {"n_reversals": 10**9, "n_trials": 10**9, "n_at_bound": 10**9}


def chance(level):
    return 0.5 + 0.5 * norm.cdf(level)


def bare(rule):
    """Return the state of a run without its history."""
    asked = round(rule.level, 6) + 0.0
    return replace(rule, delivered=(), responses=(), marks=(), state=(asked, 0, rule.streak, 0, 0))


def key(rule):
    return rule.level, rule.streak


def stationary(rule):
    """Return mean level and mean chance of success of an endless run."""
    first = bare(rule.after(1))
    states, open_, moves = {key(first): 0}, [first], []
    while open_:
        at = open_.pop()
        for answer, weight in ((1, chance(at.level)), (0, 1 - chance(at.level))):
            then = bare(at.after(answer))
            if key(then) not in states:
                states[key(then)] = len(states)
                open_.append(then)
            moves.append((states[key(at)], states[key(then)], weight))
    transition = np.zeros((len(states), len(states)))
    for start, end, weight in moves:
        transition[start, end] += weight
    levels = np.array([level for level, _ in states])
    balance = np.vstack([(transition.T - np.eye(len(states)))[1:], np.ones(len(states))])
    shares = np.linalg.solve(balance, np.eye(len(states))[-1])
    return shares @ levels, shares @ chance(levels)


TRANSFORMED = {
    2: {0.1: (-0.22968, 0.70671), 0.25: (-0.25307, 0.70617), 0.5: (-0.30290, 0.70542), 1.0: (-0.43636, 0.70432)},
    3: {0.1: (0.22572, 0.79321), 0.25: (0.23255, 0.79252), 0.5: (0.24237, 0.79147), 1.0: (0.25537, 0.78972)},
}
WEIGHTED = {0.1: (-0.00227, 0.75000), 0.25: (-0.01500, 0.75000), 0.5: (-0.05765, 0.75000), 1.0: (-0.17672, 0.75005)}


@pytest.mark.parametrize("n_down", TRANSFORMED)
@pytest.mark.parametrize("step", [0.1, 0.25, 0.5, 1.0])
def test_a_transformed_staircase_settles_at_the_computed_mean(n_down, step):
    rule = Staircase(0.0, (step,), -12.0, 12.0, n_down=n_down, initial_rule=False, **ENDLESS)
    assert stationary(rule) == pytest.approx(TRANSFORMED[n_down][step], abs=6e-6)


@pytest.mark.parametrize("step", [0.1, 0.25, 0.5, 1.0])
def test_a_weighted_staircase_settles_at_the_computed_mean(step):
    rule = WeightedStaircase(0.0, (3 * step,), (step,), -12.0, 12.0, **ENDLESS)
    assert stationary(rule) == pytest.approx(WEIGHTED[step], abs=6e-6)


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


def staircase(**options):
    return Staircase(**({"start": 20.0, "steps": (2.0,), "low": 0.0, "high": 40.0} | options))


def weighted(up, down):
    return WeightedStaircase(0.0, up, down, low=-12.0, high=12.0)


def limits(**options):
    return MethodOfLimits(**({"low": 0.0, "high": 10.0, "step": 2.0, "n_series": 4} | options))


RANGE = "expected above 0 and at most the range of levels"


@pytest.mark.parametrize(
    ("build", "options", "message"),
    [
        (staircase, {"low": 5.0, "high": 5.0}, "Staircase.low: found 5, expected less than high (5)"),
        (staircase, {"start": 99.0}, "Staircase.start: found 99, expected a level between low (0) and high (40)"),
        (staircase, {"steps": ()}, "Staircase.steps: found none, expected at least one"),
        (staircase, {"steps": (0.0,)}, f"Staircase.steps[0]: found 0, {RANGE} (40)"),
        (staircase, {"steps": (2.0, 41.0)}, f"Staircase.steps[1]: found 41, {RANGE} (40)"),
        (staircase, {"n_down": 0}, "Staircase.n_down: found 0, expected a whole number, at least 1"),
        (weighted, {"up": (3.0, 1.0), "down": (1.0,)}, "WeightedStaircase.steps_up: found 2 steps and 1 steps_down"),
        (weighted, {"up": (0.0,), "down": (1.0,)}, f"WeightedStaircase.steps_up[0]: found 0, {RANGE} (24)"),
        (weighted, {"up": (3.0, 1.0), "down": (1.0, 99.0)}, f"WeightedStaircase.steps_down[1]: found 99, {RANGE} (24)"),
        (limits, {"step": 0.0}, f"MethodOfLimits.step: found 0 from low 0 to high 10, {STEPS}"),
        (limits, {"high": 0.0}, f"MethodOfLimits.step: found 2 from low 0 to high 0, {STEPS}"),
        (limits, {"direction": "up"}, "MethodOfLimits.direction: found 'up', expected one of ascending, descending"),
        (limits, {"n_series": 0}, f"n_series: found 0 series over 5 steps with starts up to 0 {SERIES}"),
        (limits, {"n_start_steps": 5}, f"n_series: found 4 series over 5 steps with starts up to 5 {SERIES}"),
    ],
)
def test_impossible_arguments_are_refused(build, options, message):
    with pytest.raises(InvalidParameter, match=re.escape(message)):
        build(**options)
