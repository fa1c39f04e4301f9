"""A simulated participant who identifies alternatives by sensation."""

from math import inf, sqrt

import numpy as np
import pytest
from scipy.stats import norm

from tactometry.observers.decisions import Felt, locate
from tactometry.observers.signal_detection import SignalDetectionObserver
from tactometry.protocols.tasks.localisation import Localisation
from tactometry.protocols.tasks.task import Alternative, Presentation
from tactometry.protocols.tasks.touch import Pressing
from tactometry.session.answer import Chosen, Touched
from tactometry.session.request import Choose

AT_1E_4 = 3.891
"""Two-sided normal quantile at 1e-4, in standard errors."""
KEEN = SignalDetectionObserver(lapse_rate=0.0)


def share_right(alternatives_db, n=4000, observer=KEEN):
    rng, m = np.random.default_rng(), len(alternatives_db)
    return np.mean([observer.identify(alternatives_db, k % m, rng) == k % m for k in range(n)]), n


@pytest.mark.parametrize("alternatives_db", [((0.0, -6.0), (-6.0, 0.0)), ((3.0,), (-9.0,)), ((2.0, 2.0), (2.0, -inf))])
def test_share_correct_of_two_alternatives_follows_their_distance(alternatives_db):
    first, second = (np.array([KEEN.d_prime(level) for level in levels]) for levels in alternatives_db)
    expected = norm.cdf(np.linalg.norm(first - second) / 2)
    share, n = share_right(alternatives_db)
    assert abs(share - expected) <= AT_1E_4 * sqrt(expected * (1 - expected) / n)


@pytest.mark.parametrize("level_db", [4.0, -inf])
def test_equal_alternatives_are_guessed(level_db):
    share, n = share_right([(level_db, level_db)] * 3)
    assert abs(share - 1 / 3) <= AT_1E_4 * sqrt(2 / 9 / n)


def test_distinct_alternatives_are_identified_by_strongest_sensation():
    alternatives_db = [(0.0, -inf, -inf), (-inf, 0.0, -inf), (-inf, -inf, 0.0)]
    for seed in range(200):
        identified = KEEN.identify(alternatives_db, 1, np.random.default_rng(seed))
        assert identified == KEEN.compare([-inf, 0.0, -inf], np.random.default_rng(seed))


PLACE = Choose("which_place", (1, 2), ("left", "right"), ("left", "right"))


def located(levels_db, observer=KEEN, n=1000):
    """Return the share of right answers for these levels at each finger."""
    rng = np.random.default_rng()
    names = [PLACE.labels[k % 2] for k in range(n)]
    answers = [locate(observer, [Felt(name, 60.0, levels_db.get)], PLACE, rng) for name in names]
    return np.mean([answer == PLACE.labels.index(name) + 1 for answer, name in zip(answers, names, strict=True)]), n


def test_focus_is_located_by_finger_and_not_strength():
    assert located({"left": (60.0, -inf), "right": (-inf, 60.0)})[0] == 1.0
    share, n = located({"left": (60.0, 60.0), "right": (60.0, 60.0)})  # the whole plate moves equally
    assert abs(share - 0.5) <= AT_1E_4 * sqrt(0.25 / n)


PAIR = Alternative("pair", "a + b", {}, ((0.0, 0.0), (0.03, 0.0)))
PLACES = (Alternative("a", "a", {}, ((0.0, 0.0),)), Alternative("b", "b", {}, ((0.03, 0.0),)), PAIR)


def outcome_of(alternatives, option):
    touch = Pressing(duration_s=0.5, force_n=1.0, hold_s=0.3, timeout_s=10.0)
    course = Localisation().trial(Presentation("a", 20.0, touch, alternatives), np.random.default_rng(4))
    next(course)
    course.send(Touched(0.0, 20.0, ""))
    with pytest.raises(StopIteration) as ending:
        course.send(Chosen(option, 0.0, 1.0))
    return ending.value.value


@pytest.mark.parametrize("option", [1, 2, 3])
def test_localisation_row_contains_distance_error(option):
    outcome = outcome_of(PLACES, option)
    assert outcome.separation_m == 0.03
    assert outcome.error_m == (0.0 if option == outcome.target else 0.03)


def test_alternatives_without_places_have_no_distances():
    plain = tuple(Alternative(name, name) for name in "ab")
    outcome = outcome_of(plain, 1)
    assert (outcome.separation_m, outcome.error_m) == (None, None)
