"""Repeated-measures ANOVA by pingouin and statsmodels.

This module adds the Huynh-Feldt and Chi-Muller corrections, partial eta squared, and intervals of effect sizes from the
noncentral F distribution.
"""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import ncfdtr

from ..arrays import Array, size_of
from ..distributions import Fisher
from ..wording import p_text, share_text
from .design import (
    MOST_EXACT,
    ContrastEffect,
    DesignStatus,
    WithinDesign,
    effects,
    epsilons,
    participant_scores,
    permutation_p,
    spread,
    within_design,
)

INTERVAL = 0.90
"""An interval with this coverage excludes 0 exactly if the test is significant at 5 % (Steiger 2004)."""
ALPHA = 0.05
LARGEST = 1e7
MANY_SD = 3.0
MAX_SHAPIRO = 5000
"""Largest number of values for which the p of the Shapiro-Wilk test is accurate."""
SIZES = ("np2", "np2_low", "np2_high", "ng2", "ng2_low", "ng2_high")
"""Columns of partial and generalised eta squared, each with its interval."""
MISSING = (np.nan, np.nan)


def repeated_measures(
    table: pd.DataFrame, *, dependent: str, within: Sequence[str] | str, subject: str, interval: float = INTERVAL
) -> pd.DataFrame:
    """Compute a one- to three-way repeated-measures analysis of variance.

    Parameters
    ----------
    table : DataFrame
        Long form. Several values of a participant in one cell are averaged, with a note in `attrs["notes"]`.
    dependent, subject : str
        Columns of the values and of the participants.
    within : str or sequence of str
        One to three columns of conditions, each with at least two levels.
    interval : float
        Coverage of the intervals of the effect sizes.

    Returns
    -------
    DataFrame
        Pingouin's columns, Huynh-Feldt and Chi-Muller epsilon and p (`eps_HF`, `p_HF_corr`, `eps_CM`, `p_CM_corr`),
        and eta squared with intervals (`SIZES`) for the Chi-Muller test. Report the Chi-Muller test. `attrs` has
        `notes`, `n` participants, `status` (`DesignStatus`) and `library`, which computed F.

    Raises
    ------
    InvalidParameter
        For a missing column. `UndefinedStatistic` is raised for values that are not finite, missing cells, fewer than
        three participants, fewer than two levels, or data without variance.

    Notes
    -----
    The Chi-Muller correction keeps the false-positive rate closest to 5 % (docs/reference/analysis.md). With fewer
    participants than contrasts the error matrix is singular: Mauchly's test is undefined, but the corrections are
    valid. An effect that is the same in all participants has no F; a note states this.

    >>> values = [3.0, 4, 6, 2, 5, 6, 4, 4, 7, 1, 3, 5]
    >>> table = pd.DataFrame({"who": list("aaabbbcccddd"), "force_n": [0.5, 1, 2] * 4, "y": values})
    >>> result = repeated_measures(table, dependent="y", within="force_n", subject="who")
    >>> result[["F", "p_unc", "np2"]].iloc[0].round(4).tolist()
    [27.75, 0.0009, 0.9024]
    """
    design = within_design(table, dependent=dependent, within=within, subject=subject, where="repeated_measures")
    scaled, scale = scaled_design(design, dependent)
    result = effects(scaled)
    tested, library = _tested(scaled, result)

    between = participant_scores(scaled)
    residual = float(np.sum((between - between.mean()) ** 2)) + sum(effect.ss_error for effect in result)
    singular = [singular_note(effect, design.n) for effect in result if effect.ss_error > 0 and effect.is_singular]
    return with_notes(effect_table(tested, residual, scale, interval), design, library, tested, singular)


def permutation_test(
    table: pd.DataFrame,
    *,
    dependent: str,
    within: Sequence[str] | str,
    subject: str,
    rng: np.random.Generator | None = None,
    n_resamples: int = 9_999,
) -> pd.DataFrame:
    """Test each effect by sign changes of the participants' contrasts.

    The test assumes symmetric errors. It needs neither sphericity nor more participants than contrasts. It is exact up
    to 14 participants; with more, `rng` draws `n_resamples` sign changes.

    Raises
    ------
    InvalidParameter
        As `repeated_measures`; also if `rng` is needed but missing.

    >>> table = pd.DataFrame({"who": list("aabbccdd"), "force_n": [0.5, 1] * 4, "y": [1.0, 2, 2, 4, 3, 6, 2, 6]})
    >>> permutation_test(table, dependent="y", within="force_n", subject="who")["p_permutation"].tolist()
    [0.125]
    """
    design = within_design(table, dependent=dependent, within=within, subject=subject, where="repeated_measures")
    result = effects(scaled_design(design, dependent)[0])
    columns = {
        "Source": [effect.name for effect in result],
        "F": [effect.f for effect in result],
        "p_permutation": [permutation_p(effect, rng=rng, n_resamples=n_resamples) for effect in result],
    }
    return pd.DataFrame(columns).assign(n_permutations=n_resamples if design.n > MOST_EXACT else 2 ** (design.n - 1))


@dataclass(frozen=True)
class EffectTest:
    """F of an effect with its epsilons, and Mauchly's W and p.

    If `ss_error` is 0, the effect is the same in all participants and F is undefined.
    """

    name: str
    f: float
    ss_error: float
    df: tuple[float, float]
    epsilons: tuple[float, float, float]
    mauchly: tuple[float, float] = MISSING

    def p(self, epsilon: float = 1.0) -> float:
        """Return the p after both degrees of freedom are multiplied by epsilon."""
        return float(Fisher.sf(self.f, epsilon * self.df[0], epsilon * self.df[1]))


def scaled_design(design: WithinDesign, dependent: str) -> tuple[WithinDesign, float]:
    """Standardise the values for precision; return the scale as well."""
    scale = spread(design.cells, dependent)
    unit = size_of(design.values)
    values: Array = design.values / unit
    values = (values - values.mean()) / (scale / unit)
    return replace(design, values=values, rounding=design.rounding / scale), scale


def _tested(design: WithinDesign, found: Sequence[ContrastEffect]) -> tuple[list[EffectTest], str]:
    """Return F and Mauchly's test of each effect, and the library used."""
    factors = [f"factor_{place}" for place in range(len(design.factors))]
    places = product(*(range(n) for n in design.values.shape))
    long = pd.DataFrame(places, columns=["participant", *factors]).assign(y=design.values.ravel())
    library = "statsmodels" if len(factors) > 2 else "pingouin"
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")  # notes report effects without error and singular matrices
        rows = _by_statsmodels(long, factors, found) if len(factors) > 2 else _by_pingouin(long, factors)

    tested = []
    for effect, (f, *mauchly) in zip(found, rows, strict=True):
        has_mauchly = effect.df[0] > 1 and not effect.is_singular
        shape = epsilons(effect.covariance, len(effect.scores) - 1)
        w_and_p = (mauchly[0], mauchly[1]) if has_mauchly else MISSING
        f_or_none = f if effect.ss_error > 0 else np.nan
        tested.append(EffectTest(effect.name, f_or_none, effect.ss_error, effect.df, shape, w_and_p))
    return tested, library


def _by_pingouin(long: pd.DataFrame, factors: list[str]) -> list[tuple[float, ...]]:
    import pingouin  # slow to load

    table = pingouin.rm_anova(long, dv="y", within=factors, subject="participant", correction=True, detailed=True)
    table = table[table["Source"] != "Error"].reindex(columns=["F", "W_spher", "p_spher"]).astype(float)
    return list(table.itertuples(index=False, name=None))


def _by_statsmodels(long: pd.DataFrame, factors: list[str], found: Sequence[ContrastEffect]) -> list[tuple[float, ...]]:
    import pingouin  # slow to load
    from scipy.linalg import helmert
    from statsmodels.stats.anova import AnovaRM

    f = AnovaRM(long, "y", "participant", within=factors).fit().anova_table["F Value"]
    # Cells as one factor with the same contrasts: pingouin does not test interactions of three factors.
    of_one = [pd.DataFrame(effect.scores @ helmert(effect.df[0] + 1)) for effect in found]
    mauchly = [pingouin.sphericity(table) for table in of_one]
    return [(float(f_value), float(test[1]), float(test[4])) for f_value, test in zip(f, mauchly, strict=True)]


def effect_table(tested: Sequence[EffectTest], residual: float, scale: float, interval: float) -> pd.DataFrame:
    """Return the table of effects, one row each.

    `residual` is the sum of squares of participants plus all errors, `scale` the unit of the values.
    """
    rows = [_effect_row(effect, residual, interval) for effect in tested]
    if len(tested) == 1:  # pingouin has an error row only for designs with one factor
        ss, df = tested[0].ss_error, tested[0].df[1]
        first = {"Source": rows[0]["Source"], "SS": rows[0]["SS"], "DF": tested[0].df[0]}
        rows = [first | rows[0], {"Source": "Error", "SS": ss, "DF": df, "MS": ss / df}]
    result = pd.DataFrame(rows)
    with np.errstate(over="ignore"):  # squares of very large values overflow, but F is correct
        return result.assign(SS=result["SS"] * scale * scale, MS=result["MS"] * scale * scale)


def _effect_row(effect: EffectTest, residual: float, interval: float) -> dict[str, object]:
    first, second = effect.df
    greenhouse_geisser, huynh_feldt, chi_muller = effect.epsilons
    w, mauchly_p = effect.mauchly
    is_spherical: bool | None = None if np.isnan(mauchly_p) else mauchly_p > ALPHA
    if first == 1:  # a single contrast is spherical by definition
        is_spherical, mauchly_p = True, 1.0
    ms = effect.f * effect.ss_error / second
    size = dict.fromkeys(SIZES, np.nan)
    if effect.ss_error > 0:
        df = (first * chi_muller, second * chi_muller)
        size = eta_squared(ms * first, effect.ss_error, residual, df, interval)
    return {
        "Source": effect.name,
        "SS": ms * first,
        "ddof1": first,
        "ddof2": second,
        "MS": ms,
        "F": effect.f,
        "p_unc": effect.p(),
        "p_GG_corr": effect.p(greenhouse_geisser),
        "ng2": np.nan,
        "eps": greenhouse_geisser,
        "sphericity": is_spherical,
        "W_spher": w,
        "p_spher": mauchly_p,
        "eps_HF": huynh_feldt,
        "p_HF_corr": effect.p(huynh_feldt),
        "eps_CM": chi_muller,
        "p_CM_corr": effect.p(chi_muller),
    } | size


def with_notes(
    result: pd.DataFrame,
    design: WithinDesign,
    library: str,
    tested: Sequence[EffectTest],
    singular: Sequence[str] = (),
) -> pd.DataFrame:
    """Add notes, n, status and library to the table's `attrs`."""
    reason = "found the same differences in all participants, so the error is 0 and F is undefined"
    exact = [f"{effect.name}: {reason}" for effect in tested if effect.ss_error == 0]
    status = DesignStatus.SINGULAR if singular else DesignStatus.OK
    notes = [*design.notes, *singular, *exact]
    result.attrs |= {"notes": notes, "n": design.n, "status": status, "library": library}
    return result


def singular_note(effect: ContrastEffect, n: int) -> str:
    """Explain why an effect has no test of sphericity."""
    p = effect.df[0]
    cause = f"its {p} contrasts are linearly dependent in these {n} participants"
    if p > n - 1:
        cause = f"{p} contrasts need at least {p + 1} complete participants, found {n}"
    return (
        f"{effect.name}: the error matrix is singular ({cause}), so Mauchly's test and multivariate tests are "
        "undefined. The corrected F and the permutation test are not affected"
    )


def eta_squared(
    ss: float, ss_error: float, ss_residual: float, df: tuple[float, float], interval: float = INTERVAL
) -> dict[str, float]:
    """Return partial and generalised eta squared with intervals.

    Partial: SS / (SS + SS error). Generalised: SS / (SS + residual), where the residual contains participants and all
    errors (Bakeman 2005). Intervals transform the interval of the noncentrality l of F by l / (l + df1 + df2 + 1)
    (Steiger 2004, Psychol. Methods 9, 164, eq. 21). `df` are the degrees of freedom of the test, corrected if the test
    is corrected.

    >>> result = eta_squared(10.0, 10.0, 40.0, (2.0, 18.0))
    >>> [round(x, 3) for x in result.values()]
    [0.5, 0.159, 0.64, 0.2, 0.045, 0.308]
    """
    f = ss / df[0] / (ss_error / df[1])
    low, high = (x / (x + sum(df) + 1) for x in noncentrality(f, df, interval))
    odds_low, odds_high = (ss_error / ss_residual * partial / (1 - partial) for partial in (low, high))
    partial, generalised = ss / (ss + ss_error), ss / (ss + ss_residual)
    sizes = (partial, low, high, generalised, odds_low / (1 + odds_low), odds_high / (1 + odds_high))
    return dict(zip(SIZES, sizes, strict=True))


def noncentrality(f: float, df: tuple[float, float], interval: float) -> tuple[float, float]:
    """Return the interval of the noncentrality of F."""
    tail = (1 - interval) / 2
    return _noncentrality_at(f, df, 1 - tail), _noncentrality_at(f, df, tail)


def _noncentrality_at(f: float, df: tuple[float, float], probability: float) -> float:
    from scipy.optimize import brentq  # slow to load

    def above(x: float) -> float:
        return float(ncfdtr(*df, x, f)) - probability

    if above(0.0) <= 0:  # F is small even without an effect
        return 0.0
    top = 2 * (f * df[0] + sum(df))  # start above the estimate and double until the root is enclosed
    while above(top) > 0 and top < LARGEST:
        top *= 2
    return float(brentq(above, 0.0, top, xtol=1e-9, rtol=1e-12)) if above(top) < 0 else top


def checks(
    table: pd.DataFrame, anova: pd.DataFrame, *, dependent: str, within: Sequence[str] | str, subject: str
) -> pd.DataFrame:
    """Check the assumptions of an ANOVA: normality, sphericity and outliers.

    - `table`: The values that were analysed.
    - `anova`: The table that `repeated_measures` returned for them, with Mauchly's test.

    Returns
    -------
    DataFrame
        `check`, `statistic`, `p`, `holds` (None if it cannot be tested) and `text`, which describes the result.

    >>> values = [3.0, 4, 6, 2, 5, 6, 4, 4, 7, 1, 3, 6]
    >>> table = pd.DataFrame({"who": list("aaabbbcccddd"), "force_n": [0.5, 1, 2] * 4, "y": values})
    >>> names = {"dependent": "y", "within": "force_n", "subject": "who"}
    >>> print(*checks(table, repeated_measures(table, **names), **names)["text"], sep=chr(10))
    normality of the residuals: Shapiro-Wilk W = .925, p = .327: not contradicted
    sphericity of force_n: Mauchly W = .816, p = .816: not contradicted
    outliers: no residual beyond 3 standard deviations
    """
    import pingouin  # slow to load

    cells = within_design(table, dependent=dependent, within=within, subject=subject, where="checks").cells
    residuals = cells - cells.mean(axis=0) - cells.mean(axis=1, keepdims=True) + cells.mean()
    effect_rows = anova[anova["Source"] != "Error"].to_dict("records")
    w, p = MISSING
    if residuals.size <= MAX_SHAPIRO:
        # Standardised: W does not depend on the unit, but its sums of squares may overflow.
        w, p = pingouin.normality(residuals.ravel() / residuals.std())[["W", "pval"]].astype(float).iloc[0]
    normality = _check("normality of the residuals", "Shapiro-Wilk W", w, p, "too many values")
    n = int(np.sum(np.abs(residuals) > MANY_SD * float(residuals.std())))
    text = f"outliers: {n or 'no'} residual{'s' if n > 1 else ''} beyond {MANY_SD:g} standard deviations"
    outliers = {"check": "outliers", "statistic": float(n), "p": None, "holds": n == 0, "text": text}
    return pd.DataFrame([normality, *map(_sphericity, effect_rows), outliers])


def _sphericity(effect: Mapping[Any, Any]) -> dict[str, object]:
    why_not = "the error matrix is singular" if effect["ddof1"] > 1 else "two levels are always spherical"
    w, p = effect["W_spher"], effect["p_spher"]
    return _check(f"sphericity of {effect['Source']}", "Mauchly W", w, np.nan if np.isnan(w) else p, why_not)


def _check(name: str, statistic: str, value: float, p: float, why_not: str) -> dict[str, object]:
    if np.isnan(p):
        return {"check": name, "statistic": None, "p": None, "holds": None, "text": f"{name}: not tested, {why_not}"}
    text = f"{name}: {statistic} = {share_text(value)}, {p_text(p)}: {'not ' * (p > ALPHA)}contradicted"
    return {"check": name, "statistic": value, "p": p, "holds": bool(p > ALPHA), "text": text}
