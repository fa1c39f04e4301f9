"""Populations of simulated participants: moments and traits."""

from dataclasses import replace

import numpy as np
import pytest
from bounds import ALPHA, is_rate, within_sd
from scipy.stats import norm
from study_texts import TUTORIAL as CONSTANT_TUTORIAL, refusal, wired

from tactometry.errors import InvalidParameter
from tactometry.experiments.study.session_plan import stream
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
