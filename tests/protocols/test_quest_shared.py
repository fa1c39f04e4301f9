"""QUEST+ with shared width and rates, compared with the joint grid."""

import itertools
import math

import numpy as np
import pytest
from examples import examples
from hypothesis import given, strategies as st
from scipy.stats import norm

from tactometry.errors import InvalidParameter
from tactometry.protocols import QuestPlus, Staircase
from tactometry.protocols.bayesian.parameter_grid import ParameterGrid
from tactometry.protocols.bayesian.quest_plus import SharedQuestPlus
from tactometry.protocols.procedures.procedure import after_answer

GRID = ParameterGrid((0.0, 10.0, 20.0, 30.0), (4.0, 12.0), (0.5,), (0.0, 0.05))
RULE = QuestPlus((0.0, 8.0, 16.0, 24.0, 32.0), GRID, n_trials=50)
TRACKS = ("a", "b", "c")
answers_of_tracks = st.lists(st.tuples(st.integers(0, 2), st.booleans(), st.floats(-5, 35)), max_size=12)


def brute_force(answers):
    """Return the joint posterior, (4, 4, 4, 4)."""
    log = np.zeros((4, 4, 4, 4))
    for track, answer, level in answers:
        own = GRID.log_likelihood(level, int(answer)).reshape(4, 4)
        shape = [4 if axis in (track, 3) else 1 for axis in range(4)]
        log = log + own.reshape(shape)
    weights = np.exp(log - log.max())
    return weights / weights.sum()


@given(answers=answers_of_tracks)
@examples(30, deadline=None)
def test_views_are_the_marginals_of_the_joint_posterior(answers):
    pool = SharedQuestPlus(RULE, TRACKS)
    for track, answer, level in answers:
        pool = pool.after(TRACKS[track], answer, level)
    joint = brute_force(answers)
    for n, track in enumerate(TRACKS):
        others = tuple(axis for axis in range(3) if axis != n)
        np.testing.assert_allclose(pool.procedure(track).posterior, joint.sum(axis=others), atol=1e-12)


def test_one_track_alone_is_quest_plus():
    rng, alone, pool = np.random.default_rng(), RULE, SharedQuestPlus(RULE, ("a",))
    for _ in range(20):
        assert pool.procedure("a").level == alone.level
        answer = bool(rng.random() < 0.7)
        alone, pool = alone.after(answer), pool.after("a", answer)
    np.testing.assert_allclose(pool.procedure("a").posterior, alone.posterior, atol=1e-12)


def test_tracks_as_procedures_tell_each_other():
    rng = np.random.default_rng()
    pool, procedures = SharedQuestPlus(RULE, TRACKS), SharedQuestPlus(RULE, TRACKS).procedures()
    for _ in range(30):
        n, answer = int(rng.integers(3)), bool(rng.random() < 0.7)
        assert procedures[n].level == pool.procedure(TRACKS[n]).level
        pool, procedures = pool.after(TRACKS[n], answer), after_answer(procedures, n, answer)
    for procedure, track in zip(procedures, TRACKS, strict=True):
        np.testing.assert_array_equal(procedure.view.posterior, pool.procedure(track).posterior)


def test_procedures_that_share_nothing_are_left_alone():
    staircase = Staircase(start=20.0, steps=(4.0,), low=0.0, high=40.0)
    first, second = SharedQuestPlus(RULE, ("a",)).procedures()[0], SharedQuestPlus(small(), ("a",)).procedures()[0]
    moved = after_answer((first, staircase, second), 0, 1)
    assert moved[0].pool is not first.pool
    assert moved[1:] == (staircase, second)


def small():
    return QuestPlus((0.0, 10.0), GRID, n_trials=3)


def test_a_pool_shows_itself_without_its_tables():
    pool = SharedQuestPlus(RULE, ("a", "b")).after("a", 1)
    assert "array" not in repr(pool)


def test_each_track_ends_after_its_own_trials():
    pool = SharedQuestPlus(small(), ("a", "b"))
    for track in "aaab":
        pool = pool.after(track, 1)
    assert pool.procedure("a").finished
    assert not pool.finished
    with pytest.raises(InvalidParameter, match="SharedQuestPlus track 'a', QuestPlus.after: found a response after th"):
        pool.after("a", 1)
    assert pool.after("b", 1).after("b", 0).finished


def test_impossible_answers_abort_their_track_only():
    grid = ParameterGrid((10.0, 20.0), (0.1, 0.2), (0.0,), (0.0,), shape="normal")
    pool = SharedQuestPlus(QuestPlus((0.0, 30.0), grid, n_trials=9), ("a", "b")).after("a", 0, 1e200)
    assert pool.procedure("a").ending == "aborted"
    assert pool.procedure("b").ending is None
    assert np.isfinite(pool.after("b", 1, 15.0).procedure("b").posterior).all()


def test_sharing_the_slope_is_worth_trials():
    """Four thresholds with one slope unknown over a factor of eight, 30 trials each in yes/no."""
    grid = ParameterGrid(tuple(np.linspace(0, 40, 21)), (3.0, 6.0, 12.0, 24.0), (0.02,), (0.0, 0.02, 0.06), "normal")
    rule = QuestPlus(tuple(np.linspace(0, 40, 21)), grid, n_trials=30, aim="threshold")
    rng, spreads = np.random.default_rng(), []
    for _ in range(8):
        truths = rng.uniform(10, 30, 4)
        shared = run(SharedQuestPlus(rule, tuple("abcd")).procedures(), truths, rng)
        alone = run((rule,) * 4, truths, rng)
        spreads.append([np.mean([each.estimate.sd for each in ends]) for ends in (shared, alone)])
    differences = np.subtract(*np.transpose(spreads))
    assert np.mean(differences) < 3.72 * np.std(differences) / math.sqrt(len(differences))


def run(procedures, truths, rng):
    for n in itertools.chain.from_iterable(itertools.repeat(range(4), 30)):
        answer = rng.random() < 0.02 + 0.96 * norm.cdf((procedures[n].level - truths[n]) / 2)
        procedures = after_answer(procedures, n, bool(answer))
    return procedures


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: SharedQuestPlus(RULE, ()), r"SharedQuestPlus.tracks: found \(\), expected names, each once"),
        (lambda: SharedQuestPlus(RULE, ("a", "a")), "expected names, each once"),
        (lambda: SharedQuestPlus(RULE.after(1), ("a",)), "SharedQuestPlus.rule: found QuestPlusRun.*, expected"),
        (lambda: SharedQuestPlus(RULE, ("left",)).procedure("lefty"), "SharedQuestPlus.track: found 'lefty', expected"),
    ],
)
def test_invalid_pool_is_refused(build, message):
    with pytest.raises(InvalidParameter, match=message):
        build()
