"""Where staircases settle, exactly: the stationary distribution of the very states that the procedures go through."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from tactometry.protocols import Staircase, WeightedStaircase

ENDLESS = {"n_reversals": 10**9, "n_trials": 10**9, "n_at_bound": 10**9}


def chance(level):
    return 0.5 + 0.5 * norm.cdf(level)


def bare(rule):
    """The run without its history: what decides the next levels when steps are fixed."""
    asked = round(rule.level, 6) + 0.0
    return replace(rule, delivered=(), responses=(), marks=(), state=(asked, 0, rule.streak, 0, 0))


def key(rule):
    return rule.level, rule.streak


def stationary(rule):
    """Mean level and mean chance of a correct answer over the trials of an endless run."""
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
