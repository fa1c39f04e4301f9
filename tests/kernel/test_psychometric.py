"""Psychometric functions: properties, tails, psignifit, refusals."""

import math
import re

import mpmath
import numpy as np
import pytest
from hard_cases import hard_case
from hypothesis import assume, given, strategies as st

from tactometry.errors import InvalidParameter
from tactometry.psychometric import SHAPES, PsychometricFunction, log1mexp

shapes = pytest.mark.parametrize("shape", list(SHAPES))
rates = st.floats(0.0, 0.45)


def function(shape: str, threshold: float = 2.0, width: float = 1.5, guess: float = 0.5, lapse: float = 0.02):
    return PsychometricFunction(shape, threshold, width, guess, lapse)


@shapes
@given(threshold=st.floats(1e-6, 1e6), width=st.floats(1e-3, 1e3), guess=rates, lapse=rates)
def test_unscaled_function_is_one_half_at_threshold(shape, threshold, width, guess, lapse) -> None:
    f = function(shape, threshold, width, guess, lapse)
    assert f.probability(threshold) == pytest.approx(guess + (1 - guess - lapse) / 2, rel=1e-12)


@shapes
@given(threshold=st.floats(0.1, 10), width=st.floats(1e-3, 10))
def test_width_spans_from_5_to_95_percent(shape, threshold, width) -> None:
    low, high = function(shape, threshold, width, 0, 0).level([0.05, 0.95])
    spanned = math.log(high / low) if SHAPES[shape].on_log_levels else high - low
    assert spanned == pytest.approx(width, rel=1e-9)


@shapes
@given(p=st.floats(1e-6, 1 - 1e-6), width=st.floats(0.01, 5), guess=rates, lapse=rates)
def test_level_inverts_probability(shape, p, width, guess, lapse) -> None:
    f = function(shape, 3.0, width, guess, lapse)
    scaled = guess + (1 - guess - lapse) * p
    assume(guess < scaled < 1 - lapse)
    assert f.probability(f.level(scaled)) == pytest.approx(scaled, rel=1e-9)


@shapes
@given(a=st.floats(0.01, 100), b=st.floats(0.01, 100))
def test_probability_never_falls_with_level(shape, a, b) -> None:
    low, high = sorted((a, b))
    f = function(shape)
    assert f.probability(low) <= f.probability(high)


@shapes
@given(x=st.floats(0.001, 1e4), guess=rates, lapse=rates)
def test_probabilities_of_both_responses_sum_to_one(shape, x, guess, lapse) -> None:
    yes, no = function(shape, guess=guess, lapse=lapse).log_probability(x, [1, 0])
    assert np.logaddexp(yes, no) == pytest.approx(0.0, abs=1e-13)


@given(x=st.floats(-50, 50), lapse=rates, guess=rates)
def test_reversed_gumbel_mirrors_gumbel(x, lapse, guess) -> None:
    gumbel = PsychometricFunction("gumbel", 0, 2, guess, lapse)
    mirrored = PsychometricFunction("reversed_gumbel", 0, 2, lapse, guess)
    assert gumbel.log_probability(x, 1) == pytest.approx(float(mirrored.log_probability(-x, 0)), rel=1e-12)


@given(x=st.floats(1e-3, 1e3), scale=st.floats(1e-9, 1e9))
def test_weibull_is_independent_of_the_level_unit(x, scale) -> None:
    one, other = function("weibull", 2.0), function("weibull", 2.0 * scale)
    assert other.probability(x * scale) == pytest.approx(float(one.probability(x)), rel=1e-9)


def test_weibull_is_one_minus_exp_of_a_power() -> None:
    """In 1 - exp(-(x/a)^b), b is 4.0673839 / width (science 8.1)."""
    f = PsychometricFunction("weibull", 2.0, 1.2, 0.0, 0.0)
    a, b = f.level(1 - math.exp(-1)), SHAPES["weibull"].z_width / 1.2
    x = np.array([0.1, 0.7, 2.0, 5.0])
    assert f.probability(x) == pytest.approx(-np.expm1(-((x / a) ** b)), rel=1e-12)


@pytest.mark.parametrize(
    ("shape", "width"),
    [("normal", 3.2897073), ("logistic", 5.8888780), ("gumbel", 4.0673839), ("reversed_gumbel", 4.0673839)],
)
def test_standard_shapes_have_their_published_widths(shape: str, width: float) -> None:
    assert SHAPES[shape].z_width == pytest.approx(width, abs=5e-8)


@pytest.mark.parametrize(("lapse", "at_threshold"), [(0.0, 0.75), (0.02, 0.74)])
def test_two_alternative_probability_at_threshold(lapse: float, at_threshold: float) -> None:
    assert function("normal", lapse=lapse).probability(2.0) == pytest.approx(at_threshold, rel=1e-14)


def exact_log_cdf(shape: str, z: float) -> mpmath.mpf:
    z = mpmath.mpf(z)
    return {
        "normal": lambda: mpmath.log(mpmath.erfc(-z / mpmath.sqrt(2)) / 2),
        "logistic": lambda: -mpmath.log1p(mpmath.exp(-z)),
        "gumbel": lambda: mpmath.log(-mpmath.expm1(-mpmath.exp(z))),
        "reversed_gumbel": lambda: -mpmath.exp(-z),
    }[shape]()


@pytest.mark.parametrize("shape", ["normal", "logistic", "gumbel", "reversed_gumbel"])
@pytest.mark.parametrize("z", [-600.0, -40.0, -36.9, -5.0, -0.3, 0.0, 0.4, 3.0, 6.0])
def test_log_probabilities_match_fifty_digit_values(shape: str, z: float) -> None:
    with mpmath.workdps(50):
        exact = exact_log_cdf(shape, z)
        sf = mpmath.log(-mpmath.expm1(exact))
        found = float(SHAPES[shape].log_cdf(np.array(z))), float(SHAPES[shape].log_sf(np.array(z)))
        hard_case("log chance at -600 to 6", found[0], float(exact), 1e-13, against="50 digits", floor=1)
        if z < 6 or shape != "gumbel":
            hard_case("log of the other chance", found[1], float(sf), 1e-12, against="50 digits", floor=1)


@shapes
@given(z=st.floats(-6, 6))
def test_densities_and_scores_are_derivatives(shape, z) -> None:
    standard, h = SHAPES[shape], 1e-5
    at = np.array([z - h, z, z + h])
    density = np.diff(np.exp(standard.log_cdf(at)))
    assume(density.min() > 1e-9)
    assert np.exp(standard.log_pdf(at[1:2]))[0] == pytest.approx(density.mean() / h, rel=1e-3)
    slope = (standard.log_pdf(at[2:])[0] - standard.log_pdf(at[:1])[0]) / (2 * h)
    assert standard.score(at[1:2])[0] == pytest.approx(slope, rel=1e-5, abs=1e-6)


def test_lapses_bound_log_probability_far_from_threshold() -> None:
    f = function("logistic", 0.0, 1.0, 0.5, 0.01)
    assert f.log_probability([1e300, -1e300], [0, 1]) == pytest.approx([math.log(0.01), math.log(0.5)])


def test_far_tails_keep_their_digits() -> None:
    f = function("logistic", 0.0, SHAPES["logistic"].z_width, 0.0, 0.0)
    hard_case("answers of chance e^-800", f.log_probability([-800.0, 800.0], [1, 0]), -800.0, 1e-14, against="-800")


def test_log1mexp_is_exact_at_both_ends() -> None:
    assert log1mexp(np.array([0.0, 1e-20, 50.0])) == pytest.approx([-np.inf, math.log(1e-20), -math.exp(-50)])


@pytest.mark.parametrize(
    ("ours", "theirs"),
    [("normal", "norm"), ("logistic", "logistic"), ("gumbel", "gumbel"), ("reversed_gumbel", "rgumbel")],
)
def test_psychometric_function_equals_psignifit(ours: str, theirs: str) -> None:
    psignifit = pytest.importorskip("psignifit.sigmoids")
    x = np.linspace(-3, 6, 50)
    f = function(ours, 1.3, 2.1, 0.0, 0.0)
    assert f.probability(x) == pytest.approx(psignifit.sigmoid_by_name(theirs)(x, 1.3, 2.1), rel=1e-9, abs=1e-15)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("norml", 1, 1, 0, 0), f"shape: found 'norml', expected one of {', '.join(SHAPES)}; did you mean 'normal'?"),
        (("normal", math.nan, 1, 0, 0), "threshold: found nan, expected a finite level"),
        (("weibull", 0.0, 1, 0, 0), "threshold: found 0.0, expected a finite level above 0 for the shape 'weibull'"),
        (("normal", 1, 0.0, 0, 0), "PsychometricFunction.width: found 0.0, expected a finite number above 0"),
        (("normal", 1, math.inf, 0, 0), "PsychometricFunction.width: found inf, expected a finite number above 0"),
        (("normal", 1, 1, -0.1, 0), "PsychometricFunction.guess_rate: found -0.1, expected a number from 0 to 1"),
        (("normal", 1, 1, 0, math.nan), "PsychometricFunction.lapse_rate: found nan, expected a number from 0 to 1"),
        (("normal", 1, 1, 0.5, 0.5), "guess_rate, lapse_rate: found 0.5 and 0.5, expected a sum below 1"),
    ],
)
def test_psychometric_function_refuses_impossible_parameters(
    arguments: tuple[str, float, float, float, float], message: str
) -> None:
    with pytest.raises(InvalidParameter, match=f"^{re.escape(message)}$"):
        PsychometricFunction(*arguments)


def test_psychometric_function_refuses_invalid_arguments() -> None:
    f = function("weibull")
    for call, message in (
        (lambda: f.probability(math.nan), "level: found nan, expected numbers, not NaN"),
        (lambda: f.probability("loud"), "level: found 'loud', expected numbers"),
        (lambda: f.probability(0.0), "level: found 0.0, expected levels above 0 for the shape 'weibull'"),
        (lambda: f.log_probability(1.0, 2), "response: found 2, expected 1 or 0"),
        (lambda: f.level(0.99), "probability: found 0.99, expected values between the asymptotes, 0.5 and 0.98"),
    ):
        with pytest.raises(InvalidParameter, match=f"^{re.escape(message)}$"):
            call()
