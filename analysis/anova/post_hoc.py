"""Which conditions differ: paired comparisons, Holm's correction, simultaneous intervals, sizes, Bayes factors.

Equivalence: two one-sided tests (Schuirmann 1987) against a bound that is stated before the data are seen.

That a test finds no difference does not show that there is none; this does, up to the bound.

What an interaction consists of: the effect of one factor at each value of another.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, permutations

import numpy as np
import pandas as pd
from scipy.special import logsumexp, nctdtr

from tactometry.arguments.require import between, expect, one_of

from ..arrays import RELATIVE_ZERO, Array, size_of
from ..distributions import ChiSquare, Student
from .design import UndefinedStatistic, within_design

SPREADS, FAR_T = 12.0, 1e4
BAYES_SCALE, LOG_STEP, BELOW, BEYOND = 0.707, 0.02, 8.0, 60.0
"""Of the Bayes factor: the scale of its prior; of its integral the step in the logarithm of g, and how far it reaches
below g = 1 and beyond its peak."""
CORRECTIONS = {"holm": "holm", "bonferroni": "bonf", "sidak": "sidak", "fdr_bh": "fdr_bh", "none": "none"}
"""Corrections of p for the number of tests, with pingouin's names."""
_TESTED = ("difference_low", "difference_high", "t", "p_unc", "dz", "dz_low", "dz_high", "bf10")


@dataclass(frozen=True)
class Pair:
    """Two conditions `a` and `b`, at a level of another factor if there is one (`keys`: the columns that say so), with
    the values of all participants in units of `size`."""

    keys: dict[str, object]
    values: tuple[Array, Array]
    size: float

    @property
    def differences(self) -> Array:
        """Second less first."""
        return self.values[1] - self.values[0]

    @property
    def has_error(self) -> bool:
        """Whether participants differ in their differences by more than rounding."""
        size = max(float(np.abs(values).max()) for values in self.values)
        return float(np.ptp(self.differences)) > RELATIVE_ZERO * size


def pairs(
    table: pd.DataFrame,
    *,
    dependent: str,
    factor: str,
    subject: str,
    by: str | None = None,
    reference: object = None,
    correction: str = "holm",
    interval: float = 0.95,
) -> pd.DataFrame:
    """Paired t-tests between all levels of `factor`, or of all others against `reference`, at each level of `by` if
    given; all corrected together.

    Each pair has its own error: pooling it would ask for sphericity. Other columns are averaged over, which
    `attrs["notes"]` says.

    Returns
    -------
    DataFrame
        Per pair: `a`, `b`, `difference` (b less a) with the interval of this pair alone (`difference_low`,
        `difference_high`; it goes with `p_unc`) and of all pairs together (`simultaneous_low`, `simultaneous_high`; it
        goes with `p_corr`), `t`, `df`, `p_unc`, `p_corr`, `dz` (mean difference over the standard deviation of the
        differences) with its interval by the noncentral t distribution, `bf10` (Rouder et al. 2009, scale 0.707), and a
        `status`: `ok`, or `zero_error` where all participants differ alike, so that there is a difference and no test.

    Raises
    ------
    InvalidParameter
        As `repeated_measures`; and for a correction that is not known.

    >>> table = pd.DataFrame({"who": list("aabbccdd"), "force_n": [1, 2] * 4, "y": [1.0, 3, 2, 3, 2, 5, 1, 2]})
    >>> found = pairs(table, dependent="y", factor="force_n", subject="who")
    >>> found[["a", "b", "difference", "t", "p_corr", "dz"]].round(3).values.tolist()
    [[1.0, 2.0, 1.75, 3.656, 0.035, 1.828]]
    """
    compared, notes = compare(table, dependent, factor, subject, by, "pairs")
    if reference is not None:
        compared = _against(compared, reference, factor)
    result = all_together(pd.DataFrame([_row(pair, interval) for pair in compared]), correction, interval)
    result.attrs["notes"] = notes
    return result


def all_together(result: pd.DataFrame, correction: str, interval: float) -> pd.DataFrame:
    """With the p and the intervals of all rows together, after those of each alone.

    The intervals are Bonferroni's, for every correction but none: all of them hold their differences in at least
    `interval` of studies. Holm's p has no intervals of its own that say where a difference lies; it steps further than
    they do, so that a simultaneous interval may hold 0 where Holm's p is below 5 %, and never the other way round.
    """
    result = result.drop(columns=["simultaneous_low", "simultaneous_high", "p_corr"], errors="ignore")
    # Pairs without error have no p, and count for none.
    n_tested = 1 if correction == "none" else max(1, int(result["p_unc"].notna().sum()))
    df = result["df"].astype(float).to_numpy()
    wider = Student.isf((1 - interval) / 2 / n_tested, df) / Student.isf((1 - interval) / 2, df)
    low, high = (result[f"difference_{end}"].astype(float) for end in ("low", "high"))
    # Halved first: a sum of large ends may overflow.
    half = (high / 2 - low / 2) * wider
    middle = low / 2 + high / 2
    _insert_behind(result, "difference_high", "simultaneous_high", middle + half)
    _insert_behind(result, "difference_high", "simultaneous_low", middle - half)
    _insert_behind(result, "p_unc", "p_corr", adjusted_p(result["p_unc"], correction))
    return result


def _insert_behind(table: pd.DataFrame, name: str, column: str, values: "pd.Series[float]") -> None:
    table.insert(list(table.columns).index(name) + 1, column, values)


def adjusted_p(p: "pd.Series[float]", correction: str) -> "pd.Series[float]":
    """Return p adjusted for the number of tests by `pingouin.multicomp`; a missing p stays missing and counts as none.

    Raises
    ------
    InvalidParameter
        If the correction is none of `CORRECTIONS`.
    """
    import pingouin  # slow to load

    one_of("correction", correction, CORRECTIONS)
    adjusted = pingouin.multicomp(p.astype(float).to_numpy(), method=CORRECTIONS[correction])[1]
    return pd.Series(adjusted, p.index)


def compare(
    table: pd.DataFrame, dependent: str, factor: str, subject: str, by: str | None, where: str
) -> tuple[list[Pair], list[str]]:
    """All pairs of levels, of a complete design, and what a reader must know of it."""
    factors = [factor] if by is None else [factor, by]
    design = within_design(table, dependent=dependent, within=factors, subject=subject, where=where)
    size, levels = size_of(design.values), design.levels[0]
    places: list[dict[str, object]] = [{}] if by is None else [{by: level} for level in design.levels[1]]
    values = design.values.reshape(design.n, len(levels), -1) / size
    compared = []
    for k, place in enumerate(places):
        for i, j in combinations(range(len(levels)), 2):
            keys = place | {"a": levels[i], "b": levels[j]}
            compared.append(Pair(keys, (values[:, i, k], values[:, j, k]), size))
    return compared, list(design.notes)


def _against(compared: Sequence[Pair], reference: object, factor: str) -> list[Pair]:
    """The pairs that hold the reference, which comes first."""
    levels = {pair.keys[side] for pair in compared for side in ("a", "b")}
    names = ", ".join(sorted(map(str, levels)))
    expect(reference in levels, "reference", f"{factor} = {reference}", f"one of {names}")
    turned = [_turned(pair) if pair.keys["b"] == reference else pair for pair in compared]
    return [pair for pair in turned if pair.keys["a"] == reference]


def _turned(pair: Pair) -> Pair:
    keys = pair.keys | {"a": pair.keys["b"], "b": pair.keys["a"]}
    return replace(pair, keys=keys, values=pair.values[::-1])


def _row(pair: Pair, interval: float) -> dict[str, object]:
    from scipy.stats import ttest_rel  # slow to load

    d = pair.differences
    row = {**pair.keys, "difference": float(d.mean()) * pair.size, "n": len(d), "df": len(d) - 1}
    if not pair.has_error:
        return row | dict.fromkeys(_TESTED) | {"status": "zero_error"}
    test = ttest_rel(pair.values[1], pair.values[0])
    t, ends = float(test.statistic), test.confidence_interval(interval)
    dz = (t / np.sqrt(len(d)), *dz_interval(t, len(d), interval))
    tested = (ends.low * pair.size, ends.high * pair.size, t, float(test.pvalue), *dz, bayes_factor(t, len(d)))
    return row | dict(zip(_TESTED, map(float, tested), strict=True)) | {"status": "ok"}


def dz_interval(t: float, n: int, interval: float) -> tuple[float, float]:
    """The ends of the standardised mean difference: noncentralities of t over the root of n (Cumming 2012)."""
    tail = (1 - interval) / 2
    low, high = (_noncentral(t, n - 1, chance) for chance in (1 - tail, tail))
    return low / np.sqrt(n), high / np.sqrt(n)


def _noncentral(t: float, df: int, chance: float) -> float:
    """The noncentrality at which a t or less has this chance.

    Far out the normal part of t has no share: t < x where the root of chi-square over its degrees of freedom is above
    the noncentrality over x (to 20 / t^2; scipy's series takes seconds there, and then has no value).
    """
    from scipy.optimize import brentq  # slow to load

    if abs(t) > FAR_T * np.sqrt(df):
        return float(t * np.sqrt(ChiSquare.isf(chance if t > 0 else 1 - chance, df) / df))

    def above(x: float) -> float:
        share = float(nctdtr(df, x, t))
        # Far out the series has no value: all or nothing lies below t there.
        return (share if np.isfinite(share) else float(x < t)) - chance

    step = SPREADS * (1 + abs(t) / np.sqrt(2 * df))
    return float(brentq(above, t - step, t + step, xtol=1e-9))


def bayes_factor(t: float, n_first: int, n_second: int | None = None) -> float:
    """Return the Bayes factor of a difference, of one sample of differences or of two samples (Rouder, Speckman, Sun,
    Morey and Iverson 2009, Psychonomic Bulletin & Review 16, 225-237, eq. 1 and 2; scale 0.707); infinite beyond the
    floats.

    `pingouin.bayesfactor_ttest` misses the peak of the integrand from t of some hundreds on, and is negative there.
    Over the logarithm of g the integrand falls exponentially on both sides, so that a sum is exact.

    >>> [round(bayes_factor(t, 3), 2) for t in (2.0, 1e4)]
    [1.13, 6908.34]
    """
    n, df = float(n_first), n_first - 1
    if n_second is not None:
        n, df = n_first * n_second / (n_first + n_second), n_first + n_second - 2
    log_null = -(df + 1) / 2 * float(np.log1p(t**2 / df))  # of the null hypothesis: what the integral is divided by
    # The prior has its peak below g = 1 and the likelihood about n g r^2 = t^2 / df; between them it may be flat.
    log_peak = float(np.log(max(1.0, t**2 / (df * n * BAYES_SCALE**2))))
    log_g = np.arange(-BELOW, log_peak + BEYOND, LOG_STEP)
    k = 1 + n * BAYES_SCALE**2 * np.exp(log_g)
    log_likelihood = -(df + 1) / 2 * np.log1p(t**2 / (df * k))
    height = log_likelihood - 0.5 * (np.log(2 * np.pi * k) + log_g + np.exp(-log_g))
    log_integral = logsumexp(height) + np.log(LOG_STEP)
    with np.errstate(over="ignore"):
        return float(np.exp(log_integral - log_null))


def evidence(bf10: float) -> str:
    """A Bayes factor in words (Jeffreys 1961, as Lee and Wagenmakers 2013 name them).

    >>> evidence(12.0), evidence(0.2), evidence(1.5)
    ('strong evidence for a difference', 'moderate evidence for no difference', 'anecdotal evidence for a difference')
    """
    side = "a difference" if bf10 >= 1 else "no difference"
    size = max(bf10, 1 / bf10) if bf10 > 0 else np.inf
    grades: Sequence[tuple[float, str]] = ((100, "extreme"), (30, "very strong"), (10, "strong"), (3, "moderate"))
    word = next((word for bound, word in grades if size > bound), "anecdotal")
    return f"{word} evidence for {side}"


def equivalence(
    table: pd.DataFrame,
    *,
    dependent: str,
    factor: str,
    subject: str,
    bound: float,
    by: str | None = None,
    alpha: float = 0.05,
) -> pd.DataFrame:
    """Two one-sided paired t-tests between all levels of `factor`: is the difference within +-`bound`?

    Returns
    -------
    DataFrame
        Per pair: `difference` (b less a) with its 1 - 2 alpha interval, `t_low` and `t_high` of the two tests, the
        larger `p`, and whether they are `equivalent`. `attrs["p_all"]` is the largest p: the claim that *all* pairs are
        equivalent needs no correction (Berger 1982), and holds at alpha if it is below alpha.

    Raises
    ------
    InvalidParameter
        If `bound` is not above 0 or alpha not between 0 and 0.5; else as `repeated_measures`.

    >>> values = [20.1, 20.3, 22.0, 21.9, 18.7, 18.9, 21.1, 20.9]
    >>> table = pd.DataFrame({"who": list("aabbccdd"), "force_n": [0.5, 1] * 4, "y": values})
    >>> found = equivalence(table, dependent="y", factor="force_n", subject="who", bound=1.0)
    >>> found[["difference", "p", "equivalent"]].round(4).values.tolist()
    [[0.025, 0.0013, True]]
    """
    expect(0 < bound < np.inf, "bound", bound, f"a difference above 0, in the unit of {dependent}")
    between("equivalence", 0, 0.5, alpha=alpha)
    compared, notes = compare(table, dependent, factor, subject, by, "equivalence")
    result = with_verdicts([_equivalence_row(pair, bound, alpha) for pair in compared], bound, alpha)
    result.attrs["notes"] = notes
    return result


def with_verdicts(rows: Sequence[Mapping[str, object]], bound: float, alpha: float) -> pd.DataFrame:
    """A table of pairs with the verdict on each, and that on all of them in `attrs`."""
    result = pd.DataFrame(rows)
    result["equivalent"] = result["p"] < alpha
    result.attrs |= {"p_all": float(result["p"].max()), "bound": bound, "alpha": alpha}
    return result


def _equivalence_row(pair: Pair, bound: float, alpha: float) -> dict[str, object]:
    d = pair.differences
    error = float(d.std(ddof=1)) / np.sqrt(len(d)) if pair.has_error else 0.0
    tested = two_one_sided(float(d.mean()), error, len(d) - 1, bound, alpha, pair.size)
    return {**pair.keys, **tested, "bound": bound, "n": len(d)}


def two_one_sided(
    difference: float, error: float, df: float, bound: float, alpha: float, unit: float
) -> dict[str, float]:
    """The tests of a difference with a standard error, both in multiples of `unit`; without one it is what it is."""
    half, t_low, t_high = 0.0, np.inf, -np.inf
    p = float(abs(difference) >= bound / unit)
    if error > 0:
        half = float(Student.isf(alpha, df)) * error
        t_low = (difference + bound / unit) / error
        t_high = (difference - bound / unit) / error
        p = max(float(Student.sf(t_low, df)), float(Student.cdf(t_high, df)))
    ends = {"low": (difference - half) * unit, "high": (difference + half) * unit}
    return {"difference": difference * unit, **ends, "t_low": t_low, "t_high": t_high, "p": p}


Analysis = Callable[[pd.DataFrame, Sequence[str]], pd.DataFrame]
"""From a table and its factors within participants to effects, in the columns of `repeated_measures`."""

ALPHA = 0.05

KEPT = ("F", "ddof1", "ddof2", "eps_CM", "p_CM_corr", "np2", "np2_low", "np2_high", "ng2")


def simple_effects(
    analysis: Analysis, table: pd.DataFrame, factors: Sequence[str], factor: str, by: str
) -> pd.DataFrame:
    """The effect of `factor` at each value of `by`, averaged over the other `factors`: each an analysis of the values
    there alone, so that no error is shared (Keppel and Wickens 2004, Design and Analysis, chapter 18). `p_corr` is
    Holm's over the values of `by`; where there is no answer `note` says why.

    >>> from tactometry.analysis.anova.within_subjects import repeated_measures
    >>> values = [3.0, 4, 5, 9, 2, 5, 4, 9, 4, 4, 6, 9, 1, 3, 2, 8]
    >>> keys = [(who, force, hz) for who in "abcd" for force in (1, 2) for hz in (60, 240)]
    >>> table = pd.DataFrame(keys, columns=["who", "force_n", "hz"]).assign(y=values)
    >>> def analysis(part, within):
    ...     return repeated_measures(part, dependent="y", within=within, subject="who")
    >>> simple_effects(analysis, table, ["force_n", "hz"], "hz", "force_n")[["force_n", "F"]].round(1).values.tolist()
    [[1.0, 5.4], [2.0, 48.6]]
    """
    others = [name for name in factors if name != by]
    rows = [
        _simple_effect(analysis, there, others, factor) | {by: value} for value, there in table.groupby(by, sort=True)
    ]
    effects = pd.DataFrame(rows, columns=[by, "Source", *KEPT, "note"])
    return effects.assign(p_corr=adjusted_p(effects["p_CM_corr"], "holm"))


def _simple_effect(analysis: Analysis, there: pd.DataFrame, factors: Sequence[str], factor: str) -> dict[str, object]:
    try:
        effects = analysis(there, factors)
    except UndefinedStatistic as refusal:
        return {"Source": factor, "note": str(refusal)}
    effect = effects[effects["Source"] == factor].iloc[0]
    return {"Source": factor, "note": ""} | {name: effect[name] for name in KEPT}


def interaction_orders(effects: pd.DataFrame, factors: Sequence[str]) -> list[tuple[str, str]]:
    """The pairs of factors whose interaction is told at 5 %, each in both orders.

    >>> effects = pd.DataFrame({"Source": ["a", "b", "a * b"], "p_CM_corr": [0.5, 0.2, 0.01]})
    >>> interaction_orders(effects, ["a", "b"])
    [('a', 'b'), ('b', 'a')]
    """
    significant = set(effects.loc[effects["p_CM_corr"] < ALPHA, "Source"])
    # An interaction is named once, in the order of the factors; which order the pair has does not matter.
    orders = permutations(factors, 2)
    return [pair for pair in orders if {" * ".join(pair), " * ".join(pair[::-1])} & significant]
