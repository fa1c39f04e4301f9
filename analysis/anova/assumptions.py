"""What an analysis of variance assumes, checked on its own data and printed with its result."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy.stats import shapiro

from ..arrays import Array
from ..wording import p_text, share_text
from .contrasts import ContrastEffect, effects
from .design import spread, within_design

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
    name = "normality of the residuals"
    if residuals.size > MAX_SHAPIRO:
        return _untested(name, "too many values")
    w, p = shapiro(residuals.ravel() / residuals.std())  # W has no unit, its sums of squares have
    return _tested(name, "Shapiro-Wilk W", float(w), float(p))


def _sphericity(effect: ContrastEffect) -> dict[str, object]:
    name = f"sphericity of {effect.name}"
    shape = effect.sphericity
    if shape.w is None or shape.p is None:
        return _untested(name, "the error matrix is singular" if shape.singular else "two levels are always spherical")
    return _tested(name, "Mauchly W", shape.w, shape.p)


def _outliers(residuals: Array) -> dict[str, object]:
    sd = float(residuals.std())
    n = int(np.sum(np.abs(residuals) > MANY_SD * sd))
    text = f"outliers: {n or 'no'} residual{'s' if n > 1 else ''} beyond {MANY_SD:g} standard deviations"
    return {"check": "outliers", "statistic": float(n), "p": None, "holds": n == 0, "text": text}


def _tested(name: str, statistic: str, value: float, p: float) -> dict[str, object]:
    verdict = "not contradicted" if p > ALPHA else "contradicted"
    text = f"{name}: {statistic} = {share_text(value)}, {p_text(p)}: {verdict}"
    return {"check": name, "statistic": value, "p": p, "holds": p > ALPHA, "text": text}


def _untested(name: str, why: str) -> dict[str, object]:
    return {"check": name, "statistic": None, "p": None, "holds": None, "text": f"{name}: not tested, {why}"}
