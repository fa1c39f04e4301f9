"""Tests of hard single fits, and of the likelihood to 50 digits."""

import mpmath
import numpy as np
import pytest
from hard_cases import exact_case, hard_case

from tactometry.analysis.threshold.fitting import METHODS, Status, fit
from tactometry.analysis.threshold.likelihood import by_point
from tactometry.psychometric import SHAPES

DIGITS = 50
SEVEN = [1, 2, 3, 4, 5, 6, 7]
RISING = [10, 11, 12, 15, 18, 19, 20]
CDF = {
    "normal": lambda z: mpmath.erfc(-z / mpmath.sqrt(2)) / 2,
    "logistic": lambda z: 1 / (1 + mpmath.exp(-z)),
    "gumbel": lambda z: -mpmath.expm1(-mpmath.exp(z)),
    "reversed_gumbel": lambda z: mpmath.exp(-mpmath.exp(-z)),
}
SURVIVAL = {
    "normal": lambda z: mpmath.erfc(z / mpmath.sqrt(2)) / 2,
    "logistic": lambda z: 1 / (1 + mpmath.exp(z)),
    "gumbel": lambda z: mpmath.exp(-mpmath.exp(z)),
    "reversed_gumbel": lambda z: -mpmath.expm1(-mpmath.exp(-z)),
}


def exact(shape, z, guess, lapse, n_yes, n_no):
    span = 1 - guess - lapse
    yes, no = guess + span * CDF[shape](z), lapse + span * SURVIVAL[shape](z)
    return (n_yes * mpmath.log(yes) if n_yes else 0) + (n_no * mpmath.log(no) if n_no else 0)


@pytest.mark.parametrize("shape", list(CDF))
@pytest.mark.parametrize("rates", [(0.5, 0.02), (0.0, 0.0), (0.5, 0.0), (0.03, 0.2)], ids=str)
@pytest.mark.parametrize("answers", [(3, 17), (0, 20), (20, 0)], ids=str)
def test_likelihood_and_derivatives_match_50_digits(shape, rates, answers) -> None:
    """Compare on the linear scale and in the tails, for z from -30 to 30."""
    places = [-30.0, -12.0, -3.0, -0.4, 0.0, 0.7, 2.5, 4.0, 9.0, 30.0]
    places = {"gumbel": places[:8], "reversed_gumbel": [-4.0, -2.5, 0.0, 0.7, 3.0, 12.0, 30.0]}.get(shape, places)
    z, (guess, lapse) = np.array([[place] for place in places]), (np.full((1, 1), rate) for rate in rates)
    n_yes, n_no = (np.full(z.shape, float(n)) for n in answers)
    values, slopes = by_point(SHAPES[shape], z, guess, lapse, (n_yes, n_no))
    with mpmath.workdps(DIGITS):
        for i, place in enumerate(places):
            arguments = (mpmath.mpf(place), mpmath.mpf(rates[0]), mpmath.mpf(rates[1]))

            def value(x, g, l, *, shape=shape):  # noqa: E741
                return exact(shape, x, g, l, *answers)

            log_chance = float(value(*arguments))
            hard_case("log-likelihood in the tails", values[i, 0], log_chance, 1e-12, against="50 digits", floor=0.1)
            slope = float(mpmath.diff(lambda x, a=arguments: value(x, *a[1:]), arguments[0]))
            hard_case("slope of the likelihood", slopes.z[i, 0], slope, 1e-9, against="50 digits", floor=1e-3)
            bend = float(mpmath.diff(lambda x, a=arguments: value(x, *a[1:]), arguments[0], 2))
            hard_case("curvature of the likelihood", slopes.zz[i, 0], bend, 1e-8, against="50 digits", floor=1e-3)
            if min(rates) > 0:
                by_lapse = float(mpmath.diff(lambda x, a=arguments: value(*a[:2], x), arguments[2]))
                by_guess = float(mpmath.diff(lambda x, a=arguments: value(a[0], x, a[2]), arguments[1]))
                assert slopes.lapse[i, 0] == pytest.approx(by_lapse, rel=1e-9, abs=1e-12)
                assert slopes.guess[i, 0] == pytest.approx(by_guess, rel=1e-9, abs=1e-12)


def test_three_hundred_levels_with_one_trial_each() -> None:
    rng = np.random.default_rng()
    x = rng.uniform(-4, 4, 300)
    k = (x + rng.logistic(size=300) > 0).astype(int)
    found = fit(x, k, 1, shape="logistic", guess_rate=0.0)
    assert found.status == Status.OK
    assert found.n_levels == 300
    half = (found.interval_high - found.interval_low) / 2
    assert abs(found.threshold) < 2 * half


def test_rows_without_trials_are_ignored() -> None:
    one = fit(SEVEN, RISING, 20, shape="normal", guess_rate=0.5)
    other = fit([*SEVEN, 40, -3], [*RISING, 0, 0], [20] * 7 + [0, 0], shape="normal", guess_rate=0.5)
    numbers, expected = ({key: v for key, v in vars(found).items() if isinstance(v, float)} for found in (other, one))
    assert numbers == pytest.approx(expected, rel=1e-12)  # sums of nine and of seven terms are rounded differently


@pytest.mark.parametrize("method", METHODS)
def test_nearly_equal_asymptotes_have_no_threshold(method) -> None:
    found = fit(
        SEVEN, [18, 18, 17, 18, 19, 18, 18], 20, shape="normal", guess_rate=0.9, lapse_rate=0.0999, method=method
    )
    assert found.status in (Status.FLAT, Status.ABOVE, Status.BELOW)
    assert found.threshold is None
    exact_case("asymptotes that all but meet", against="a status, no number")


@pytest.mark.parametrize(
    "levels", [[0.0, 1e-9, 2e-9, 3e-9], [0.0, 1e9, 2e9, 3e9], [1e-12, 2e-12, 3e-12, 4e-12]], ids=str
)
def test_levels_of_any_size_give_the_same_curve(levels) -> None:
    one = fit([0.0, 1.0, 2.0, 3.0], [1, 6, 14, 20], 20, shape="normal", guess_rate=0.0)
    other = fit(levels, [1, 6, 14, 20], 20, shape="normal", guess_rate=0.0)
    spacing = levels[1] - levels[0]
    scaled = (other.threshold - levels[0]) / spacing
    hard_case("levels 1e-12 to 1e9 apart", scaled, one.threshold, 1e-6, against="levels 1 apart")
    assert other.width / spacing == pytest.approx(one.width, rel=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_levels_with_extreme_spacing_are_pooled(method) -> None:
    """Three levels within 1e-9 of the fourth's distance become one."""
    found = fit([0.0, 1e-10, 2e-10, 1.0], [4, 5, 5, 19], 20, shape="normal", guess_rate=0.0, method=method)
    assert found.n_levels == 2
    assert found.status in (Status.TOO_FEW_LEVELS, Status.SEPARATED)


def test_two_single_trials_are_not_ok() -> None:
    found = fit([1.0, 2.0], [0, 1], 1, shape="normal", guess_rate=0.0)
    assert found.status != Status.OK
    assert found.note
