"""Populations of simulated participants: moments, traits, and changes during a session."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from bounds import ALPHA, is_rate, within_sd
from scipy.stats import chi2, norm
from study_texts import TUTORIAL as CONSTANT_TUTORIAL, refusal, wired

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
from tactometry.observers.finger import SimulatedFinger
from tactometry.observers.kinds import population_of
from tactometry.observers.people import TRAITS, People, Traits, correlation_matrix
from tactometry.observers.signal_detection import SignalDetectionObserver
from tactometry.session.request import Press

N = 4000
SPREADS = {
    "criterion_sd": 0.3, "exponent_cv": 0.2, "lapse_cv": 0.7, "latency_cv": 0.25, "number_cv": 0.4,
    "force_bias_cv": 0.05, "speed_bias_cv": 0.1,
}  # fmt: skip
PAIRS = {"sensitivity": {"criterion": -0.5, "exponent": 0.3}, "force": {"speed": 0.6}}
CELLS = [{"force_n": force_n, "frequency_hz": f} for force_n in (0.5, 3.0) for f in (30.0, 60.0, 240.0)]
TUTORIAL = CONSTANT_TUTORIAL.partition("\n[observer]")[0]


def draws_of(person, seed=1):
    return lambda *words: stream(seed, person, *words)


@pytest.fixture(scope="module")
def drawn():
    """Traits of N participants as normal numbers, in the order of `TRAITS`."""
    people, rng = People(**SPREADS, correlations=PAIRS), np.random.default_rng()
    traits = [people.traits(rng) for _ in range(N)]
    factors = {name: np.array([np.log(getattr(t, f"{name}_factor")) for t in traits]) for name in TRAITS[2:]}
    return {name: np.array([getattr(t, name) for t in traits]) for name in TRAITS[:2]} | factors


def test_traits_have_the_stated_spreads(drawn):
    spreads = dict(zip(TRAITS, (1.0, *SPREADS.values()), strict=True))
    for name, values in drawn.items():
        assert within_sd(values, spreads[name])
        assert abs(values.mean()) <= norm.isf(ALPHA / 2) * spreads[name] / np.sqrt(N)


def test_traits_have_the_stated_correlations(drawn):
    found, stated = np.corrcoef(list(drawn.values())), correlation_matrix(PAIRS)
    apart = np.arctanh(found[np.triu_indices(8, 1)]) - np.arctanh(stated[np.triu_indices(8, 1)])
    assert np.all(np.abs(apart) * np.sqrt(N - 3) <= norm.isf(ALPHA / 2 / 28))


def test_population_without_spreads_draws_sensitivity_only():
    plain, z = SignalDetectionObserver(), stream(3, "P01", "traits").standard_normal()
    person = population_of({}, "observer").person(stream(3, "P01", "traits"))
    assert person.observer == replace(plain, sensitivity_db=5.0 * z)
    assert (person.force_factor, person.speed_factor) == (1.0, 1.0)


def test_fully_correlated_traits_are_equal():
    traits = People(number_cv=0.5, latency_cv=0.5, correlations={"number": {"latency": 1.0}}).traits
    drawn = traits(np.random.default_rng(1))
    assert drawn.number_factor == pytest.approx(drawn.latency_factor, rel=1e-12)


@pytest.mark.parametrize(
    ("pairs", "sentence"),
    [
        ({"mood": {"force": 0.1}}, "correlations: found 'mood'"),
        ({"force": {"mood": 0.1}}, "correlations.force: found 'mood'"),
        ({"force": {"force": 1.0}}, "a trait with itself, expected two traits"),
        ({"force": {"speed": 1.5}}, "correlations.force.speed: found 1.5, expected from -1 to 1"),
        ({"force": {"speed": 0.5}, "speed": {"force": 0.5}}, "found the pair twice, expected it once"),
        ({"force": {"speed": 0.9, "lapse": 0.9}, "speed": {"lapse": -0.9}}, "found inconsistent correlations"),
    ],
)
def test_impossible_correlations_are_refused(pairs, sentence):
    with pytest.raises(InvalidParameter) as error:
        population_of({"people": {"correlations": pairs}}, "observer")
    assert str(error.value).startswith("observer.people.correlations")
    assert sentence in str(error.value)


def test_deviation_depends_on_person_and_cell_only():
    people = People(modality_sd_db=1.0, condition_sd_db=2.0, factor_sd_db={"force_n": 1.0})
    of = [people.deviation_db(cell, "electrovibration", draws_of("P01")) for cell in CELLS]
    turned = [dict(reversed(cell.items())) for cell in CELLS[::-2]]
    assert [people.deviation_db(cell, "electrovibration", draws_of("P01")) for cell in turned] == of[::-2]
    assert len(set(of)) == len(CELLS)
    assert of[0] != people.deviation_db(CELLS[0], "electrovibration", draws_of("P02"))


def test_deviations_have_the_stated_variances():
    """Check sums in a cell and differences of cells."""
    people = People(modality_sd_db=3.0, condition_sd_db=1.0, factor_sd_db={"frequency_hz": 2.0})
    pairs = [(n, cell) for n in range(N) for cell in (*CELLS[:2], CELLS[3])]
    felt = [people.deviation_db(cell, "electrovibration", draws_of(f"P{n}")) for n, cell in pairs]
    felt = np.reshape(felt, (N, 3))
    assert within_sd(felt[:, 0], np.sqrt(9 + 4 + 1))
    assert people.deviation_sd_db == pytest.approx(np.sqrt(14))
    assert within_sd(felt[:, 0] - felt[:, 1], np.sqrt(2 * 4 + 2))
    assert within_sd(felt[:, 0] - felt[:, 2], np.sqrt(2))


def test_hybrid_deviation_is_the_mean_of_both_modalities():
    people, names = People(modality_sd_db=3.0), ("electrovibration", "time_reversal", "hybrid")
    one, other, both = (people.deviation_db({}, name, draws_of("P01")) for name in names)
    assert one != other
    assert both == pytest.approx((one + other) / 2)


def test_effects_shift_their_level_for_all_participants():
    people = People(effects_db={"force_n": {"3": 2.0}})
    felt = [people.deviation_db(cell, "electrovibration", draws_of("P01")) for cell in CELLS]
    assert felt == [0.0] * 3 + [2.0] * 3


def test_session_uses_the_deviations_of_the_population():
    """With +300 dB and no lapses, every stimulus is felt."""
    table = '\n[observer]\nlapse_rate = 0.0\n[observer.people.effects_db.frequency_hz]\n"60" = 300.0\n"240" = -300.0\n'
    experiment = wired(TUTORIAL + table)
    felt = experiment.feelings("P01", 1)
    assert sorted(each.deviation_db for each in felt.values()) == [-300.0, 300.0]
    rig = experiment.simulated_rig("P01", 1, 1)
    assert rig.feelings == felt


@pytest.mark.parametrize(
    ("people", "sentence"),
    [
        ("factor_sd_db = { size = 1.0 }", "observer.people.factor_sd_db.size: found an unknown factor"),
        ('effects_db = { frequency_hz = { "61" = 1.0 } }', "effects_db.frequency_hz.61: found an unknown level"),
        ("condition_sd_db = -1.0", "observer.people.condition_sd_db: found -1"),
        ("mood = 1.0", "observer.people.mood: found an unknown key"),
    ],
)
def test_invalid_populations_are_refused(people, sentence):
    assert sentence in refusal(f"{TUTORIAL}\n[observer.people]\n{people}\n")


def test_traits_reach_the_observer_and_the_finger():
    middle = SignalDetectionObserver(lapse_rate=0.1, between_sd_db=4.0)
    person = middle.person(Traits(2.0, 0.5, 1.5, 100.0, 2.0, 3.0))
    assert (person.sensitivity_db, person.bias, person.exponent) == (8.0, 0.5, 1.5)
    assert (person.lapse_rate, person.latency_s, person.number_factor) == (0.5, 1.6, 3.0)


def test_bias_changes_false_alarms_like_a_criterion():
    observer, rng, n = SignalDetectionObserver(bias=0.4, lapse_rate=0.0), np.random.default_rng(), 100_000
    n_yes = sum(observer.detect(-np.inf, rng) for _ in range(n))
    assert is_rate(n_yes, norm.sf(observer.criterion + 0.4), n)


def test_force_habit_shifts_force_within_the_band():
    finger, rng = SimulatedFinger(force_factor=1.1), np.random.default_rng()
    request = Press("tone", 20.0, 0.2, 1.0, 0.2, 0.5, 5.0)
    forces_n = np.array([finger.hold(request, rng).forces_n.mean() for _ in range(300)])
    usual_n = np.array([SimulatedFinger().hold(request, rng).forces_n.mean() for _ in range(300)])
    spread = np.sqrt(forces_n.var() / 300 + usual_n.var() / 300)
    assert forces_n.mean() - usual_n.mean() > 0.05 * 0.5 - norm.isf(ALPHA) * spread
    far = SimulatedFinger(force_factor=5.0, waver_cv=0.0).hold(request, rng).forces_n
    assert far.mean() == pytest.approx(1.2)


# --- changes during a session

TUTORIAL_TOML = builtin()["tutorial"].read_bytes()


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
    plain, changed = answers_of(TUTORIAL_TOML).rows, answers_of(TUTORIAL_TOML + still).rows
    assert plain.equals(changed)
    worse = b"\n[observer.changes]\nlearning = { gain_db = 400.0, n_trials = 1e9 }\n"
    assert not plain.equals(answers_of(TUTORIAL_TOML + worse).rows)


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
