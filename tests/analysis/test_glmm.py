"""Mixed models of answers against lme4's numbers, quadrature, and the cases that other programs leave unsaid."""

import numpy as np
import pytest
from hard_cases import exact_case, hard_case
from scipy.special import ndtr

from tactometry.analysis.mixed_models import laplace
from tactometry.analysis.mixed_models.glmm import MixedStatus, fit_glmm
from tactometry.errors import InvalidParameter

LEVELS = np.linspace(-3, 3, 7)
N_TRIALS = 20
COUNTS = np.array(
    [
        [0, 1, 10, 15, 18, 20, 20],
        [3, 4, 6, 14, 16, 17, 20],
        [0, 1, 2, 7, 18, 20, 20],
        [0, 0, 2, 3, 5, 15, 17],
        [0, 1, 5, 17, 19, 19, 20],
        [0, 3, 6, 10, 19, 19, 20],
        [0, 0, 2, 9, 17, 20, 20],
        [0, 0, 0, 6, 11, 20, 20],
        [2, 9, 11, 13, 19, 19, 20],
        [0, 0, 7, 12, 16, 20, 20],
        [1, 1, 2, 11, 15, 20, 20],
        [0, 0, 0, 2, 15, 19, 20],
    ]
)
"""12 participants, eta = 0.3 + u0 + 0.9 (1 + u1) x, with standard deviations 0.6 and 0.3."""


def fitted(counts=COUNTS, *, random=("intercept", "level"), **options):
    n = len(counts)
    fixed = {"intercept": 1.0, "level": np.tile(LEVELS, n)}
    participants = np.repeat([f"S{i:02d}" for i in range(n)], len(LEVELS))
    return fit_glmm(np.ravel(counts), N_TRIALS, participants, fixed=fixed, random=random, **options)


# lme4 1.1-31, R 4.2.2, bobyqa to rhoend 1e-9: glmer(cbind(k, n - k) ~ x + (1 + x | s), family = binomial(link))
LME4 = {
    "probit": (
        (-0.0160486205618, 0.9279686088526),
        (0.1681780283, 0.0835367670),
        (0.5535965961, 0.2428084786),
        -0.452016,
    ),
    "logit": (
        (-0.0315114751201, 1.6504800686513),
        (0.3028246370, 0.1548185175),
        (0.9971407988, 0.4453101322),
        -0.423632,
    ),
}


@pytest.mark.parametrize("link", list(LME4))
def test_intercept_and_slope_are_lme4s(link) -> None:
    """The goal is 0.05 SE and 5 % of the SE; reached 0.007 SE and 1.2 %. lme4 takes the expected information."""
    effects, errors, sd, correlation = LME4[link]
    found = fitted(link=link, expected=True)
    assert found.status == MixedStatus.OK
    for name, effect, error, deviation in zip(("intercept", "level"), effects, errors, sd, strict=True):
        assert found.effects[name] == pytest.approx(effect, abs=0.01 * error)
        assert found.standard_errors[name] == pytest.approx(error, rel=0.02)
        assert found.sd[name] == pytest.approx(deviation, rel=2e-3)
    assert found.correlation[0, 1] == pytest.approx(correlation, abs=2e-3)


def test_random_effects_are_lme4s() -> None:
    found = fitted(expected=True)
    assert found.participants["S00"] == pytest.approx([0.571691626820, -0.0206944450629], abs=1e-3)
    assert found.participants["S01"] == pytest.approx([0.319453212663, -0.3701134070915], abs=1e-3)


@pytest.mark.parametrize(
    ("link", "n_nodes", "effects", "errors", "sd"),
    [
        ("probit", 1, (0.0393029496942, 0.8353926430342), (0.1603915761, 0.0347172300), 0.533853740204),
        ("probit", 15, (0.0392111311892, 0.8338214072626), (0.1601806603, 0.0346262282), 0.533181034424),
        ("logit", 1, (0.0690883946921, 1.5048431596730), (0.2960965490, 0.0715916133), 0.987709732391),
        ("logit", 15, (0.069087489274, 1.504826304525), (0.2961028259, 0.0715934007), 0.987731812621),
    ],
)
def test_a_random_intercept_is_lme4s_by_laplace_and_by_quadrature(link, n_nodes, effects, errors, sd) -> None:
    """glmer(..., nAGQ = 1 and 15)."""
    found = fitted(random=("intercept",), link=link, n_nodes=n_nodes, expected=True)
    assert list(found.effects.values()) == pytest.approx(effects, rel=1e-4)
    assert list(found.standard_errors.values()) == pytest.approx(errors, rel=1e-3)
    assert found.sd["intercept"] == pytest.approx(sd, rel=1e-4)


def test_the_observed_information_is_nearer_to_the_quadrature_than_lme4s() -> None:
    observed, expected, exact = fitted(), fitted(expected=True), fitted(n_nodes=7)
    for name in ("intercept", "level"):
        near, far = (abs(one.effects[name] - exact.effects[name]) for one in (observed, expected))
        assert near < 0.2 * far
        assert near < 0.005 * exact.standard_errors[name]
    assert exact.log_likelihood == pytest.approx(observed.log_likelihood, abs=0.5)


def test_no_variance_between_participants_is_said_to_be_singular() -> None:
    """Identical participants: the fixed effects are those of one of them."""
    counts = np.tile(np.round(N_TRIALS * ndtr(LEVELS)).astype(int), (6, 1))
    found = fitted(counts)
    assert found.status == MixedStatus.SINGULAR
    assert found.note
    alone = fitted(counts[:1])
    slopes = found.effects["level"], alone.effects["level"]
    hard_case("a group of identical participants", *slopes, 1e-4, against="one of them")


def test_one_participant_has_no_variance_between_participants() -> None:
    found = fitted(COUNTS[:1])
    assert (found.status, found.sd, found.correlation) == (MixedStatus.ONE_PARTICIPANT, None, None)
    assert found.effects["level"] > 0


@pytest.mark.parametrize("counts", [np.full((5, 7), 20), np.tile([0, 0, 0, 20, 20, 20, 20], (5, 1))], ids=str)
def test_separated_answers_have_no_bare_number(counts) -> None:
    found = fitted(counts, random=("intercept",))
    assert (found.status, found.effects, found.sd) == (MixedStatus.SEPARATED, None, None)
    exact_case("a group whose answers are separated", against="a status, no number")


def test_missing_cells_and_an_all_correct_participant_are_taken_as_they_are() -> None:
    counts = COUNTS.copy()
    counts[0] = N_TRIALS
    n = np.full(counts.shape, N_TRIALS)
    n[1, 3:] = counts[1, 3:] = 0
    participants = np.repeat([f"S{i:02d}" for i in range(12)], 7)
    fixed = {"intercept": 1.0, "level": np.tile(LEVELS, 12)}
    found = fit_glmm(counts.ravel(), n.ravel(), participants, fixed=fixed, random=("intercept",))
    assert found.status == MixedStatus.OK
    assert found.participants["S00"][0] == max(effect[0] for effect in found.participants.values())


def test_a_search_that_stops_on_the_way_has_no_numbers(monkeypatch) -> None:
    monkeypatch.setattr(laplace, "GRADIENT_TOLERANCE", 1e3)
    found = fitted()
    assert (found.status, found.effects, found.sd) == (MixedStatus.NOT_CONVERGED, None, None)


def test_no_trial_gives_no_data() -> None:
    found = fit_glmm([0, 0], [0, 0], ["A", "B"], fixed={"intercept": 1.0}, random=("intercept",))
    assert (found.status, found.effects) == (MixedStatus.NO_DATA, None)


@pytest.mark.parametrize("scale", [1e-9, 1e6])
def test_the_unit_of_the_levels_scales_the_slope(scale) -> None:
    one = fitted()
    participants = np.repeat([f"S{i:02d}" for i in range(12)], 7)
    fixed = {"intercept": 1.0, "level": scale * np.tile(LEVELS, 12)}
    other = fit_glmm(COUNTS.ravel(), N_TRIALS, participants, fixed=fixed, random=("intercept", "level"))
    assert other.effects["level"] * scale == pytest.approx(one.effects["level"], rel=1e-6)
    assert other.standard_errors["level"] * scale == pytest.approx(one.standard_errors["level"], rel=1e-5)


def test_a_known_guess_rate_moves_the_curve() -> None:
    """Forced choices with a chance of 1/2: without it the slope is too flat."""
    counts = (N_TRIALS + COUNTS + 1) // 2
    with_guess = fitted(counts, random=("intercept",), guess_rate=0.5)
    without = fitted(counts, random=("intercept",))
    assert with_guess.effects["level"] == pytest.approx(fitted(random=("intercept",)).effects["level"], abs=0.3)
    assert without.effects["level"] < 0.6 * with_guess.effects["level"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"link": "logt"}, "link: found 'logt', expected one of probit, logit; did you mean 'logit'?"),
        ({"random": ("slope",)}, "random: found 'slope', expected names of fixed effects"),
        ({"n_nodes": 0}, "n_nodes: found 0 with 2 random effects"),
        ({"n_nodes": 2, "random": ("intercept", "level", "level")}, "n_nodes: found 2 with 3 random effects"),
    ],
)
def test_refuses_what_it_does_not_know(options, message) -> None:
    with pytest.raises(InvalidParameter, match=f"^{message[:40]}"):
        fitted(**options)


def test_refuses_columns_that_depend_on_each_other() -> None:
    with pytest.raises(InvalidParameter, match=r"fixed: found columns \(one, two\) that depend on each other"):
        fit_glmm([1, 2, 3], 10, ["A", "B", "C"], fixed={"one": 1.0, "two": 2.0}, random=())


def test_uncorrelated_effects_have_the_likelihood_of_independent_integrals() -> None:
    found, whole = (fitted(correlated=correlated, n_nodes=15) for correlated in (False, True))
    assert found.correlation.tolist() == [[1.0, 0.0], [0.0, 1.0]]
    assert found.log_likelihood < whole.log_likelihood
    points, weights = np.polynomial.hermite_e.hermegauss(81)
    own, slope = (sd * points for sd in (found.sd["intercept"], found.sd["level"]))
    intercept = found.effects["intercept"] + own[:, None, None]
    chance = ndtr(intercept + (found.effects["level"] + slope[:, None]) * LEVELS)
    of_all = [np.prod(chance**k * (1 - chance) ** (N_TRIALS - k), axis=-1) for k in COUNTS]
    total = sum(np.log(weights @ each @ weights / (2 * np.pi)) for each in of_all)
    hard_case("uncorrelated random effects", found.log_likelihood, total, 1e-6, against="an integral")
