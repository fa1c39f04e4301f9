"""Repeated-measures analysis of variance through pingouin, with its traps closed."""

import warnings
from collections.abc import Iterable, Sequence

import numpy as np
import pandas as pd

from tactometry.errors import InvalidParameter, nearest

MAX_FACTORS = 2
MIN_PARTICIPANTS = 3
RELATIVE_ZERO = 1e-10
"""A spread below this part of the values' size is rounding."""


def repeated_measures(
    table: pd.DataFrame, *, dependent: str, within: Sequence[str] | str, subject: str
) -> pd.DataFrame:
    """One- or two-way repeated-measures analysis of variance.

    Parameters
    ----------
    table : DataFrame
        Long form: a row per value. Several values of one participant in one cell are averaged, which the
        result says in `attrs["notes"]`.
    dependent, subject : str
        Columns of the values and of the participants.
    within : str or sequence of str
        One or two columns of conditions, each with two levels at least.

    Returns
    -------
    DataFrame
        Pingouin's columns: per effect sums and degrees of freedom, F, uncorrected and Greenhouse-Geisser p,
        generalised eta squared (`ng2`), epsilon and, where it exists, Mauchly's test. `attrs["notes"]` says
        what a reader must know; `attrs["n"]` is the number of participants.

    Raises
    ------
    InvalidParameter
        For a column that is not there, a value that is not finite (naming the row), a missing cell (naming
        participant and cell), fewer than three participants or two levels, and data without variance to
        compare: a statistic of these would be a number without meaning.

    Notes
    -----
    With fewer participants than contrasts of an effect, its error matrix is singular: Mauchly's test does not
    exist, and the Greenhouse-Geisser correction holds.
    """
    import pingouin

    factors = [within] if isinstance(within, str) else list(within)
    data, notes = _cell_means(_checked(table, dependent, factors, subject), dependent, factors, subject)
    scale = _scale(data, dependent, subject)
    data[dependent] = (data[dependent] - float(data[dependent].mean())) / scale
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = pingouin.rm_anova(
            data,
            dv=dependent,
            within=factors if len(factors) > 1 else factors[0],
            subject=subject,
            correction=True,
            detailed=True,
            effsize="ng2",
        )
    sums = [name for name in ("SS", "MS") if name in found.columns]
    found[sums] = found[sums] * scale**2
    n = data[subject].nunique()
    found.attrs |= {"notes": [*notes, *_singular(found, n)], "n": n}
    result: pd.DataFrame = found
    return result


def _checked(table: pd.DataFrame, dependent: str, factors: Sequence[str], subject: str) -> pd.DataFrame:
    columns = [dependent, subject, *factors]
    for name in columns:
        if name not in table.columns:
            raise InvalidParameter(
                f"repeated_measures: found no column {name!r}{nearest(name, [str(c) for c in table.columns])}"
            )
    if not 1 <= len(factors) <= MAX_FACTORS or len(set(columns)) < len(columns):
        raise InvalidParameter(f"within: found {', '.join(factors)}, expected one or two different factors")
    if table.empty:
        raise InvalidParameter("table: found no row, expected values to compare")
    data = table[columns].reset_index(drop=True).copy()
    values = pd.to_numeric(data[dependent], errors="coerce")
    bad = ~np.isfinite(values.to_numpy(dtype=float))
    if bad.any():
        row = int(np.flatnonzero(bad)[0])
        where = ", ".join(f"{name} = {data[name][row]}" for name in (subject, *factors))
        raise InvalidParameter(
            f"{dependent}, row {row}: found {data[dependent][row]} ({where}), expected a finite number; leave the "
            "participant or the condition out"
        )
    return data.assign(**{dependent: values.astype(float)})


def _cell_means(data: pd.DataFrame, dependent: str, factors: list[str], subject: str) -> tuple[pd.DataFrame, list[str]]:
    """One value per participant and cell; every cell must be there."""
    n = data[subject].nunique()
    if n < MIN_PARTICIPANTS:
        raise InvalidParameter(
            f"{subject}: found {n} participant{'s' if n != 1 else ''}, expected at least {MIN_PARTICIPANTS} to compare"
        )
    for name in factors:
        if data[name].nunique() < 2:
            raise InvalidParameter(f"{name}: found {data[name].nunique()} value, expected at least 2 to compare")
    means = data.groupby([subject, *factors], observed=True)[dependent].agg(["mean", "size"])
    levels = [sorted(data[name].unique()) for name in (subject, *factors)]
    whole = pd.MultiIndex.from_product(levels, names=[subject, *factors])
    missing = [cell for cell in whole if cell not in means.index]
    if missing:
        first = dict(zip(whole.names, missing[0], strict=True))
        raise InvalidParameter(
            f"{dependent}: found no value for {', '.join(f'{k} = {v}' for k, v in first.items())} "
            f"({len(missing)} cells missing), expected one in every cell; leave the participant or the condition "
            "out, or fit a mixed model"
        )
    notes = ["several values of one participant in one cell were averaged"] if (means["size"] > 1).any() else []
    return means["mean"].rename(dependent).reset_index(), notes


def _scale(data: pd.DataFrame, dependent: str, subject: str) -> float:
    """The standard deviation; a refusal where there is nothing to compare."""
    values = data[dependent].to_numpy()
    size = float(np.abs(values).max())
    spread = float(values.std())
    if spread <= RELATIVE_ZERO * size:
        raise InvalidParameter(f"{dependent}: found the same value everywhere, expected values that differ")
    grid = values.reshape(data[subject].nunique(), -1)
    within = grid - grid.mean(axis=1, keepdims=True)
    if np.abs(within).max() <= RELATIVE_ZERO * size:
        raise InvalidParameter(
            f"{dependent}: found no difference between the conditions of any participant, expected some: F is undefined"
        )
    if np.abs(within - within.mean(axis=0)).max() <= RELATIVE_ZERO * size:
        raise InvalidParameter(
            f"{dependent}: found the same differences in all participants, expected some to differ: the error is 0 and "
            "F is undefined"
        )
    return spread


def _singular(found: pd.DataFrame, n_participants: int) -> list[str]:
    effects: Iterable[str] = found["Source"][found["ddof1"] > n_participants - 1] if "ddof1" in found.columns else []
    return [
        f"{effect}: fewer participants ({n_participants}) than its contrasts need, so Mauchly's test does not exist "
        "and the Greenhouse-Geisser correction is used"
        for effect in effects
    ]
