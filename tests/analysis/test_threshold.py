"""Tests of threshold fits: published values, peers, invariances and hard cases."""

import math
import re

import mpmath
import numpy as np
import pytest
from hard_cases import exact_case, hard_case
from hypothesis import given, settings, strategies as st
from matlab_cases import MATLAB, matlab_case

from tactometry.analysis.threshold.fitting import METHODS, Status, ThresholdFit, fit, fit_many
from tactometry.analysis.threshold.likelihood import by_point
from tactometry.errors import InvalidParameter
from tactometry.psychometric import SHAPES

LEVELS = [0.0010, 0.0015, 0.0020, 0.0025, 0.0030, 0.0035, 0.0040, 0.0045, 0.0050, 0.0060, 0.0070, 0.0080, 0.0100]
CORRECT = [45, 50, 44, 44, 52, 53, 62, 64, 76, 79, 88, 90, 90]
ROWS = " (rows count from 0)"
SEVEN = [1, 2, 3, 4, 5, 6, 7]
RISING = [10, 11, 12, 15, 18, 19, 20]


def fitted(n_correct, levels=SEVEN, n=20, **options) -> ThresholdFit:
    chosen = {"shape": "normal", "guess_rate": 0.5} | options
    return fit(levels, n_correct, n, **chosen)


def log_likelihood(found: ThresholdFit, levels, k, n) -> float:
    yes, no = (found.function.log_probability(levels, answer) for answer in (1, 0))
    return float(np.sum(np.array(k) * yes + (np.array(n) - np.array(k)) * no))


# Published: science 11.4, computed with independent code ("exact": 1e-4 relative)
@pytest.mark.parametrize(
    ("shape", "threshold", "scale", "minus_log_likelihood", "deviance"),
    [
        ("normal", 0.00464782, 0.00141626, 565.95517, 5.932813),
        ("logistic", 0.00463323, 0.00081797, 566.53640, 7.095278),
    ],
)
def test_maximum_likelihood_of_the_published_set(shape, threshold, scale, minus_log_likelihood, deviance) -> None:
    found = fitted(CORRECT, LEVELS, 90, shape=shape, method="likelihood")
    assert found.threshold == pytest.approx(threshold, rel=1e-6)
    assert found.width / SHAPES[shape].z_width == pytest.approx(scale, rel=1e-5)
    assert found.lapse_rate == 0.0
    assert -log_likelihood(found, LEVELS, CORRECT, 90) == pytest.approx(minus_log_likelihood, rel=1e-8)
    assert found.deviance == pytest.approx(deviance, rel=1e-6)


def test_maximum_likelihood_weibull_of_the_published_set() -> None:
    found = fitted(CORRECT, LEVELS, 90, shape="weibull", method="likelihood")
    assert found.function.level(0.5 + 0.5 * (1 - math.exp(-1))) == pytest.approx(0.00515611, rel=1e-5)
    assert SHAPES["weibull"].z_width / found.width == pytest.approx(3.66883, rel=1e-5)


def test_published_set_has_mode_and_interval_of_psignifit() -> None:
    """psignifit 4.3 within 1 %; its interval includes overdispersion."""
    found = fitted(CORRECT, LEVELS, 90)
    assert found.threshold == pytest.approx(0.0046464, rel=0.01)
    assert found.width == pytest.approx(0.0046632, rel=0.01)
    assert 0.004251 < found.interval_low < found.threshold < found.interval_high < 0.004932


@pytest.mark.parametrize("name", MATLAB)
def test_posterior_mode_of_matlab_psignifit(name: str) -> None:
    counts, options, expected = matlab_case(name)
    found, tolerance = fit(*counts, **options), expected["tol"]
    assert found.threshold == pytest.approx(expected["MAP"][0], abs=tolerance["MAP_threshold_abs"])
    assert found.width == pytest.approx(expected["MAP"][1], rel=tolerance["MAP_width_rel"])
    assert found.guess_rate == pytest.approx(expected["MAP"][3], abs=2e-3)


def test_palamedes_demonstration() -> None:
    counts, _, expected = matlab_case("PAL_PFML_demo")
    found = fit(*counts, shape="logistic", guess_rate=0.5, lapse_rate=0.02, method="likelihood")
    assert found.threshold == pytest.approx(expected["alpha"], abs=expected["tol"]["alpha_abs"])
    assert SHAPES["logistic"].z_width / found.width == pytest.approx(expected["beta"], rel=0.01)
    assert (found.interval_low, found.interval_high, found.method) == (None, None, "likelihood")


# Hard cases: a status with a bound or an interval where the data say no more
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("n_correct", "options", "status"),
    [
        ([20] * 7, {}, Status.BELOW),
        ([20] * 7, {"guess_rate": None}, Status.BELOW),
        ([0] * 7, {}, Status.ABOVE),
        ([10] * 7, {}, Status.ABOVE),
        ([0] * 7, {"guess_rate": None, "n_catch": 20}, Status.ABOVE),
        ([15] * 7, {}, Status.FLAT),
        ([20, 19, 18, 15, 12, 11, 10], {}, Status.NON_MONOTONE),
    ],
    ids=["all correct", "all yes", "all wrong", "all chance", "all no", "flat", "falling"],
)
def test_uninformative_data_have_status_without_threshold(n_correct, options, status, method) -> None:
    found = fitted(n_correct, method=method, **options)
    assert found.status == status
    assert (found.threshold, found.width, found.function) == (None, None, None)
    assert found.note
    ends = [end is not None for end in (found.interval_low, found.interval_high)]
    assert any(ends)
    if status in (Status.ABOVE, Status.BELOW):
        assert ends == [status == Status.ABOVE, status == Status.BELOW]


@pytest.mark.parametrize(
    ("n_correct", "has_ends"),
    [([18, 19, 18, 20, 19, 20, 20], [False, True]), ([9, 12, 11, 10, 13, 12, 13], [True, False])],
    ids=["near the ceiling", "near chance"],
)
def test_flat_interval_is_open_toward_possible_thresholds(n_correct, has_ends) -> None:
    found = fitted(n_correct)
    assert (found.status, found.threshold, found.method) == (Status.FLAT, None, "posterior")
    assert [end is not None for end in (found.interval_low, found.interval_high)] == has_ends


@pytest.mark.parametrize(("of", "other"), [("lapse", "guess"), ("guess", "lapse")])
def test_prior_of_each_rate_affects_only_that_rate(of, other) -> None:
    free = {"guess_rate": None, "estimate": "mean"}
    wide, tight = (fitted([4, 3, 5, 10, 15, 17, 16], **free, **{f"{of}_beta": beta}) for beta in (10.0, 200.0))
    assert getattr(tight, f"{of}_rate") < 0.2 * getattr(wide, f"{of}_rate")
    assert getattr(tight, f"{other}_rate") > 0.6 * getattr(wide, f"{other}_rate")


def test_bounds_are_on_correct_side_of_levels() -> None:
    assert fitted([20] * 7).interval_high < 1.0
    assert fitted([0] * 7, guess_rate=None).interval_low > 7.0


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("guess_rate", [None, 0.0, 0.5])
def test_perfect_step_has_threshold_and_width_bound(method, guess_rate) -> None:
    low = 10 if guess_rate else 0
    found = fitted([low] * 3 + [20] * 4, guess_rate=guess_rate, method=method)
    assert found.status == Status.SEPARATED
    assert 3 < found.threshold < 4
    assert found.interval_low < found.threshold < found.interval_high
    assert found.width is None
    assert 0 < found.width_high < 6
    if (method, guess_rate) == ("likelihood", 0.0):
        assert found.threshold == pytest.approx(3.5, rel=1e-12)


def test_single_level_has_proportion_with_exact_interval() -> None:
    found = fitted([15], levels=[3.0])
    assert (found.status, found.threshold, found.interval_low) == (Status.TOO_FEW_LEVELS, None, None)
    assert found.note == "only one level (15 of 20 answers, rate 0.509 to 0.913), so there is no threshold"


def test_two_levels_are_fitted_and_flagged() -> None:
    found = fitted([12, 19], levels=[1, 2])
    assert found.status == Status.TOO_FEW_LEVELS
    assert found.interval_low < found.threshold < found.interval_high


@pytest.mark.parametrize(("levels", "n"), [([], []), (SEVEN, 0), ([math.nan], [0])])
def test_empty_data_have_status_no_data(levels, n) -> None:
    found = fit(levels, np.zeros(len(levels)), n, shape="normal", guess_rate=0.5)
    assert (found.status, found.threshold, found.n_trials) == (Status.NO_DATA, None, 0)


def test_interval_matches_standard_error_for_million_trials() -> None:
    """psignifit's interval is 17 to 20 times too wide here."""
    levels = np.arange(-3.0, 4.0)
    k = np.round(1e6 * (0.5 + 0.48 * np.exp(SHAPES["normal"].log_cdf(levels))))
    found = fit(levels, k, 10**6, shape="normal", guess_rate=0.5)
    assert found.threshold == pytest.approx(0.0, abs=1e-4)
    reach = found.interval_high - found.interval_low
    hard_case("a million trials a level", reach, 2 * 0.003378, 0.005, against="the standard error")


def test_threshold_is_robust_to_many_lapses() -> None:
    found = fitted([0, 5, 37, 74, 75, 76, 75], guess_rate=0.0, n=100)
    assert found.lapse_rate == pytest.approx(0.25, abs=0.05)
    assert found.threshold == pytest.approx(3.0, abs=0.3)


@pytest.mark.parametrize("method", METHODS)
@given(scale=st.sampled_from([1e-12, 1e-9, 1e-3, 1e9]), offset=st.sampled_from([0.0, -5.0, 1e3]))
@settings(max_examples=8, deadline=None)
def test_threshold_scales_and_shifts_with_levels(method, scale, offset) -> None:
    moved = [(x + offset) * scale for x in SEVEN]
    one, other = fitted(RISING, method=method), fitted(RISING, moved, method=method)
    assert other.status == one.status
    for name in ("threshold", "interval_low", "interval_high") if method == "posterior" else ("threshold",):
        assert getattr(other, name) == pytest.approx((getattr(one, name) + offset) * scale, rel=1e-7, abs=1e-7 * scale)
    assert other.width == pytest.approx(one.width * scale, rel=1e-7)


def test_a_huge_offset_with_a_small_spread() -> None:
    levels = 2.0**30 + np.arange(7) * 2.0**-10
    one, other = fitted(RISING, np.arange(7) * 2.0**-10), fitted(RISING, levels)
    moved = other.threshold - 2.0**30
    hard_case("levels of 2^30 with steps of 2^-10", moved, one.threshold, 1e-6, against="levels from 0", floor=1)


@given(order=st.permutations(range(7)), split=st.integers(1, 9))
@settings(max_examples=15, deadline=None)
def test_neither_order_nor_splitting_of_rows_matters(order, split) -> None:
    levels, k = (np.array(values)[list(order)] for values in (SEVEN, RISING))
    part = np.minimum(k, split)
    whole = fitted(RISING)
    shuffled = fitted(np.r_[part, k - part], np.r_[levels, levels], np.repeat([split, 20 - split], 7))
    assert shuffled.threshold == pytest.approx(whole.threshold, rel=1e-9)
    assert shuffled.interval_high == pytest.approx(whole.interval_high, rel=1e-9)
    assert shuffled.n_levels == 7


def test_levels_that_differ_by_rounding_are_one_level() -> None:
    found = fitted([*RISING[:3], 8, *RISING[4:], 7], [*SEVEN, 4 + 1e-12], [20, 20, 20, 10, 20, 20, 20, 10])
    assert found.n_levels == 7
    assert found.threshold == pytest.approx(fitted(RISING).threshold, rel=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_batch_equals_single_fits(method: str) -> None:
    stack = [RISING, [20] * 7, [10, 10, 10, 20, 20, 20, 20], [10, 12, 11, 13, 17, 20, 19]]
    together = fit_many(SEVEN, stack, 20, shape="normal", guess_rate=0.5, method=method)
    for row, found in zip(stack, together, strict=True):
        alone = fitted(row, method=method)
        assert found.status == alone.status
        for name in ("threshold", "interval_low", "interval_high"):
            one, other = getattr(found, name), getattr(alone, name)
            assert (one is None) == (other is None)
            assert one is None or one == pytest.approx(other, rel=1e-6)


def test_catch_trials_affect_free_guess_rate() -> None:
    k = [6, 7, 9, 12, 16, 19, 20]
    few = fitted(k, guess_rate=None, n_false_alarms=0, n_catch=200)
    many = fitted(k, guess_rate=None, n_false_alarms=60, n_catch=200)
    assert few.guess_rate < 0.02
    assert many.guess_rate == pytest.approx(0.3, abs=0.05)
    assert few.threshold < many.threshold


SHAPES_OF, RATES = "levels, n_correct, n_trials: found the shapes", "guess_rate, lapse_rate: "
NO_LOGARITHM = "levels, row 0: found 0, expected a level above 0, as its logarithm is fitted"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"levels": [1, math.nan, 3]}, "levels, row 1: found nan, expected a finite number" + ROWS),
        ({"levels": [1, 2, -math.inf]}, "levels, row 2: found -inf, expected a finite number" + ROWS),
        ({"levels": [1, "2", 3]}, "levels, row 0: found '1', expected a number"),
        ({"levels": [1, None, 3]}, "levels, row 1: found None, expected a number"),
        ({"n_correct": [1, 2, 21]}, "n_correct, row 2: found 21, expected at most n_trials of the row" + ROWS),
        ({"n_correct": [-1, 2, 3]}, "n_correct, row 0: found -1, expected a whole number, 0 or more" + ROWS),
        ({"n_correct": [1, 9.5, 3]}, "n_correct, row 1: found 9.5, expected a whole number, 0 or more" + ROWS),
        ({"n_correct": [1, math.nan, 3]}, "n_correct, row 1: found nan, expected a whole number, 0 or more" + ROWS),
        ({"n_trials": [20, 20, math.inf]}, "n_trials, row 2: found inf, expected a whole number, 0 or more" + ROWS),
        ({"n_trials": [20, 20]}, f"{SHAPES_OF} (1, 3), (1, 3), (1, 2), expected equal shapes"),
        ({"n_correct": [9]}, f"{SHAPES_OF} (1, 3), (1, 1), (1, 3), expected equal shapes"),
        ({"levels": [[1, 2, 3]]}, "levels: found 2 dimensions, expected 1; use fit_many for stacks of data sets"),
        ({"shape": "norml"}, f"shape: found 'norml', expected one of {', '.join(SHAPES)}; did you mean 'normal'?"),
        ({"shape": "weibull", "levels": [0, 1, 2]}, NO_LOGARITHM + ROWS),
        ({"method": "bayes"}, "method: found 'bayes', expected one of posterior, likelihood"),
        ({"interval": 95}, "fit.interval: found 95, expected a number above 0 and below 1"),
        ({"guess_rate": 1.0}, "fit.guess_rate: found 1.0, expected a number from 0 to below 1"),
        ({"lapse_rate": 0.5}, RATES + "found 0.5 and 0.5, expected a sum below 1 (a free rate may reach 0.5)"),
        ({"n_false_alarms": 3, "n_catch": 2}, "n_false_alarms: found [3], expected at most n_catch, [2]"),
    ],
)
def test_invalid_arguments_are_rejected_with_place(change: dict, message: str) -> None:
    arguments = {"levels": [1, 2, 3], "n_correct": [1, 2, 3], "n_trials": [20, 20, 20], "shape": "normal"}
    with pytest.raises(InvalidParameter, match=f"^{re.escape(message)}$"):
        fit(**(arguments | {"guess_rate": 0.5} | change))


def test_errors_name_the_data_set_of_batch() -> None:
    with pytest.raises(InvalidParameter, match=re.escape("n_correct, row 1 of data set 2: found 21")):
        fit_many([1, 2, 3], [[1, 2, 3], [1, 2, 3], [1, 21, 3]], 20, shape="normal", guess_rate=0.5)


def test_fit_has_default_shape_and_free_guess_rate() -> None:
    counts = [1, 2, 3, 4, 5], [1, 3, 10, 18, 20], 20
    assert fit(*counts) == fit(*counts, shape="normal", guess_rate=None)
    assert fit_many(*counts) == (fit(*counts),)


@pytest.mark.parametrize("k", [[10] * 3 + [20] * 4, [20] * 7])
def test_method_is_posterior_when_likelihood_has_no_maximum(k) -> None:
    assert fitted(k, method="likelihood").method == "posterior"


DIGITS = 50
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
    found = fit([0.0, 1e-10, 2e-10, 1.0], [4, 5, 5, 19], 20, shape="normal", guess_rate=0.0, method=method)
    assert found.n_levels == 2
    assert found.status in (Status.TOO_FEW_LEVELS, Status.SEPARATED)


def test_two_single_trials_are_not_ok() -> None:
    found = fit([1.0, 2.0], [0, 1], 1, shape="normal", guess_rate=0.0)
    assert found.status != Status.OK
    assert found.note
