"""Which groups of participants differ: Welch's t-tests of participants' means with Holm's correction."""

from itertools import combinations

import numpy as np
import pandas as pd
from scipy.stats import ttest_ind

from ..arrays import RELATIVE_ZERO, Array, size_of
from .design import DesignStatus, UndefinedStatistic, finite_rows
from .post_hoc import all_together

MIN_GROUP = 2


def group_pairs(
    table: pd.DataFrame,
    *,
    dependent: str,
    between: str,
    subject: str,
    by: str | None = None,
    correction: str = "holm",
    interval: float = 0.95,
) -> pd.DataFrame:
    """Welch's t-tests between all groups, at each level of `by` if given; all corrected together. Values of one
    participant (at a level of `by`) are averaged.

    Returns
    -------
    DataFrame
        Per pair: `a`, `b`, `difference` (b less a) with its intervals as in `pairs`, `n_a`, `n_b`, `t`, `df`, `p_unc`,
        `p_corr`, Hedges' `g`, `bf10` (Rouder et al. 2009, scale 0.707, from Student's t), and a `status`: `ok`, or
        `zero_error` where participants within groups do not differ.

    Raises
    ------
    InvalidParameter
        As `mixed_anova`; and for a correction that is not known.

    >>> table = pd.DataFrame({"who": list("abcdef"), "hand": ["left"] * 3 + ["right"] * 3, "y": [3.0, 4, 5, 6, 8, 7]})
    >>> found = group_pairs(table, dependent="y", between="hand", subject="who")
    >>> found[["a", "b", "difference", "t", "p_corr", "g"]].round(3).values.tolist()
    [['left', 'right', 3.0, 3.674, 0.021, 2.4]]
    """
    keys = [subject, between, *([by] if by else [])]
    rows = finite_rows(table, [dependent, *keys], dependent, "group_pairs")
    means = rows.groupby(keys, sort=True, observed=True)[dependent].mean().reset_index()
    by_level = means.groupby(by, sort=True, observed=True) if by else [(None, means)]
    compared = [
        ({by: level} if by else {}) | row
        for level, at_level in by_level
        for row in _rows(at_level, dependent, between, interval)
    ]
    return all_together(pd.DataFrame(compared), correction, interval)


def _rows(means: pd.DataFrame, dependent: str, between: str, interval: float) -> list[dict[str, object]]:
    by_group = means.groupby(between, sort=True, observed=True)
    groups = {name: members[dependent].to_numpy(float) for name, members in by_group}
    if len(groups) < 2:
        raise UndefinedStatistic(
            f"{between}: found {len(groups)} group, expected at least 2 to compare", DesignStatus.ONE_LEVEL
        )
    for name, values in groups.items():
        if len(values) < MIN_GROUP:
            raise UndefinedStatistic(
                f"{between} = {name!s}: found one participant, expected at least {MIN_GROUP} a group",
                DesignStatus.TOO_FEW_PARTICIPANTS,
            )
    return [{"a": a, "b": b} | _tested(groups[a], groups[b], interval) for a, b in combinations(groups, 2)]


def _tested(first: Array, second: Array, interval: float) -> dict[str, object]:
    import pingouin

    size = size_of(np.concatenate([first, second]))
    first, second = first / size, second / size
    counts = {"difference": float(second.mean() - first.mean()) * size, "n_a": len(first), "n_b": len(second)}
    if max(np.ptp(first), np.ptp(second)) <= RELATIVE_ZERO:
        return counts | dict.fromkeys(_TESTED) | {"status": "zero_error"}
    welch, student = (ttest_ind(second, first, equal_var=alike) for alike in (False, True))
    ends = welch.confidence_interval(interval)
    g = float(pingouin.compute_effsize(second, first, eftype="hedges"))
    bayes = float(pingouin.bayesfactor_ttest(float(student.statistic), len(second), len(first)))
    tested = (ends.low * size, ends.high * size, welch.statistic, welch.df, welch.pvalue, g, bayes)
    return counts | dict(zip(_TESTED, map(float, tested), strict=True)) | {"status": "ok"}


_TESTED = ("difference_low", "difference_high", "t", "df", "p_unc", "g", "bf10")
