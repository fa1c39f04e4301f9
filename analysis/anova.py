"""Repeated-measures analysis of variance through pingouin, with its traps closed; a third factor by exact contrasts."""

import warnings
from collections.abc import Sequence

import numpy as np
import pandas as pd

from tactometry.analysis.contrasts import MOST_EXACT, Effect, Tested, effects, participant_scores
from tactometry.analysis.contrasts import permutation_p as _permutation_p
from tactometry.analysis.design import Array, Design, DesignStatus, spread, within_design
from tactometry.analysis.effect_size import INTERVAL, eta_squared

MAX_FACTORS = 3
PINGOUIN_FACTORS = 2


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
        Feldt's epsilon and p (`eps_HF`, `p_HF_corr`), partial eta squared (`np2`), and the ends of the intervals
        (`np2_low`, `np2_high`, `ng2_low`, `ng2_high`; of the corrected test). `attrs["notes"]` says what a reader
        must know; `attrs["n"]` is the number of participants, `attrs["status"]` the `DesignStatus`.

    Raises
    ------
    InvalidParameter
        For a column that is not there. As `UndefinedStatistic`, with its `status`: for a value that is not finite
        (naming the row), a missing cell (naming participant and cell), fewer than three participants or two levels,
        and data without variance to compare: a statistic of these would be a number without meaning.

    Notes
    -----
    With fewer participants than an effect has contrasts, its error matrix is singular: Mauchly's test does not exist,
    and the Greenhouse-Geisser correction holds. `permutation_test` needs neither.

    >>> values = [3.0, 4, 6, 2, 5, 6, 4, 4, 7, 1, 3, 5]
    >>> table = pd.DataFrame({"who": list("aaabbbcccddd"), "force_n": [0.5, 1, 2] * 4, "y": values})
    >>> found = repeated_measures(table, dependent="y", within="force_n", subject="who")
    >>> found[["F", "p_unc", "np2"]].iloc[0].round(4).tolist()
    [27.75, 0.0009, 0.9024]
    """
    design = _design(table, dependent, within, subject)
    scaled, scale = scaled_design(design, dependent)
    found = effects(scaled)
    result = _by_contrasts(found) if len(design.factors) > PINGOUIN_FACTORS else _by_pingouin(scaled)
    residual = _residual(scaled, found)
    added = pd.DataFrame([added_columns(effect.tested, residual, interval) for effect in found])
    ng2 = added.pop("ng2")
    if len(design.factors) > PINGOUIN_FACTORS:
        result["ng2"] = ng2
    result = pd.concat([result, added], axis=1)
    for name in ("SS", "MS"):
        result[name] *= scale**2
    return told(_without_singular(result, found), design, [effect.tested for effect in found])


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
    design = _design(table, dependent, within, subject)
    found = effects(scaled_design(design, dependent)[0])
    return pd.DataFrame(
        [
            {
                "Source": effect.name,
                "F": effect.f,
                "p_permutation": _permutation_p(effect, rng=rng, n_resamples=n_resamples),
                "n_permutations": n_resamples if design.n > MOST_EXACT else 2 ** (design.n - 1),
            }
            for effect in found
        ]
    )


def _design(table: pd.DataFrame, dependent: str, within: Sequence[str] | str, subject: str) -> Design:
    factors = [within] if isinstance(within, str) else list(within)
    return within_design(table, dependent=dependent, within=factors, subject=subject, where="repeated_measures")


def scaled_design(design: Design, dependent: str) -> tuple[Design, float]:
    """About zero and of unit spread, so that neither offset nor unit costs digits."""
    scale = spread(design.cells, dependent)
    values: Array = (design.values - design.values.mean()) / scale
    return Design(values, design.factors, design.levels, design.participants, design.notes), scale


def _by_pingouin(design: Design) -> pd.DataFrame:
    import pingouin

    places = np.indices(design.values.shape).reshape(len(design.factors) + 1, -1)
    names = ["participant, by number", *design.factors]
    data = pd.DataFrame(dict(zip(names, places, strict=True))).assign(**{"value, scaled": design.values.ravel()})
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        found: pd.DataFrame = pingouin.rm_anova(
            data,
            dv="value, scaled",
            within=list(design.factors) if len(design.factors) > 1 else design.factors[0],
            subject=names[0],
            correction=True,
            detailed=True,
            effsize="ng2",
        )
    return found


def _by_contrasts(found: Sequence[Effect]) -> pd.DataFrame:
    return pd.DataFrame([effect_row(effect.tested) for effect in found])


def effect_row(effect: Tested) -> dict[str, object]:
    """Pingouin's columns of one effect."""
    first, second = effect.df
    shape = effect.sphericity
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
        "sphericity": None if shape.p is None else shape.p > 0.05,
        "W_spher": shape.w,
        "p_spher": shape.p,
    }


def _residual(design: Design, found: Sequence[Effect]) -> float:
    """Sums of squares of participants and of all errors."""
    between = participant_scores(design)
    return float(np.sum((between - between.mean()) ** 2)) + sum(each.ss_error for each in found)


def added_columns(effect: Tested, residual: float, interval: float) -> dict[str, float]:
    """What pingouin does not give: Huynh and Feldt's correction, sizes of the effect with intervals."""
    shape = effect.sphericity
    df = (effect.df[0] * shape.greenhouse_geisser, effect.df[1] * shape.greenhouse_geisser)
    size = eta_squared(effect.ss, effect.ss_error, residual, df, interval)
    return {
        "eps_HF": shape.huynh_feldt,
        "p_HF_corr": effect.p(shape.huynh_feldt),
        "np2": size.partial,
        "np2_low": size.partial_low,
        "np2_high": size.partial_high,
        "ng2": size.generalised,
        "ng2_low": size.generalised_low,
        "ng2_high": size.generalised_high,
    }


def _without_singular(result: pd.DataFrame, found: Sequence[Effect]) -> pd.DataFrame:
    """No test of sphericity where there is none: pingouin writes W = 0 and p = 0."""
    singular = [place for place, effect in enumerate(found) if effect.sphericity.singular]
    for name in ("W_spher", "p_spher", "sphericity"):
        if name in result.columns and singular:
            result[name] = result[name].astype(object if name == "sphericity" else np.float64)
            result.loc[singular, name] = None
    return result


def told(result: pd.DataFrame, design: Design, found: Sequence[Tested]) -> pd.DataFrame:
    """The table with notes, number of participants and status in its `attrs`."""
    singular = [singular_note(effect, design.n) for effect in found if effect.sphericity.singular]
    status = DesignStatus.SINGULAR if singular else DesignStatus.OK
    result.attrs |= {"notes": [*design.notes, *singular], "n": design.n, "status": status}
    return result


def singular_note(effect: Tested, n: int) -> str:
    """Why an effect has no test of sphericity, and what is done."""
    p = effect.df[0]
    df = effect.df[1] // p
    cause = (
        f"{p} contrasts need more than {n} participants"
        if p > df
        else f"its {p} contrasts are exactly dependent in these {n} participants"
    )
    return (
        f"{effect.name}: the error matrix is singular ({cause}), so Mauchly's test does not exist and no multivariate "
        "test either; the Greenhouse-Geisser correction is used, and a permutation test or a mixed model would not "
        "need it"
    )
