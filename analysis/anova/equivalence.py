"""Equivalence: two one-sided tests (Schuirmann 1987) against a bound that is stated before the data are seen.

That a test finds no difference does not show that there is none; this does, up to the bound.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from scipy.stats import t as student

from tactometry.errors import InvalidParameter

from .post_hoc import Pair, compare, has_error


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
    if not (np.isfinite(bound) and bound > 0):
        raise InvalidParameter(f"bound: found {bound}, expected a difference above 0, in the unit of {dependent}")
    if not 0 < alpha < 0.5:
        raise InvalidParameter(f"alpha: found {alpha}, expected a chance between 0 and 0.5")
    compared, notes = compare(table, dependent, factor, subject, by, "equivalence")
    result = told_equivalent([_row(pair, by, bound, alpha) for pair in compared], bound, alpha)
    result.attrs["notes"] = notes
    return result


def told_equivalent(rows: Sequence[Mapping[str, object]], bound: float, alpha: float) -> pd.DataFrame:
    """A table of pairs with the verdict on each, and that on all of them in `attrs`."""
    result = pd.DataFrame(rows)
    result["equivalent"] = result["p"] < alpha
    result.attrs |= {"p_all": float(result["p"].max()), "bound": bound, "alpha": alpha}
    return result


def _row(pair: Pair, by: str | None, bound: float, alpha: float) -> dict[str, object]:
    d = pair.differences
    start: dict[str, object] = {} if by is None else {by: pair.by}
    start |= {"a": pair.names[0], "b": pair.names[1], "difference": float(d.mean()) * pair.size}
    error = float(d.std(ddof=1)) / np.sqrt(len(d)) if has_error(pair) else 0.0
    tested = two_one_sided(float(d.mean()), error, len(d) - 1, bound / pair.size, alpha)
    tested |= {name: tested[name] * pair.size for name in ("low", "high")}
    return start | tested | {"bound": bound, "n": len(d)}


def two_one_sided(difference: float, error: float, df: float, bound: float, alpha: float) -> dict[str, float]:
    """The tests of a difference with a standard error; without one it is what it is."""
    if error == 0:
        p = float(abs(difference) >= bound)
        return {"low": difference, "high": difference, "t_low": np.inf, "t_high": -np.inf, "p": p}
    t_low, t_high = (difference + bound) / error, (difference - bound) / error
    half = float(student.isf(alpha, df)) * error
    p = max(float(student.sf(t_low, df)), float(student.cdf(t_high, df)))
    return {"low": difference - half, "high": difference + half, "t_low": t_low, "t_high": t_high, "p": p}
