"""Response rates of observers, within binomial bounds at 1e-4."""

import numpy as np
import pytest
from bounds import is_rate
from scipy.integrate import quad
from scipy.stats import norm
from study_texts import TUTORIAL as CONSTANT_TUTORIAL, refusal, wired

from tactometry.experiments.sessions.in_memory import simulated_trials
from tactometry.experiments.sessions.recording import Who
from tactometry.observers.ideal import IdealObserver
from tactometry.observers.psychometric import PsychometricObserver
from tactometry.observers.signal_detection import SignalDetectionObserver
from tactometry.psychometric import PsychometricFunction

N = 100_000
NOTHING = -np.inf
TUTORIAL = CONSTANT_TUTORIAL.partition("\n[observer]")[0]
DETECTS = SignalDetectionObserver(lapse_rate=0.04, bias=0.2, exponent=1.5)
KNOWN = PsychometricObserver(20.0, 8.0, false_alarm_rate=0.1, lapse_rate=0.03, sensitivity_db=2.0)


def right_of(m, d_prime):
    """Compute proportion correct of m alternatives (Green and Swets 1966)."""
    return quad(lambda x: norm.pdf(x - d_prime) * norm.cdf(x) ** (m - 1), -10, 10 + d_prime)[0]


@pytest.mark.parametrize("level_db", [NOTHING, -3.0, 2.0])
def test_signal_detection_yes_rate_follows_its_formula(level_db):
    rng = np.random.default_rng()
    p = 0.96 * norm.cdf(DETECTS.d_prime(level_db) - DETECTS.criterion - 0.2) + 0.02
    assert is_rate(sum(DETECTS.detect(level_db, rng) for _ in range(N)), p, N)


@pytest.mark.parametrize("m", [pytest.param(2, marks=pytest.mark.slow), 3])
def test_signal_detection_choices_follow_its_formula(m):
    rng, levels = np.random.default_rng(), [NOTHING] * (m - 1) + [-2.0]
    p = 0.96 * right_of(m, DETECTS.d_prime(-2.0)) + 0.04 / m
    assert is_rate(sum(DETECTS.compare(levels, rng) == m - 1 for _ in range(N)), p, N)


@pytest.mark.parametrize("shape", ["normal", "logistic", "gumbel", "reversed_gumbel"])
@pytest.mark.parametrize("above", [NOTHING, -1.5, 3.0])
def test_psychometric_observer_has_the_stated_yes_rate(shape, above):
    observer, rng = PsychometricObserver(20.0, 8.0, shape=shape, false_alarm_rate=0.1), np.random.default_rng()
    psi = PsychometricFunction(shape, 20.0, 8.0, 0.1, 0.02)
    p = 0.1 if above == NOTHING else float(psi.probability(20.0 + above))
    felt_db = observer.stated({}).felt_db(20.0 + above, lambda: np.nan) if above != NOTHING else NOTHING
    assert is_rate(sum(observer.detect(felt_db, rng) for _ in range(N)), p, N)


@pytest.mark.parametrize("m", [pytest.param(2, marks=pytest.mark.slow), 4])
def test_psychometric_observer_has_the_stated_choice_rate(m):
    rng, levels = np.random.default_rng(), [NOTHING] * (m - 1) + [1.0]
    p = float(PsychometricFunction("normal", 0.0, 8.0, 1 / m, 0.03).probability(1.0))
    chosen = np.bincount([KNOWN.compare(levels, rng) for _ in range(N)], minlength=m)
    assert is_rate(chosen[-1], p, N)
    for n_wrong in chosen[:-1]:
        assert is_rate(n_wrong, (1 - p) / (m - 1), N)
    n_identified = sum(KNOWN.identify([(NOTHING, 1.0), (1.0, NOTHING)], 1, rng) for _ in range(N))
    assert is_rate(n_identified, float(PsychometricFunction("normal", 0.0, 8.0, 0.5, 0.03).probability(1.0)), N)


def test_comparison_of_two_levels_uses_stated_width():
    rng, sd = np.random.default_rng(), 8.0 / (2 * norm.isf(0.05))
    p = 0.97 * norm.cdf(2.0 / sd) + 0.015
    assert is_rate(sum(KNOWN.compare([1.0, 3.0], rng) for _ in range(N)), p, N)


def test_blanks_are_chosen_equally_often():
    rng = np.random.default_rng()
    for observer in (KNOWN, IdealObserver(), DETECTS):
        chosen = np.bincount([observer.compare([NOTHING] * 3, rng) for _ in range(3000)], minlength=3)
        assert all(is_rate(n, 1 / 3, 3000) for n in chosen)


def test_conditions_have_their_stated_threshold_and_width():
    """The participant's sensitivity lowers the threshold."""
    of = ({"frequency_hz": 60.0, "threshold": 30.0, "width": 16.0}, {"force_n": 2.0, "width": 4.0})
    observer = PsychometricObserver(20.0, 8.0, of, false_alarm_rate=0.0, lapse_rate=0.0, sensitivity_db=3.0)
    for factors, threshold, width in (
        ({"frequency_hz": 60.0, "force_n": 1.0}, 27.0, 16.0),
        ({"frequency_hz": 240.0, "force_n": 1.0}, 17.0, 8.0),
        ({"frequency_hz": 60.0, "force_n": 2.0}, 27.0, 4.0),
    ):
        feeling = observer.stated(factors)
        psi = PsychometricFunction("normal", threshold, width, 0.0, 0.0)
        for level in (threshold - width / 2, threshold, threshold + 1.0):
            felt = feeling.felt_db(level, lambda: np.nan)
            assert observer.chance(felt, 0.0) == pytest.approx(float(psi.probability(level)), rel=1e-9)


def test_ideal_observer_answers_correctly():
    rng, ideal = np.random.default_rng(), IdealObserver(sensitivity_db=1.0)
    assert [ideal.detect(level, rng) for level in (-1.5, -0.5, NOTHING)] == [False, True, False]
    assert {ideal.compare([1.0, 1.1, NOTHING], rng) for _ in range(100)} == {1}
    assert {ideal.identify([(1.0, 2.0), (2.0, 1.0)], 1, rng) for _ in range(100)} == {1}
    assert {ideal.identify([(1.0, 2.0), (1.0, 2.0)], 1, rng) for _ in range(200)} == {0, 1}
    assert [ideal.differ(levels, rng) for levels in ((1.0, 1.0), (1.0, 1.1))] == [False, True]
    assert ideal.magnitude(19.0, rng) == 10.0


KINDS = {
    "ideal": 'kind = "ideal"\n',
    "psychometric": 'kind = "psychometric"\nthreshold = 30.0\nbetween_sd_db = 0.0\nlapse_rate = 0.0\n'
    "conditions = [{ frequency_hz = 240, threshold = -300.0, width = 0.1 }]\n",
}


@pytest.mark.parametrize("kind", KINDS)
def test_study_runs_with_each_observer_kind(kind):
    toml = f"{TUTORIAL}\n[observer]\n{KINDS[kind]}[observer.people]\nlatency_cv = 0.2\n"
    rows = simulated_trials(wired(toml), [Who("P01", seed=1)]).rows
    assert len(rows) >= 32
    if kind == "psychometric":
        felt = rows[(rows["frequency_hz"] == 240) & rows["level"].notna() & rows["valid"].astype(bool)]
        assert (felt["response"].astype(float) == 1).all()


@pytest.mark.parametrize(
    ("observer", "sentence"),
    [
        ('kind = "psychometric"', "observer.threshold: found no such key"),
        ('kind = "psychometric"\nthreshold = 1.0\nwidth = 0.0', "observer.width: found 0"),
        ('kind = "psychometric"\nthreshold = 1.0\nshape = "weibull"', "observer.shape: found 'weibull'"),
        ('kind = "psychometric"\nthreshold = 1.0\nconditions = [{ size = 1.0 }]', "conditions[0].size: found an"),
        ('kind = "psychometric"\nthreshold = 1.0\nconditions = [{ frequency_hz = 61 }]', "conditions[0].frequency_hz"),
        ('kind = "psychometric"\nthreshold = 1.0\nconditions = [{ width = "a" }]', "conditions[0].width: found 'a'"),
        ('kind = "ideal"\nlapse_rate = 0.1', "observer.lapse_rate: found an unknown key"),
        ('kind = "ideal"\n[observer.changes]\nlearning = {}', "of the kind 'ideal' do not change, expected none"),
    ],
)  # fmt: skip
def test_invalid_observers_are_refused(observer, sentence):
    assert sentence in refusal(f"{TUTORIAL}\n[observer]\n{observer}\n")
