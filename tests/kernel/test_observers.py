"""Answers of simulated observers and raters, within bounds at 1e-4."""

import numpy as np
import pytest
from bounds import ALPHA, is_rate, within_sd
from scipy.integrate import quad
from scipy.stats import norm
from study_texts import TUTORIAL as CONSTANT_TUTORIAL, refusal, wired

from tactometry.experiments.sessions.in_memory import simulated_trials
from tactometry.experiments.sessions.recording import Who
from tactometry.experiments.study.session_plan import stream
from tactometry.experiments.study.study_file import builtin
from tactometry.experiments.study.task_table import dimensions_of
from tactometry.observers.ideal import IdealObserver
from tactometry.observers.psychometric import PsychometricObserver
from tactometry.observers.raters import Rater, Raters
from tactometry.observers.signal_detection import SignalDetectionObserver
from tactometry.protocols.tasks.rating import pages
from tactometry.psychometric import PsychometricFunction
from tactometry.questionnaire import load

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


# --- raters, by the common factor model

N_RATERS = 2000
FORM = load("attrakdiff")
PAGES = pages(FORM, FORM.items)
PATTERNS = builtin()["time-reversal-patterns"].read_text("utf-8").partition("[observer]")[0]
CELL = {"pattern": "P3"}
STILL = {"attitude_sd": 0.0, "dimension_sd": 0.0, "stimulus_sd": 0.0, "extremity_cv": 0.0, "acquiescence_sd": 0.0}


def rater(person=0, **keys):
    raters = Raters(**{**STILL, "liking": 0.0, "noise": 0.0, **keys})
    draws = lambda *words: stream(5, f"P{person}", *words)  # noqa: E731
    return Rater(raters, draws, dimensions_of([FORM]), {1: CELL}.__getitem__)


def places(one, met=1, liking=0.0, rng=None):
    """Return the answer to each item, from -1 to 1."""
    rng = rng or np.random.default_rng(0)
    found = {}
    for page in PAGES:
        answers = one.answers(page, met, liking, rng)
        found |= {q.item: -a if q.reversed else a for q, a in zip(page.questions, answers, strict=True)}
    return found


def test_effects_act_on_their_dimension_by_loading():
    one = rater(effects={"pattern": {"P3": {"HQS": 0.5}, "P1": {"PQ": 1.0}}}, loadings={"HQS2": -0.4})
    for item, place in places(one).items():
        loading = {"HQS2": -0.4}.get(item, 0.8)
        assert place == pytest.approx(0.5 * loading if item.startswith("HQS") else 0.0)


def test_raters_show_no_effect_without_a_stimulus():
    one = rater(effects={"pattern": {"P3": {"HQS": 0.5}}}, liking=1.0)
    assert set(places(one, met=None, liking=1.0).values()) == {0.0}


def test_liking_is_weighted():
    assert set(places(rater(liking=0.5), liking=0.5).values()) == {0.2}


def test_acquiescence_shifts_every_item_equally():
    one = rater(acquiescence_sd=0.2)
    right = {answer for page in PAGES for answer in one.answers(page, 1, 0.0, np.random.default_rng(0))}
    assert right == {one.acquiescence}


def test_raters_have_the_stated_spreads():
    def attitude(n, **spread):
        return rater(n, **spread).raters.attitude("ATT", CELL, rater(n).draws)

    drawn = {
        0.2: lambda n: attitude(n, attitude_sd=0.2),
        0.1: lambda n: attitude(n, dimension_sd=0.1),
        0.3: lambda n: attitude(n, stimulus_sd=0.3),
        0.15: lambda n: rater(n, acquiescence_sd=0.15).acquiescence,
        0.4: lambda n: np.log(rater(n, extremity_cv=0.4).extremity),
    }
    for sd, of in drawn.items():
        values = np.array([of(n) for n in range(N_RATERS)])
        assert within_sd(values, sd)
        assert abs(values.mean()) <= norm.isf(ALPHA / 2) * sd / np.sqrt(N_RATERS)


def test_items_correlate_according_to_their_loadings():
    """Items with loading l and attitude a have covariance l^2 a^2."""
    rng = np.random.default_rng()
    answers = [places(rater(n, dimension_sd=0.2, noise=0.1), rng=rng) for n in range(N_RATERS)]
    att, att2, pq = (np.array([answer[item] for answer in answers]) for item in ("ATT1", "ATT2", "PQ1"))
    rho = 0.64 * 0.04 / (0.64 * 0.04 + 0.01)
    bound = norm.isf(ALPHA / 2) / np.sqrt(N_RATERS - 3)
    assert abs(np.arctanh(np.corrcoef(att, att2)[0, 1]) - np.arctanh(rho)) <= bound
    assert abs(np.arctanh(np.corrcoef(att, pq)[0, 1])) <= bound
    assert within_sd(att, np.sqrt(0.64 * 0.04 + 0.01))


def test_simulated_study_shows_the_stated_effects():
    """An effect of 2/3 is 2 of the 3 points above the middle of the scale."""
    still = "\n".join(f"{key} = 0.0" for key in (*STILL, "liking", "noise"))
    effects = "[observer.raters.effects.pattern]\nP0 = { ATT = -0.6667, HQS = 0.3333 }\nP3 = { ATT = 0.6667 }\n"
    toml = f"{PATTERNS}[observer.raters]\nloading = 1.0\n{still}\n{effects}"
    rows = simulated_trials(wired(toml), [Who("P01", seed=1)]).rows
    rows = rows[rows["valid"].astype(bool) & rows["item"].notna()]
    scores = {
        pattern: FORM.scores({item: float(raw) for item, raw in zip(of["item"], of["response"], strict=True)})
        for pattern, of in rows.groupby("pattern")
    }
    assert [scores[name]["ATT"] for name in ("P0", "P3", "P1")] == [-2.0, 2.0, 0.0]
    assert {scores[name]["HQI"] for name in scores} == {0.0}
    assert [scores[name]["HQS"] for name in ("P0", "P3")] == [1.0, 0.0]


def test_study_without_raters_has_no_rater():
    experiment = wired(PATTERNS)
    assert experiment.simulated_rig("P01", 1, 1).rater is None


@pytest.mark.parametrize(
    ("raters", "sentence"),
    [
        ("noise = -1.0", "observer.raters.noise: found -1"),
        ("loadings = { Q9 = 0.5 }", "observer.raters.loadings.Q9: found an unknown item"),
        ("loadings = { PQ1 = 1.5 }", "observer.raters.loadings"),
        ("effects.pattern.P9 = { ATT = 1.0 }", "observer.raters.effects.pattern.P9: found an unknown level"),
        ("effects.pattern.P3 = { XX = 1.0 }", "observer.raters.effects.pattern.P3.XX: found an unknown dimension"),
        ("effects.size.P3 = { ATT = 1.0 }", "observer.raters.effects.size: found an unknown factor"),
    ],
)
def test_invalid_raters_are_refused(raters, sentence):
    assert sentence in refusal(f"{PATTERNS}[observer.raters]\n{raters}\n")
