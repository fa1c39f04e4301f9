"""QUEST+ and QUEST: published sequence, edges, stopping, shared width and rates."""

import itertools
import math

import numpy as np
import pytest
from examples import examples
from followed_rule import follow
from hard_cases import exact_case, hard_case
from hypothesis import given, settings, strategies as st
from scipy.stats import norm

from tactometry.errors import InvalidParameter
from tactometry.protocols import Quest, QuestPlus, Staircase
from tactometry.protocols.bayesian.parameter_grid import ParameterGrid
from tactometry.protocols.bayesian.quest_plus import SharedQuestPlus
from tactometry.protocols.procedures.procedure import after_answer
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


def quest(**options):
    return Quest(**{"start": 20.0, "start_sd": 10.0, "low": 0.0, "high": 40.0, "step": 0.5} | options)


@pytest.mark.parametrize("rule", [small(), quest()], ids=["QUEST+", "QUEST"])
def test_delivered_level_off_grid_is_not_rounded(rule):
    assert not np.array_equal(rule.after(1, delivered=20.1).posterior, rule.after(1, delivered=20.0).posterior)


def test_probability_at_threshold_equals_target():
    rule = quest(target=0.7)
    n = int(np.flatnonzero(rule.thresholds == 20.0)[0])
    assert math.exp(rule.grid.log_likelihood(20.0, 1)[n]) == pytest.approx(0.7)


@pytest.mark.parametrize("rule", [small("threshold", n_trials=2000, sd_stop=1.5), quest(n_trials=500, sd_stop=1.0)])
def test_run_converges_at_requested_standard_deviation(rule):
    rng, sd_stop = np.random.default_rng(), rule.sd_stop
    while not rule.finished:
        rule = rule.after(bool(rng.random() < 0.5 + 0.49 / (1 + math.exp(17 - rule.level))))
    assert rule.ending == "converged"
    assert rule.threshold_sd <= sd_stop


def test_answers_that_no_threshold_allows_end_as_aborted():
    rule = quest(blind_share=0.0).after(0, delivered=1e6)
    assert (rule.ending, rule.threshold) == ("aborted", None)
    assert np.isfinite(rule.posterior).all()


def test_ten_thousand_answers_stay_finite():
    rule = quest(n_trials=10**6)
    for n in range(10_000):
        rule = rule.after(n % 2, delivered=40.0 * (1 - n % 2))
    assert np.isfinite(rule.posterior).all()
    assert 0 <= rule.level <= 40
    exact_case("10 000 answers to QUEST", against="all finite")


SHARED_GRID = ParameterGrid((0.0, 10.0, 20.0, 30.0), (4.0, 12.0), (0.5,), (0.0, 0.05))
RULE = QuestPlus((0.0, 8.0, 16.0, 24.0, 32.0), SHARED_GRID, n_trials=50)
TRACKS = ("a", "b", "c")
answers_of_tracks = st.lists(st.tuples(st.integers(0, 2), st.booleans(), st.floats(-5, 35)), max_size=12)


def brute_force(answers):
    """Return the joint posterior, (4, 4, 4, 4)."""
    log = np.zeros((4, 4, 4, 4))
    for track, answer, level in answers:
        own = SHARED_GRID.log_likelihood(level, int(answer)).reshape(4, 4)
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
    first, second = SharedQuestPlus(RULE, ("a",)).procedures()[0], SharedQuestPlus(short(), ("a",)).procedures()[0]
    moved = after_answer((first, staircase, second), 0, 1)
    assert moved[0].pool is not first.pool
    assert moved[1:] == (staircase, second)


def short():
    return QuestPlus((0.0, 10.0), SHARED_GRID, n_trials=3)


def test_a_pool_shows_itself_without_its_tables():
    pool = SharedQuestPlus(RULE, ("a", "b")).after("a", 1)
    assert "array" not in repr(pool)


def test_each_track_ends_after_its_own_trials():
    pool = SharedQuestPlus(short(), ("a", "b"))
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
        (lambda: quest(start=50.0), "Quest.start: found 50, low 0, high 40 and step 0.5, expected a start between"),
        (lambda: quest(start_sd=0.0), "Quest.start_sd: found 0.0, expected a finite number above 0"),
        (lambda: quest(step=50.0), "Quest.start: found 20, low 0, high 40 and step 50, expected a start between low"),
        (lambda: quest(sd_stop=0.0), "Quest.sd_stop: found 0.0, expected a finite number above 0"),
        (lambda: quest(placing="median"), "Quest.placing: found 'median', expected one of quantile, mean, mode"),
        (lambda: quest(guess_rate=1.0), "Quest.guess_rate: found 1.0, expected a number from 0 to below 1"),
        *((lambda p=p: quest(target=p), f"Quest.target: found {p}, expected a probability") for p in (0.4, 0.997)),
        (lambda: SharedQuestPlus(RULE, ()), r"SharedQuestPlus.tracks: found \(\), expected names, each once"),
        (lambda: SharedQuestPlus(RULE, ("a", "a")), "expected names, each once"),
        (lambda: SharedQuestPlus(RULE.after(1), ("a",)), "SharedQuestPlus.rule: found QuestPlusRun.*, expected"),
        (lambda: SharedQuestPlus(RULE, ("left",)).procedure("lefty"), "SharedQuestPlus.track: found 'lefty', expected"),
    ],
)
def test_impossible_arguments_are_refused(build, message):
    with pytest.raises(InvalidParameter, match=message):
        build()
