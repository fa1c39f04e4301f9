"""QUEST+, psi and QUEST compared with questplus and PsychoPy."""

import warnings

import numpy as np
import pytest
from scipy.stats import norm
from soak import SOAK

from tactometry.protocols import Quest, QuestPlus, psi
from tactometry.protocols.bayesian.parameter_grid import ParameterGrid
from tactometry.psychometric import shape_named

N_RUNS = 100 if SOAK else 3
N_TRIALS = 30
TIED = 1e-11
"""Losses (nat) this near to each other are equal up to the rounding of either program."""
DB = tuple(float(x) for x in range(-40, 1))
SD = tuple(float(x) for x in (1, 2, 4))
PARAMETERS = {
    1: {"mean": DB, "sd": (3.0,), "lapse_rate": (0.02,)},
    2: {"mean": DB[::2], "sd": (1.5, 3.0, 6.0), "lapse_rate": (0.02,)},
    3: {"mean": DB[::2], "sd": (1.5, 3.0, 6.0), "lapse_rate": (0.0, 0.02, 0.05)},
}


def peer(parameters):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import questplus
    domain = {"lower_asymptote": np.array([0.5])} | {name: np.array(values) for name, values in parameters.items()}
    options = {"outcome_domain": {"response": ["Yes", "No"]}, "func": "norm_cdf", "stim_scale": "linear"}
    return questplus.QuestPlus(stim_domain={"intensity": np.array(DB)}, param_domain=domain, **options)


def ours(parameters):
    widths = tuple(shape_named("normal").z_width * sd for sd in parameters["sd"])
    grid = ParameterGrid(parameters["mean"], widths, (0.5,), parameters["lapse_rate"], shape="normal")
    return QuestPlus(DB, grid, n_trials=10**6).begin()


@pytest.mark.parametrize("n_parameters", PARAMETERS)
def test_choices_equal_those_of_questplus(n_parameters):
    rng, parameters = np.random.default_rng(), PARAMETERS[n_parameters]
    for _ in range(N_RUNS):
        theirs, rule = peer(parameters), ours(parameters)
        truth = rng.uniform(-35, -5)
        for _ in range(N_TRIALS):
            chosen = float(np.asarray(theirs.next_stim["intensity"]))
            losses = rule.expected_loss()
            assert rule.level == chosen or losses[DB.index(chosen)] - losses.min() < TIED
            answer = bool(rng.random() < 0.5 + 0.48 * norm.cdf((chosen - truth) / 3))
            theirs.update(stim={"intensity": chosen}, outcome={"response": "Yes" if answer else "No"})
            rule = rule.after(answer, chosen)
        np.testing.assert_allclose(rule.posterior.ravel(), theirs.posterior.values.ravel(), atol=1e-10)


def test_psi_choices_and_posterior_equal_psychopy():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from psychopy.contrib.psi import PsiObject
    levels, sds, rng = tuple(np.linspace(-10, 10, 21)), tuple(np.linspace(1, 6, 6)), np.random.default_rng()
    for _ in range(N_RUNS):
        theirs = PsiObject((-10, 10), (-10, 10), (1, 6), 1, 1, 1, delta=0.04, TwoAFC=True)
        theirs.update()
        rule = psi(levels, levels, sds, guess_rate=0.5, lapse_rate=0.02, n_trials=1000).begin()
        for _ in range(N_TRIALS):
            losses = rule.expected_loss()
            index = int(theirs.nextIntensityIndex)
            assert levels.index(rule.level) == index or losses[index] - losses.min() < TIED
            answer = int(rng.random() < 0.75)
            theirs.update(answer)
            rule = rule.after(answer, levels[index])
        np.testing.assert_allclose(rule.posterior, theirs._probLambda.squeeze(), atol=1e-10)


def psychopy_quest(**options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from psychopy.contrib.quest import QuestObject
    return QuestObject(**options)


@pytest.mark.parametrize("target", [0.75, 0.82])
@pytest.mark.parametrize("guess", [0.0, 0.5])
def test_quest_equals_psychopy_on_its_grid(target, guess):
    rng = np.random.default_rng()
    theirs = psychopy_quest(
        tGuess=-1.0, tGuessSd=1.0, pThreshold=target, beta=3.5, delta=0.01, gamma=guess, grain=0.01, range=4
    )
    options = {"decade": 1.0, "target": target, "guess_rate": guess, "n_trials": 1000}
    rule = Quest(-1.0, 1.0, -3.0, 1.0, 0.01, **options).begin()
    assert rule.rule.quantile_order == pytest.approx(theirs.quantileOrder, abs=1e-6)
    for _ in range(N_TRIALS):
        assert rule.level == pytest.approx(theirs.quantile(), abs=5e-3)
        assert rule.mean_sd[0] == pytest.approx(theirs.mean(), abs=2e-3)
        answer, level = int(rng.random() < 0.8), float(np.round(theirs.quantile(), 2))
        theirs.update(level, answer)
        rule = rule.after(answer, level)
    assert rule.threshold_sd == pytest.approx(theirs.sd(), rel=1e-2)


@pytest.mark.parametrize("placing", ["quantile", "mean", "mode"])
def test_quest_recovers_a_threshold(placing):
    rng, errors = np.random.default_rng(), []
    start = Quest(20.0, 10.0, 0.0, 40.0, 0.5, placing=placing, n_trials=60)
    for _ in range(30):
        rule, truth = start, rng.uniform(10, 30)
        while not rule.finished:
            rule = rule.after(bool(rng.random() < chance(rule.level - truth)))
        errors.append(float(rule.posterior @ rule.rule.thresholds) - truth)
    assert abs(np.mean(errors)) <= 3.89 * np.std(errors) / np.sqrt(len(errors)) + 0.1
    assert np.std(errors) < 2.0


def chance(away_db):
    """Return Watson and Pelli's function, 0.82 at 0."""
    unscaled = (0.82 - 0.5) / (0.5 * 0.99)
    shift = np.log10(-np.log1p(-unscaled))
    return 0.01 * 0.5 + 0.99 * (1 - 0.5 * np.exp(-(10 ** (3.5 * away_db / 20 + shift))))
