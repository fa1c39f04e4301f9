"""Changes of a participant during a session, as pure functions."""

import itertools

import numpy as np
import pytest
from bounds import ALPHA, is_rate
from scipy.stats import chi2, norm

from tactometry.errors import InvalidParameter
from tactometry.experiments.sessions.in_memory import simulated_trials
from tactometry.experiments.sessions.recording import Who
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.session_plan import stream
from tactometry.experiments.study.study_file import builtin, parse
from tactometry.loading import resolve
from tactometry.observers.changes import (
    CHANGES,
    CriterionDrift,
    Fatigue,
    LapsesInRuns,
    SerialDependence,
    Shift,
    SlowLearning,
)
from tactometry.observers.kinds import population_of
from tactometry.observers.signal_detection import SignalDetectionObserver

TUTORIAL = builtin()["tutorial"].read_bytes()


def rng(n=0):
    return np.random.default_rng([11, n])


def answers_of(toml):
    """Simulate a session and return its responses."""
    return simulated_trials(wire(parse(toml, "study"), "study"), [Who("P01", seed=1), Who("P02", seed=1)])


def test_learning_and_fatigue_follow_their_formulas():
    learning, fatigue = SlowLearning(4.0, 50.0), Fatigue(2.0, 100.0)
    felt = [learning.shift(n, (), rng()).sensitivity_db for n in (0, 50, 10_000)]
    assert felt == pytest.approx([-4.0, -4.0 / np.e, 0.0])
    assert [fatigue.shift(n, (), rng()).sensitivity_db for n in (0, 50)] == pytest.approx([0.0, -1.0])


def test_lapse_runs_have_the_stated_rate_and_length():
    change, n = LapsesInRuns(0.1, 0.25), 3000
    lost = [change.shift(200, (), rng(k)).lapse_rate > 0 for k in range(n)]
    assert is_rate(sum(lost), 0.1 / 0.35, n)
    course = [change.shift(k, (), rng()).lapse_rate > 0 for k in range(400)]
    assert course == [change.shift(k, (), rng()).lapse_rate > 0 for k in range(400)]
    returned = sum(a and not b for a, b in itertools.pairwise(course))
    assert is_rate(returned, 0.25, sum(course[:-1]))


@pytest.mark.parametrize("n_trials", [0, 1, 80])
def test_criterion_drift_has_constant_spread(n_trials):
    change, n = CriterionDrift(0.5, 20.0), 2000
    drawn = np.array([change.shift(n_trials, (), rng(k)).criterion for k in range(n)])
    low, high = chi2.ppf([ALPHA / 2, 1 - ALPHA / 2], n) / n
    assert low <= np.mean((drawn / 0.5) ** 2) <= high


def test_criterion_drift_has_the_stated_autocorrelation():
    change, n = CriterionDrift(0.5, 20.0), 2000
    pairs = np.array([[change.shift(k, (), rng(s)).criterion for k in (30, 50)] for s in range(n)])
    apart = np.arctanh(np.corrcoef(pairs.T)[0, 1]) - np.arctanh(np.exp(-1))
    assert abs(apart) * np.sqrt(n - 3) <= norm.isf(ALPHA / 2)


def test_serial_dependence_shifts_the_next_criterion():
    change = SerialDependence(0.2)
    shifts = [change.shift(3, answers, rng()).criterion for answers in ((), (1.0,), (1.0, 0.0), (None,), ("left",))]
    assert shifts == [0.0, -0.2, 0.2, 0.0, 0.0]


@pytest.mark.parametrize("kind", CHANGES)
def test_changes_are_pure_functions(kind):
    change, answers = resolve(CHANGES[kind])(), (1.0, 0.0, None, 1.0)
    assert change.shift(4, answers, rng()) == change.shift(4, answers, rng())


def test_each_change_draws_from_a_separate_stream():
    """Removing one change leaves the others the same."""
    draws = lambda *words: stream(1, "P01", 1, *words)  # noqa: E731
    both = population_of({"changes": {"lapses_in_runs": {}, "criterion_drift": {}}}, "observer")
    one = population_of({"changes": {"criterion_drift": {}}}, "observer")
    for n in range(5):
        assert both.shift(n, (), draws).criterion == one.shift(n, (), draws).criterion


def test_zero_effect_leaves_responses_unchanged():
    """A change without effect draws nothing from the answers' streams."""
    still = b"\n[observer.changes]\nlearning = { gain_db = 0.0 }\ncriterion_drift = { sd = 0.0 }\n"
    plain, changed = answers_of(TUTORIAL).rows, answers_of(TUTORIAL + still).rows
    assert plain.equals(changed)
    worse = b"\n[observer.changes]\nlearning = { gain_db = 400.0, n_trials = 1e9 }\n"
    assert not plain.equals(answers_of(TUTORIAL + worse).rows)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"boredom": {}}, "observer.changes.boredom: found an unknown kind of change"),
        ({"learning": {"gain": 1.0}}, "observer.changes.learning.gain: found an unknown key"),
        ({"learning": {"n_trials": 0.0}}, "observer.changes.learning.n_trials: found 0"),
        ({"learning": 3}, "observer.changes.learning: found 3, expected a table"),
    ],
)
def test_invalid_changes_are_refused(changes, sentence):
    with pytest.raises(InvalidParameter) as error:
        population_of({"changes": changes}, "observer")
    assert str(error.value).startswith(sentence)


def test_shift_changes_the_parameters_of_an_observer():
    off = SignalDetectionObserver(lapse_rate=0.1).shifted(Shift(3.0, 0.2, 0.5))
    assert (off.sensitivity_db, off.bias) == (3.0, 0.2)
    assert off.lapse_rate == pytest.approx(0.55)
    assert SignalDetectionObserver().shifted(Shift(lapse_rate=1.0)).lapse_rate < 1
