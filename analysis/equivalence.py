"""Equivalence: two one-sided tests (Schuirmann 1987) against a bound that is stated before the data are seen.

That a test finds no difference does not show that there is none; this does, up to the bound.
"""

import numpy as np
import pandas as pd

from tactometry.analysis.post_hoc import Pair, compare, has_error
from tactometry.errors import InvalidParameter


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
    result = pd.DataFrame([_row(pair, by, bound, alpha) for pair in compared])
    result.attrs |= {"p_all": float(result["p"].max()), "bound": bound, "alpha": alpha, "notes": notes}
    return result


def _row(pair: Pair, by: str | None, bound: float, alpha: float) -> dict[str, object]:
    start: dict[str, object] = {} if by is None else {by: pair.by}
    start |= {"a": pair.names[0], "b": pair.names[1], "difference": float(pair.differences.mean()) * pair.size}
    tested = (_tests if has_error(pair) else _certain)(pair, bound / pair.size, alpha)
    tested |= {name: tested[name] * pair.size for name in ("low", "high")}
    return start | tested | {"bound": bound, "n": len(pair.differences), "equivalent": bool(tested["p"] < alpha)}


def _tests(pair: Pair, bound: float, alpha: float) -> dict[str, float]:
    from statsmodels.stats.weightstats import DescrStatsW, ttost_paired

    p, (t_low, _, _), (t_high, _, _) = ttost_paired(pair.values[1], pair.values[0], -bound, bound)
    low, high = DescrStatsW(pair.differences).tconfint_mean(2 * alpha)
    return {"low": float(low), "high": float(high), "t_low": float(t_low), "t_high": float(t_high), "p": float(p)}


def _certain(pair: Pair, bound: float, alpha: float) -> dict[str, float]:
    """All participants differ alike: there is no error to test with, and the difference is what it is."""
    del alpha
    mean = float(pair.differences.mean())
    return {"low": mean, "high": mean, "t_low": np.inf, "t_high": -np.inf, "p": float(abs(mean) >= bound)}
