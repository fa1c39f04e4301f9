"""Repeated-measures analysis of variance by pingouin (one or two factors) and statsmodels (three).

Added to their tables: the corrections of Huynh and Feldt and of Chi and Muller, partial eta squared, and intervals of
effect sizes by the noncentral F distribution. `checks` tests what the analysis assumes.
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import pandas as pd
from scipy.special import ncfdtr

from ..arrays import Array, size_of
from ..distributions import Fisher
from ..wording import p_text, share_text
from .contrasts import (
    MOST_EXACT,
    ContrastEffect,
    effects,
    epsilons,
    participant_scores,
    permutation_p as _permutation_p,
)
from .design import DesignStatus, WithinDesign, spread, within_design

INTERVAL = 0.90
"""So wide an interval leaves out 0 exactly where the test is significant at 5 % (Steiger 2004)."""
LARGEST = 1e7
SIZES = ("np2", "np2_low", "np2_high", "ng2", "ng2_low", "ng2_high")
"""Columns of partial and generalised eta squared, each with the ends of its interval."""


def repeated_measures(
    table: pd.DataFrame, *, dependent: str, within: Sequence[str] | str, subject: str, interval: float = INTERVAL
) -> pd.DataFrame:
    """One- to three-way repeated-measures analysis of variance.

    Parameters
    ----------
    table : DataFrame
        Long form: a row per value. Several values of one participant in one cell are averaged, which the
        result says in `attrs["notes"]`.
    dependent, subject : str
        Columns of the values and of the participants.
    within : str or sequence of str
        One to three columns of conditions, each with two levels at least.
    interval : float
        Coverage of the intervals of the effect sizes.

    Returns
    -------
    DataFrame
        Pingouin's columns: per effect sums and degrees of freedom, F, uncorrected and Greenhouse-Geisser p,
        generalised eta squared (`ng2`), epsilon (`eps`) and, where it exists, Mauchly's test. Added are Huynh and
        Feldt's and Chi and Muller's epsilon and p (`eps_HF`, `p_HF_corr`, `eps_CM`, `p_CM_corr`), partial eta squared
        (`np2`), and the ends of the intervals (`np2_low`, `np2_high`, `ng2_low`, `ng2_high`; of Chi and Muller's test,
        which is the one to report). `attrs["notes"]` says what a reader must know; `attrs["n"]` is the number of
        participants, `attrs["status"]` the `DesignStatus`.

    Raises
    ------
    InvalidParameter
        For a column that is not there. As `UndefinedStatistic`, with its `status`: for a value that is not finite
        (naming the row), a missing cell (naming participant and cell), fewer than three participants or two levels,
        and data without variance to compare: a statistic of these would be a number without meaning.

    Notes
    -----
    Chi and Muller's correction holds 5 % of false alarms best, from few participants and where the contrasts are not
    spherical (docs/reference/analysis.md has the table). With fewer participants than an effect has contrasts, its
    error matrix is singular: Mauchly's test does not exist; the corrections hold. `permutation_test` needs none. An
    effect that is exactly the same in all participants has no error: its F is missing, and a note says so.

    >>> values = [3.0, 4, 6, 2, 5, 6, 4, 4, 7, 1, 3, 5]
    >>> table = pd.DataFrame({"who": list("aaabbbcccddd"), "force_n": [0.5, 1, 2] * 4, "y": values})
    >>> found = repeated_measures(table, dependent="y", within="force_n", subject="who")
    >>> found[["F", "p_unc", "np2"]].iloc[0].round(4).tolist()
    [27.75, 0.0009, 0.9024]
    """
    design = within_design(table, dependent=dependent, within=within, subject=subject, where="repeated_measures")
    scaled, scale = scaled_design(design, dependent)
    found = effects(scaled)
    tested = _tested(scaled, found)
    between = participant_scores(scaled)
    residual = float(np.sum((between - between.mean()) ** 2)) + sum(effect.ss_error for effect in found)
    singular = [singular_note(effect, design.n) for effect in found if effect.ss_error > 0 and effect.is_singular]
    table = with_notes(effect_table(tested, residual, scale, interval), design, tested, singular)
    table.attrs["library"] = "statsmodels" if len(design.factors) > 2 else "pingouin"
    return table


def permutation_test(
    table: pd.DataFrame,
    *,
    dependent: str,
    within: Sequence[str] | str,
    subject: str,
    rng: np.random.Generator | None = None,
    n_resamples: int = 9_999,
) -> pd.DataFrame:
    """For each effect the chance of an F as large if every participant's contrasts might have had the other sign.

    It asks for symmetric errors only, not for sphericity, nor for more participants than contrasts. Up to 14
    participants it is exact and draws nothing; beyond, `rng` draws `n_resamples` changes of signs.

    Raises
    ------
    InvalidParameter
        As `repeated_measures`; and if `rng` is needed and not given.

    >>> table = pd.DataFrame({"who": list("aabbccdd"), "force_n": [0.5, 1] * 4, "y": [1.0, 2, 2, 4, 3, 6, 2, 6]})
    >>> permutation_test(table, dependent="y", within="force_n", subject="who")["p_permutation"].tolist()
    [0.125]
    """
    design = within_design(table, dependent=dependent, within=within, subject=subject, where="repeated_measures")
    scaled, _ = scaled_design(design, dependent)
    found = effects(scaled)
    columns = {
        "Source": [effect.name for effect in found],
        "F": [effect.f for effect in _tested(scaled, found)],
        "p_permutation": [_permutation_p(effect, rng=rng, n_resamples=n_resamples) for effect in found],
    }
    return pd.DataFrame(columns).assign(n_permutations=n_resamples if design.n > MOST_EXACT else 2 ** (design.n - 1))


@dataclass(frozen=True)
class EffectTest:
    """An effect with its F: `ss_error` is its error's sum of squares, `epsilons` are those of Greenhouse and Geisser,
    Huynh and Feldt, and Chi and Muller, `mauchly` is W with its p, missing where the test does not exist."""

    name: str
    f: float
    ss_error: float
    df: tuple[float, float]
    epsilons: tuple[float, float, float]
    mauchly: tuple[float, float] = (np.nan, np.nan)

    @property
    def has_error(self) -> bool:
        """Without, all participants show exactly the same differences and F is undefined."""
        return self.ss_error > 0

    def p(self, epsilon: float = 1.0) -> float:
        """Chance of such an F or a larger one; both degrees of freedom are multiplied by epsilon."""
        return float(Fisher.sf(self.f, epsilon * self.df[0], epsilon * self.df[1]))


def scaled_design(design: WithinDesign, dependent: str) -> tuple[WithinDesign, float]:
    """About zero and of unit spread, so that neither offset nor unit costs digits."""
    scale = spread(design.cells, dependent)
    unit = size_of(design.values)
    values: Array = design.values / unit
    values = (values - values.mean()) / (scale / unit)
    return replace(design, values=values, rounding=design.rounding / scale), scale


def _tested(design: WithinDesign, found: Sequence[ContrastEffect]) -> list[EffectTest]:
    """Return F and Mauchly's test of each effect, from pingouin, or from statsmodels for three factors."""
    factors = [f"factor_{place}" for place in range(len(design.factors))]
    places = product(*(range(n) for n in design.values.shape))
    long = pd.DataFrame(places, columns=["participant", *factors]).assign(y=design.values.ravel())
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")  # of effects without error and of singular matrices, which are told below
        fs, mauchly = _by_statsmodels(long, factors, found) if len(factors) > 2 else _by_pingouin(long, factors)
    tested = []
    for effect, f, w_and_p in zip(found, fs, mauchly, strict=True):
        has_error, has_test = effect.ss_error > 0, effect.df[0] > 1 and not effect.is_singular
        shape = epsilons(effect.covariance, len(effect.scores) - 1)
        known = w_and_p if has_test else (np.nan, np.nan)
        tested.append(EffectTest(effect.name, f if has_error else np.nan, effect.ss_error, effect.df, shape, known))
    return tested


def _by_pingouin(long: pd.DataFrame, factors: list[str]) -> tuple[list[float], list[tuple[float, float]]]:
    import pingouin  # slow to load

    table = pingouin.rm_anova(long, dv="y", within=factors, subject="participant", correction=True, detailed=True)
    table = table[table["Source"] != "Error"].reindex(columns=["F", "W_spher", "p_spher"]).astype(float)
    return table["F"].tolist(), list(table[["W_spher", "p_spher"]].itertuples(index=False, name=None))


def _by_statsmodels(
    long: pd.DataFrame, factors: list[str], found: Sequence[ContrastEffect]
) -> tuple[list[float], list[tuple[float, float]]]:
    import pingouin  # slow to load
    from scipy.linalg import helmert
    from statsmodels.stats.anova import AnovaRM

    table = AnovaRM(long, "y", "participant", within=factors).fit().anova_table
    mauchly = []
    for effect in found:
        # One factor with the same contrasts: pingouin tests no interaction of three factors.
        _, w, _, _, p = pingouin.sphericity(pd.DataFrame(effect.scores @ helmert(effect.df[0] + 1)))
        mauchly.append((float(w), float(p)))
    return table["F Value"].tolist(), mauchly


def effect_table(tested: Sequence[EffectTest], residual: float, scale: float, interval: float) -> pd.DataFrame:
    """Return a row for each effect, in pingouin's columns and those added.

    `residual` are the sums of squares of participants and all errors, `scale` the unit of the values.
    """
    rows = [_effect_row(effect, residual, interval) for effect in tested]
    if len(tested) == 1:  # pingouin gives a row of the error for one factor alone
        ss, df = tested[0].ss_error, tested[0].df[1]
        first = {"Source": rows[0]["Source"], "SS": rows[0]["SS"], "DF": tested[0].df[0]}
        rows = [first | rows[0], {"Source": "Error", "SS": ss, "DF": df, "MS": ss / df}]
    result = pd.DataFrame(rows)
    with np.errstate(over="ignore"):  # squares of values near the largest float: infinite, and F is right
        return result.assign(SS=result["SS"] * scale * scale, MS=result["MS"] * scale * scale)


def _effect_row(effect: EffectTest, residual: float, interval: float) -> dict[str, object]:
    """Return pingouin's columns of one effect, then further corrections and effect sizes with intervals."""
    first, second = effect.df
    greenhouse_geisser, huynh_feldt, chi_muller = effect.epsilons
    w, mauchly_p = effect.mauchly
    is_spherical: bool | None = None if np.isnan(mauchly_p) else mauchly_p > ALPHA
    if first == 1:  # one contrast has nothing to be unequal to
        is_spherical, mauchly_p = True, 1.0
    ms = effect.f * effect.ss_error / second
    size = dict.fromkeys(SIZES, np.nan)
    if effect.has_error:
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
    result: pd.DataFrame, design: WithinDesign, tested: Sequence[EffectTest], singular: Sequence[str] = ()
) -> pd.DataFrame:
    """Return the table with notes, number of participants and status in its `attrs`."""
    exact = [
        f"{effect.name}: found the same differences in all participants: the error is 0 and F is undefined"
        for effect in tested
        if not effect.has_error
    ]
    status = DesignStatus.SINGULAR if singular else DesignStatus.OK
    result.attrs |= {"notes": [*design.notes, *singular, *exact], "n": design.n, "status": status}
    return result


def singular_note(effect: ContrastEffect, n: int) -> str:
    """Why an effect has no test of sphericity, and what is done."""
    p = effect.df[0]
    cause = (
        f"{p} contrasts need at least {p + 1} complete participants, found {n}"
        if p > n - 1
        else f"its {p} contrasts are exactly dependent in these {n} participants"
    )
    return (
        f"{effect.name}: the error matrix is singular ({cause}), so Mauchly's test and multivariate tests do not "
        "exist; the corrected F and the permutation test are not affected"
    )


def eta_squared(
    ss: float, ss_error: float, ss_residual: float, df: tuple[float, float], interval: float = INTERVAL
) -> dict[str, float]:
    """The `SIZES`: partial eta squared SS / (SS + SS error) and generalised SS / (SS + residual) (Bakeman 2005).

    `ss_residual` is what the generalised one divides by besides the effect: participants and all errors. `df` are
    the degrees of freedom, corrected if the test is. The interval is that of the noncentrality l of F, as
    l / (l + n) with n = df1 + df2 + 1 (Steiger 2004, Psychol. Methods 9, 164, eq. 21); the generalised one takes the
    sums of squares of participants and errors as they were found.

    >>> found = eta_squared(10.0, 10.0, 40.0, (2.0, 18.0))
    >>> [round(x, 3) for x in found.values()]
    [0.5, 0.159, 0.64, 0.2, 0.045, 0.308]
    """
    f = ss / df[0] / (ss_error / df[1])
    low, high = (x / (x + sum(df) + 1) for x in noncentrality(f, df, interval))
    share = ss_error / ss_residual
    partial, generalised = ss / (ss + ss_error), ss / (ss + ss_residual)
    sizes = (partial, low, high, generalised, _generalised(low, share), _generalised(high, share))
    return dict(zip(SIZES, sizes, strict=True))


def _generalised(partial: float, share: float) -> float:
    """The generalised eta squared that belongs to a partial one; `share`: of the error in the residual."""
    odds = share * partial / (1 - partial)
    return odds / (1 + odds)


def noncentrality(f: float, df: tuple[float, float], interval: float) -> tuple[float, float]:
    """The noncentralities under which so large or so small an F has the chance (1 - interval) / 2."""
    tail = (1 - interval) / 2
    return _under(f, df, 1 - tail), _under(f, df, tail)


def _under(f: float, df: tuple[float, float], chance: float) -> float:
    from scipy.optimize import brentq  # slow to load

    def above(x: float) -> float:
        return float(ncfdtr(*df, x, f)) - chance

    if above(0.0) <= 0:  # so small an F is likelier than that without any effect
        return 0.0
    top = 2 * (f * df[0] + sum(df))  # beyond what F estimates; doubled until it encloses the root
    while above(top) > 0 and top < LARGEST:
        top *= 2
    return float(brentq(above, 0.0, top, xtol=1e-9, rtol=1e-12)) if above(top) < 0 else top


ALPHA = 0.05

MANY_SD = 3.0

MAX_SHAPIRO = 5000
"""Beyond, Shapiro and Wilk's p is not known to hold."""


def checks(table: pd.DataFrame, *, dependent: str, within: Sequence[str] | str, subject: str) -> pd.DataFrame:
    """Normality of the residuals (Shapiro and Wilk), sphericity of each effect (Mauchly), and outliers.

    Returns
    -------
    DataFrame
        `check, statistic, p, holds` (None: cannot be tested) and `text`, a sentence.

    Raises
    ------
    InvalidParameter
        As `repeated_measures`.

    >>> values = [3.0, 4, 6, 2, 5, 6, 4, 4, 7, 1, 3, 6]
    >>> table = pd.DataFrame({"who": list("aaabbbcccddd"), "force_n": [0.5, 1, 2] * 4, "y": values})
    >>> print(*checks(table, dependent="y", within="force_n", subject="who")["text"], sep=chr(10))
    normality of the residuals: Shapiro-Wilk W = .925, p = .327: not contradicted
    sphericity of force_n: Mauchly W = .816, p = .816: not contradicted
    outliers: no residual beyond 3 standard deviations
    """
    design = within_design(table, dependent=dependent, within=within, subject=subject, where="checks")
    spread(design.cells, dependent)
    residuals = _residuals(design.cells)
    effect_tests = _tested(scaled_design(design, dependent)[0], effects(design))
    rows = [_normality(residuals), *map(_sphericity, effect_tests), _outliers(residuals)]
    return pd.DataFrame(rows)


def _residuals(cells: Array) -> Array:
    """What participant and condition do not explain, shape (participant, cell)."""
    residuals: Array = cells - cells.mean(axis=0) - cells.mean(axis=1, keepdims=True) + cells.mean()
    return residuals


def _normality(residuals: Array) -> dict[str, object]:
    import pingouin  # slow to load

    w, p = np.nan, np.nan
    if residuals.size <= MAX_SHAPIRO:
        # W has no unit, its sums of squares have.
        w, p = pingouin.normality(residuals.ravel() / residuals.std())[["W", "pval"]].astype(float).iloc[0]
    return _check("normality of the residuals", "Shapiro-Wilk W", w, p, "too many values")


def _sphericity(effect: EffectTest) -> dict[str, object]:
    why_not = "the error matrix is singular" if effect.df[0] > 1 else "two levels are always spherical"
    return _check(f"sphericity of {effect.name}", "Mauchly W", *effect.mauchly, why_not)


def _outliers(residuals: Array) -> dict[str, object]:
    sd = float(residuals.std())
    n = int(np.sum(np.abs(residuals) > MANY_SD * sd))
    text = f"outliers: {n or 'no'} residual{'s' if n > 1 else ''} beyond {MANY_SD:g} standard deviations"
    return {"check": "outliers", "statistic": float(n), "p": None, "holds": n == 0, "text": text}


def _check(name: str, statistic: str, value: float, p: float, why_not: str) -> dict[str, object]:
    """Return the verdict of a test, or why there is none where it has no value."""
    if np.isnan(p):
        return {"check": name, "statistic": None, "p": None, "holds": None, "text": f"{name}: not tested, {why_not}"}
    text = f"{name}: {statistic} = {share_text(value)}, {p_text(p)}: {'not ' * (p > ALPHA)}contradicted"
    return {"check": name, "statistic": value, "p": p, "holds": bool(p > ALPHA), "text": text}
