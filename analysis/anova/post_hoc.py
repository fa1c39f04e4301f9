"""Pairwise tests, Bayes factors, equivalence and simple effects.

Equivalence is tested by two one-sided tests (Schuirmann 1987) against a bound that was specified before the data were
seen.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, permutations

import numpy as np
import pandas as pd
from scipy.special import logsumexp, nctdtr

from tactometry.arguments.require import between, expect, one_of

from ..arrays import RELATIVE_ZERO, Array, size_of
from ..distributions import ChiSquare, Student
from .design import UndefinedStatistic, within_design

ALPHA = 0.05
SPREADS, FAR_T = 12.0, 1e4
BAYES_SCALE, LOG_STEP, BELOW, BEYOND = 0.707, 0.02, 8.0, 60.0
"""Bayes factor: scale of the prior, step of the integral over log g, and limits of the integral below g = 1 and above
the peak."""
CORRECTIONS = {"holm": "holm", "bonferroni": "bonf", "sidak": "sidak", "fdr_bh": "fdr_bh", "none": "none"}
"""Corrections of p for the number of tests, with their names in pingouin."""
_TESTED = ("difference_low", "difference_high", "t", "p_unc", "dz", "dz_low", "dz_high", "bf10")


@dataclass(frozen=True)
class Pair:
    """Values of all participants in conditions `a` and `b`, scaled by `size`.

    `keys` names the conditions and, if there is another factor, its level.
    """

    keys: dict[str, object]
    values: tuple[Array, Array]
    size: float

    @property
    def differences(self) -> Array:
        return self.values[1] - self.values[0]

    @property
    def has_error(self) -> bool:
        """Return True if differences vary by more than rounding error."""
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
    """Compare pairs of levels, or all levels with `reference`, by t-tests.

    If `by` is set, pairs are compared at each of its levels, with one correction for all tests. Each pair has its own
    error term, as a pooled one would require sphericity. Values are averaged over other columns, with a note in
    `attrs["notes"]`.

    Returns
    -------
    DataFrame
        `a`, `b`, `difference` (b minus a) with its interval (`difference_low`, `difference_high`) and the simultaneous
        interval (`simultaneous_low`, `simultaneous_high`), `t`, `df`, `p_unc`, `p_corr`, `dz` (mean over standard
        deviation of the differences) with its interval, `bf10` (Rouder et al. 2009, scale 0.707), and a `status`: `ok`,
        or `zero_error` if the difference is the same in all participants.

    Raises
    ------
    InvalidParameter
        As `repeated_measures`; and for an unknown correction.

    >>> table = pd.DataFrame({"who": list("aabbccdd"), "force_n": [1, 2] * 4, "y": [1.0, 3, 2, 3, 2, 5, 1, 2]})
    >>> result = pairs(table, dependent="y", factor="force_n", subject="who")
    >>> result[["a", "b", "difference", "t", "p_corr", "dz"]].round(3).values.tolist()
    [[1.0, 2.0, 1.75, 3.656, 0.035, 1.828]]
    """
    compared, notes = compare(table, dependent, factor, subject, by, "pairs")
    if reference is not None:
        compared = _against(compared, reference, factor)
    result = all_together(pd.DataFrame([_row(pair, interval) for pair in compared]), correction, interval)
    result.attrs["notes"] = notes
    return result


def all_together(result: pd.DataFrame, correction: str, interval: float) -> pd.DataFrame:
    """Add simultaneous intervals and p corrected for the number of rows.

    Simultaneous intervals are Bonferroni's for every correction except `none`: in a share of at least `interval` of
    studies, all intervals cover their differences. Holm's p is smaller, so an interval may contain 0 although p is
    below 5 %, but never the reverse.
    """
    result = result.drop(columns=["simultaneous_low", "simultaneous_high", "p_corr"], errors="ignore")
    # Pairs without error have no p and do not count as tests.
    n_tested = 1 if correction == "none" else max(1, int(result["p_unc"].notna().sum()))
    df = result["df"].astype(float).to_numpy()
    wider = Student.isf((1 - interval) / 2 / n_tested, df) / Student.isf((1 - interval) / 2, df)
    low, high = (result[f"difference_{end}"].astype(float) for end in ("low", "high"))
    # Halve before adding, as the sum of large ends may overflow.
    middle, half = low / 2 + high / 2, (high / 2 - low / 2) * wider
    place = list(result.columns).index("difference_high") + 1
    result.insert(place, "simultaneous_low", middle - half)
    result.insert(place + 1, "simultaneous_high", middle + half)
    place = list(result.columns).index("p_unc") + 1
    result.insert(place, "p_corr", adjusted_p(result["p_unc"], correction))
    return result


def adjusted_p(p: "pd.Series[float]", correction: str) -> "pd.Series[float]":
    """Correct p for the number of tests; a missing p does not count.

    Raises `InvalidParameter` if the correction is not one of `CORRECTIONS`.
    """
    import pingouin  # slow to load

    one_of("correction", correction, CORRECTIONS)
    adjusted = pingouin.multicomp(p.astype(float).to_numpy(), method=CORRECTIONS[correction])[1]
    return pd.Series(adjusted, p.index)


def compare(
    table: pd.DataFrame, dependent: str, factor: str, subject: str, by: str | None, where: str
) -> tuple[list[Pair], list[str]]:
    """Return all pairs of levels of a complete design, and its notes."""
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
    """Return the pairs that contain the reference, with the reference as `a`."""
    levels = {pair.keys[side] for pair in compared for side in ("a", "b")}
    names = ", ".join(sorted(map(str, levels)))
    expect(reference in levels, "reference", f"{factor} = {reference}", f"one of {names}")
    chosen = []
    for pair in compared:
        if pair.keys["b"] == reference:
            keys = pair.keys | {"a": pair.keys["b"], "b": pair.keys["a"]}
            chosen.append(Pair(keys, (pair.values[1], pair.values[0]), pair.size))
        elif pair.keys["a"] == reference:
            chosen.append(pair)
    return chosen


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
    """Return the interval of dz by noncentralities of t (Cumming 2012)."""
    tail = (1 - interval) / 2
    low, high = (_noncentrality(t, n - 1, probability) for probability in (1 - tail, tail))
    return low / np.sqrt(n), high / np.sqrt(n)


def _noncentrality(t: float, df: int, probability: float) -> float:
    """Return the noncentrality at which P(T <= t) equals `probability`.

    For very large t scipy's series fails; there the normal part of t is negligible (relative error about 20 / t^2).
    """
    from scipy.optimize import brentq  # slow to load

    if abs(t) > FAR_T * np.sqrt(df):
        return float(t * np.sqrt(ChiSquare.isf(probability if t > 0 else 1 - probability, df) / df))

    def above(x: float) -> float:
        share = float(nctdtr(df, x, t))
        # Far out the series returns NaN; the probability is 0 or 1 there.
        return (share if np.isfinite(share) else float(x < t)) - probability

    step = SPREADS * (1 + abs(t) / np.sqrt(2 * df))
    return float(brentq(above, t - step, t + step, xtol=1e-9))


def bayes_factor(t: float, n_first: int, n_second: int | None = None) -> float:
    """Return the Bayes factor of a paired or two-sample t-test.

    Rouder, Speckman, Sun, Morey and Iverson 2009, Psychonomic Bulletin & Review 16, 225-237, eq. 1 and 2; scale 0.707.
    `pingouin.bayesfactor_ttest` misses the peak of the integrand and is negative if t is several hundred or more. As a
    function of log g the integrand decays exponentially on both sides, so that a sum over equal steps is accurate.

    >>> [round(bayes_factor(t, 3), 2) for t in (2.0, 1e4)]
    [1.13, 6908.34]
    """
    n, df = float(n_first), n_first - 1
    if n_second is not None:
        n, df = n_first * n_second / (n_first + n_second), n_first + n_second - 2
    log_null = -(df + 1) / 2 * float(np.log1p(t**2 / df))
    # The prior peaks below g = 1, the likelihood near n g r^2 = t^2 / df; the integrand may be flat between them.
    log_peak = float(np.log(max(1.0, t**2 / (df * n * BAYES_SCALE**2))))
    log_g = np.arange(-BELOW, log_peak + BEYOND, LOG_STEP)
    k = 1 + n * BAYES_SCALE**2 * np.exp(log_g)
    log_likelihood = -(df + 1) / 2 * np.log1p(t**2 / (df * k))
    height = log_likelihood - 0.5 * (np.log(2 * np.pi * k) + log_g + np.exp(-log_g))
    with np.errstate(over="ignore"):
        return float(np.exp(logsumexp(height) + np.log(LOG_STEP) - log_null))


def evidence(bf10: float) -> str:
    """Describe a Bayes factor (Jeffreys 1961; Lee and Wagenmakers 2013).

    >>> evidence(12.0), evidence(0.2), evidence(1.5)
    ('strong evidence for a difference', 'moderate evidence for no difference', 'anecdotal evidence for a difference')
    """
    side = "a difference" if bf10 >= 1 else "no difference"
    size = max(bf10, 1 / bf10) if bf10 > 0 else np.inf
    grades: Sequence[tuple[float, str]] = ((100, "extreme"), (30, "very strong"), (10, "strong"), (3, "moderate"))
    grade = next((grade for bound, grade in grades if size > bound), "anecdotal")
    return f"{grade} evidence for {side}"


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
    """Test all pairs of levels for equivalence by two one-sided t-tests.

    Returns
    -------
    DataFrame
        For each pair: `difference` (b minus a) with its 1 - 2 alpha interval, `t_low`, `t_high`, `p` (the larger of
        both) and `equivalent`. `attrs["p_all"]` is the largest p: the claim that *all* pairs are equivalent needs no
        correction (Berger 1982).

    Raises
    ------
    InvalidParameter
        If `bound` is not above 0 or alpha not between 0 and 0.5; else as `repeated_measures`.

    >>> values = [20.1, 20.3, 22.0, 21.9, 18.7, 18.9, 21.1, 20.9]
    >>> table = pd.DataFrame({"who": list("aabbccdd"), "force_n": [0.5, 1] * 4, "y": values})
    >>> result = equivalence(table, dependent="y", factor="force_n", subject="who", bound=1.0)
    >>> result[["difference", "p", "equivalent"]].round(4).values.tolist()
    [[0.025, 0.0013, True]]
    """
    expect(0 < bound < np.inf, "bound", bound, f"a difference above 0, in the unit of {dependent}")
    between("equivalence", 0, 0.5, alpha=alpha)
    compared, notes = compare(table, dependent, factor, subject, by, "equivalence")
    rows: list[dict[str, object]] = []
    for pair in compared:
        d = pair.differences
        error = float(d.std(ddof=1)) / np.sqrt(len(d)) if pair.has_error else 0.0
        tested = two_one_sided(float(d.mean()), error, len(d) - 1, bound, alpha, pair.size)
        rows.append({**pair.keys, **tested, "bound": bound, "n": len(d)})
    result = with_verdicts(rows, bound, alpha)
    result.attrs["notes"] = notes
    return result


def with_verdicts(rows: Sequence[Mapping[str, object]], bound: float, alpha: float) -> pd.DataFrame:
    """Return a table of pairs with `equivalent`, and an overall p in `attrs`."""
    result = pd.DataFrame(rows)
    result["equivalent"] = result["p"] < alpha
    result.attrs |= {"p_all": float(result["p"].max()), "bound": bound, "alpha": alpha}
    return result


def two_one_sided(
    difference: float, error: float, df: float, bound: float, alpha: float, unit: float
) -> dict[str, float]:
    """Test a difference by two one-sided tests; p is 0 or 1 if the error is 0.

    `difference` and `error` are in multiples of `unit`.
    """
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
"""Function that returns effects, in the columns of `repeated_measures`, of a table and its within-participant
factors."""
KEPT = ("F", "ddof1", "ddof2", "eps_CM", "p_CM_corr", "np2", "np2_low", "np2_high", "ng2")


def simple_effects(
    analysis: Analysis, table: pd.DataFrame, factors: Sequence[str], factor: str, by: str
) -> pd.DataFrame:
    """Test `factor` at each value of `by`, averaged over the other `factors`.

    Each test uses only the values at that level of `by` (Keppel and Wickens 2004, Design and Analysis, chapter 18).
    `p_corr` is corrected by Holm over the values of `by`. `note` is the reason if there is no result.

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
    rows: list[dict[str, object]] = []
    for value, there in table.groupby(by, sort=True):
        row: dict[str, object] = {by: value, "Source": factor, "note": ""}
        try:
            effects = analysis(there, others)
        except UndefinedStatistic as refusal:
            rows.append(row | {"note": str(refusal)})
            continue
        effect = effects[effects["Source"] == factor].iloc[0]
        rows.append(row | {name: effect[name] for name in KEPT})
    table = pd.DataFrame(rows, columns=[by, "Source", *KEPT, "note"])
    return table.assign(p_corr=adjusted_p(table["p_CM_corr"], "holm"))


def interaction_orders(effects: pd.DataFrame, factors: Sequence[str]) -> list[tuple[str, str]]:
    """Return pairs of factors with a significant interaction, in both orders.

    >>> effects = pd.DataFrame({"Source": ["a", "b", "a * b"], "p_CM_corr": [0.5, 0.2, 0.01]})
    >>> interaction_orders(effects, ["a", "b"])
    [('a', 'b'), ('b', 'a')]
    """
    significant = set(effects.loc[effects["p_CM_corr"] < ALPHA, "Source"])
    orders = permutations(factors, 2)
    return [pair for pair in orders if {" * ".join(pair), " * ".join(pair[::-1])} & significant]
