"""Repeated-measures analysis of variance of one to three factors, by exact contrasts, in pingouin's columns.

Sizes of effects of an analysis of variance, with intervals from the noncentral F distribution.

What an analysis of variance assumes, checked on its own data and printed with its result.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
from scipy.special import ncfdtr

from ..arrays import Array, size_of
from ..wording import p_text, share_text
from .contrasts import MOST_EXACT, ContrastEffect, Tested, effects, participant_scores, permutation_p as _permutation_p
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
    tested = effects(scaled)
    between = participant_scores(scaled)
    of_participants = float(np.sum((between - between.mean()) ** 2))
    residual = of_participants + sum(effect.ss_error for effect in tested)
    return with_notes(effect_table(tested, residual, scale, interval), design, tested)


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
    tested = effects(scaled_design(design, dependent)[0])
    columns = {
        "Source": [effect.name for effect in tested],
        "F": [effect.f for effect in tested],
        "p_permutation": [_permutation_p(effect, rng=rng, n_resamples=n_resamples) for effect in tested],
    }
    return pd.DataFrame(columns).assign(n_permutations=n_resamples if design.n > MOST_EXACT else 2 ** (design.n - 1))


def scaled_design(design: WithinDesign, dependent: str) -> tuple[WithinDesign, float]:
    """About zero and of unit spread, so that neither offset nor unit costs digits."""
    scale = spread(design.cells, dependent)
    unit = size_of(design.values)
    values: Array = design.values / unit
    values = (values - values.mean()) / (scale / unit)
    return replace(design, values=values, rounding=design.rounding / scale), scale


def effect_table(tested: Sequence[Tested], residual: float, scale: float, interval: float) -> pd.DataFrame:
    """A row for each effect, in pingouin's columns and those added; `residual` are the sums of squares of participants
    and all errors, `scale` the unit of the values."""
    rows = [_effect_row(effect, residual, interval) for effect in tested]
    result = pd.DataFrame(_with_error(rows[0], tested[0]) if len(tested) == 1 else rows)
    with np.errstate(over="ignore"):  # squares of values near the largest float: infinite, and F is right
        return result.assign(SS=result["SS"] * scale * scale, MS=result["MS"] * scale * scale)


def _with_error(row: dict[str, object], effect: Tested) -> list[dict[str, object]]:
    """And a row of the error, which pingouin gives for one factor alone."""
    df = effect.df[1]
    first = {"Source": effect.name, "SS": effect.ss, "DF": effect.df[0]}
    return [first | row, {"Source": "Error", "SS": effect.ss_error, "DF": df, "MS": effect.ss_error / df}]


def _effect_row(effect: Tested, residual: float, interval: float) -> dict[str, object]:
    """Pingouin's columns of one effect, and behind them what it does not give: two more corrections, sizes of the
    effect with intervals."""
    first, second = effect.df
    shape = effect.sphericity
    is_spherical: bool | None = True  # one contrast has nothing to be unequal to
    mauchly_p = 1.0
    if first > 1:
        is_spherical = None if shape.p is None else shape.p > 0.05
        mauchly_p = np.nan if shape.p is None else shape.p
    size = dict.fromkeys(SIZES, np.nan)
    if effect.has_error:
        df = (first * shape.chi_muller, second * shape.chi_muller)
        size = eta_squared(effect.ss, effect.ss_error, residual, df, interval)
    return {
        "Source": effect.name,
        "SS": effect.ss,
        "ddof1": first,
        "ddof2": second,
        "MS": effect.ss / first,
        "F": effect.f,
        "p_unc": effect.p(),
        "p_GG_corr": effect.p(shape.greenhouse_geisser),
        "ng2": np.nan,
        "eps": shape.greenhouse_geisser,
        "sphericity": is_spherical,
        "W_spher": np.nan if shape.w is None else shape.w,
        "p_spher": mauchly_p,
        "eps_HF": shape.huynh_feldt,
        "p_HF_corr": effect.p(shape.huynh_feldt),
        "eps_CM": shape.chi_muller,
        "p_CM_corr": effect.p(shape.chi_muller),
    } | size


def with_notes(result: pd.DataFrame, design: WithinDesign, tested: Sequence[Tested]) -> pd.DataFrame:
    """The table with notes, number of participants and status in its `attrs`."""
    with_error = [effect for effect in tested if effect.has_error]
    singular = [singular_note(effect, design.n) for effect in with_error if effect.sphericity.singular]
    exact = [
        f"{effect.name}: found the same differences in all participants: the error is 0 and F is undefined"
        for effect in tested
        if not effect.has_error
    ]
    status = DesignStatus.SINGULAR if singular else DesignStatus.OK
    result.attrs |= {"notes": [*design.notes, *singular, *exact], "n": design.n, "status": status}
    return result


def singular_note(effect: Tested, n: int) -> str:
    """Why an effect has no test of sphericity, and what is done."""
    p = effect.df[0]
    df = effect.df[1] // p
    cause = (
        f"{p} contrasts need at least {p + n - df} complete participants, found {n}"
        if p > df
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

    >>> values = [3.0, 4, 6, 2, 5, 6, 4, 4, 7, 1, 3, 5]
    >>> table = pd.DataFrame({"who": list("aaabbbcccddd"), "force_n": [0.5, 1, 2] * 4, "y": values})
    >>> print(*checks(table, dependent="y", within="force_n", subject="who")["text"], sep=chr(10))
    normality of the residuals: Shapiro-Wilk W = .967, p = .881: not contradicted
    sphericity of force_n: Mauchly W = .187, p = .187: not contradicted
    outliers: no residual beyond 3 standard deviations
    """
    design = within_design(table, dependent=dependent, within=within, subject=subject, where="checks")
    spread(design.cells, dependent)
    residuals = _residuals(design.cells)
    rows = [_normality(residuals), *(_sphericity(effect) for effect in effects(design)), _outliers(residuals)]
    return pd.DataFrame(rows)


def _residuals(cells: Array) -> Array:
    """What participant and condition do not explain, shape (participant, cell)."""
    residuals: Array = cells - cells.mean(axis=0) - cells.mean(axis=1, keepdims=True) + cells.mean()
    return residuals


def _normality(residuals: Array) -> dict[str, object]:
    from scipy.stats import shapiro  # slow to load

    w, p = None, None
    if residuals.size <= MAX_SHAPIRO:
        w, p = map(float, shapiro(residuals.ravel() / residuals.std()))  # W has no unit, its sums of squares have
    return _check("normality of the residuals", "Shapiro-Wilk W", w, p, "too many values")


def _sphericity(effect: ContrastEffect) -> dict[str, object]:
    shape = effect.sphericity
    why_not = "the error matrix is singular" if shape.singular else "two levels are always spherical"
    return _check(f"sphericity of {effect.name}", "Mauchly W", shape.w, shape.p, why_not)


def _outliers(residuals: Array) -> dict[str, object]:
    sd = float(residuals.std())
    n = int(np.sum(np.abs(residuals) > MANY_SD * sd))
    text = f"outliers: {n or 'no'} residual{'s' if n > 1 else ''} beyond {MANY_SD:g} standard deviations"
    return {"check": "outliers", "statistic": float(n), "p": None, "holds": n == 0, "text": text}


def _check(name: str, statistic: str, value: float | None, p: float | None, why_not: str) -> dict[str, object]:
    """The verdict of a test; why there is none where it has no value."""
    holds, text = None, f"not tested, {why_not}"
    if value is not None and p is not None:
        holds = p > ALPHA
        text = f"{statistic} = {share_text(value)}, {p_text(p)}: {'not ' * holds}contradicted"
    return {"check": name, "statistic": value, "p": p, "holds": holds, "text": f"{name}: {text}"}
