"""Simulated raters: answers follow the stated common factor model."""

import numpy as np
import pytest
from bounds import ALPHA, within_sd
from scipy.stats import norm
from study_texts import refusal, wired

from tactometry.experiments.sessions.in_memory import simulated_trials
from tactometry.experiments.sessions.recording import Who
from tactometry.experiments.study.session_plan import stream
from tactometry.experiments.study.study_file import builtin
from tactometry.experiments.study.task_table import dimensions_of
from tactometry.observers.raters import Rater, Raters
from tactometry.protocols.tasks.rating import pages
from tactometry.questionnaire import load

N = 2000
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
        values = np.array([of(n) for n in range(N)])
        assert within_sd(values, sd)
        assert abs(values.mean()) <= norm.isf(ALPHA / 2) * sd / np.sqrt(N)


def test_items_correlate_according_to_their_loadings():
    """Items with loading l and attitude a have covariance l^2 a^2."""
    rng = np.random.default_rng()
    answers = [places(rater(n, dimension_sd=0.2, noise=0.1), rng=rng) for n in range(N)]
    att, att2, pq = (np.array([answer[item] for answer in answers]) for item in ("ATT1", "ATT2", "PQ1"))
    rho = 0.64 * 0.04 / (0.64 * 0.04 + 0.01)
    bound = norm.isf(ALPHA / 2) / np.sqrt(N - 3)
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
