"""Mixed analysis of variance and comparisons of groups.

Designs have one factor between and one to three factors within participants.

statsmodels computes type III sums of squares of the contrasts, so that group means have equal weight. pingouin supports
one factor within participants only, and tests weighted means if groups differ in size.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import pandas as pd

from tactometry.arguments.require import expect

from ..arrays import RELATIVE_ZERO, Array, Indices, size_of
from ..means import parts
from .design import (
    DesignStatus,
    effects,
    epsilons,
    expect_defined,
    finite_rows,
    names_of,
    participant_scores,
    refuse_one,
    within_design,
)
from .post_hoc import all_together, bayes_factor
from .within_subjects import INTERVAL, EffectTest, effect_table, scaled_design, with_notes

MIN_GROUP = 2
_TESTED = ("difference_low", "difference_high", "t", "df", "p_unc", "g", "bf10")


def mixed_anova(
    table: pd.DataFrame,
    *,
    dependent: str,
    within: Sequence[str] | str,
    between: str,
    subject: str,
    interval: float = INTERVAL,
) -> pd.DataFrame:
    """Compute a mixed analysis of variance.

    The columns are those of `repeated_measures`, without Mauchly's test.

    Effects within participants and their interactions have epsilons from the covariance pooled within groups.

    Raises
    ------
    InvalidParameter
        As `repeated_measures`; and for a participant in two groups, fewer than two groups, or a group of one.

    >>> values = [3.0, 4, 2, 5, 4, 4, 1, 3, 5, 9, 4, 9]
    >>> table = pd.DataFrame({"who": list("aabbccddeeff"), "force_n": [0.5, 1] * 6, "y": values})
    >>> table["hand"] = ["left"] * 6 + ["right"] * 6
    >>> result = mixed_anova(table, dependent="y", within="force_n", between="hand", subject="who")
    >>> result[["Source", "F"]].round(3).values.tolist()
    [['hand', 0.88], ['force_n', 16.071], ['hand * force_n', 3.5]]
    """
    factors = names_of(within)
    rows = finite_rows(table, [dependent, subject, *factors, between], dependent, "mixed_anova")
    design = within_design(rows, dependent=dependent, within=factors, subject=subject, where="mixed_anova")
    groups = groups_of(rows, design.participants, subject, between)
    scaled, scale = scaled_design(design, dependent)

    _, of_groups = _tests(between, participant_scores(scaled)[:, None], groups, between)
    tested = [replace(of_groups, name=between)]
    for effect in effects(scaled):
        tested += _tests(effect.name, effect.scores, groups, between)
    # An effect within participants and its interaction with the group share an error.
    residual = tested[0].ss_error + sum(within_effect.ss_error for within_effect in tested[1::2])
    return with_notes(effect_table(tested, residual, scale, interval), design, "statsmodels", tested)


@dataclass(frozen=True)
class Groups:
    """Index of each participant's group, with sizes and names of groups."""

    of: Indices
    sizes: Array
    names: tuple[object, ...]


def groups_of(rows: pd.DataFrame, participants: Sequence[object], subject: str, between: str) -> Groups:
    """Return the group of each participant.

    Raises `InvalidParameter` for a participant in two groups, fewer than two groups, or a group of one.
    """
    n_groups = rows.groupby(subject, observed=True)[between].nunique(dropna=False)
    found = f"{n_groups.max()} groups of the participant {n_groups.idxmax()}"
    expect((n_groups == 1).all(), between, found, "one group; declare it as a within-participants factor")
    group_of = rows.drop_duplicates(subject).set_index(subject)[between].to_dict()
    of, names = pd.factorize(np.array([group_of[code] for code in participants]), sort=True)
    sizes = np.bincount(of)
    _refuse_small(between, dict(zip(names.tolist(), sizes.tolist(), strict=True)))
    return Groups(of, sizes.astype(np.float64), tuple(names.tolist()))


def _refuse_small(between: str, sizes: Mapping[object, int]) -> None:
    refuse_one(between, len(sizes), "group")
    smallest = min(sizes, key=lambda name: sizes[name])
    is_enough, expected = sizes[smallest] >= MIN_GROUP, f"at least {MIN_GROUP} in each group"
    expect_defined(is_enough, DesignStatus.SMALL_GROUP, f"{between} = {smallest}", "one participant", expected)


def _tests(name: str, scores: Array, groups: Groups, between: str) -> tuple[EffectTest, EffectTest]:
    """Test mean scores with equal group weights, and their interaction."""
    from statsmodels.formula.api import ols  # slow to load
    from statsmodels.stats.anova import anova_lm

    tables = [pd.DataFrame({"score": column, "group": groups.of}) for column in scores.T]
    fits = [ols("score ~ C(group, Sum)", table).fit() for table in tables]
    ss, ss_of_groups, ss_error = np.sum([anova_lm(fit, typ=3)["sum_sq"] for fit in fits], axis=0)
    errors = np.stack([fit.resid for fit in fits], axis=1)

    p, n_groups = scores.shape[1], len(groups.sizes)
    df = len(scores) - n_groups
    shape = epsilons(errors.T @ errors / df, df)
    tested = []
    for effect, result, df_effect in ((name, ss, p), (f"{between} * {name}", ss_of_groups, p * (n_groups - 1))):
        f = result / df_effect / (ss_error / (p * df)) if ss_error > 0 else np.nan
        tested.append(EffectTest(effect, float(f), float(ss_error), (df_effect, p * df), shape))
    return tested[0], tested[1]


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
    """Compare all pairs of groups by Welch's t-tests, with a correction.

    If `by` is set, groups are compared at each of its levels. Values of one participant (at a level of `by`) are
    averaged.

    Returns
    -------
    DataFrame
        `a`, `b`, `difference` (b minus a) with intervals as in `pairs`, `n_a`, `n_b`, `t`, `df`, `p_unc`, `p_corr`,
        Hedges' `g`, `bf10` from Student's t, and a `status`: `ok`, or `zero_error` if values do not vary within groups.

    Raises
    ------
    InvalidParameter
        As `mixed_anova`; and for an unknown correction.

    >>> table = pd.DataFrame({"who": list("abcdef"), "hand": ["left"] * 3 + ["right"] * 3, "y": [3.0, 4, 5, 6, 8, 7]})
    >>> result = group_pairs(table, dependent="y", between="hand", subject="who")
    >>> result[["a", "b", "difference", "t", "p_corr", "g"]].round(3).values.tolist()
    [['left', 'right', 3.0, 3.674, 0.021, 2.4]]
    """
    keys = [subject, between, *([by] if by else [])]
    rows = finite_rows(table, [dependent, *keys], dependent, "group_pairs")
    means = rows.groupby(keys, sort=True, observed=True)[dependent].mean().reset_index()
    compared = []
    for level, at_level in parts(means, keys[2:]):
        place: dict[str, object] = dict(zip(keys[2:], level, strict=True))
        by_group = at_level.groupby(between, sort=True, observed=True)[dependent]
        groups = {name: values.to_numpy(float) for name, values in by_group}
        _refuse_small(between, {name: len(values) for name, values in groups.items()})
        for a, b in combinations(groups, 2):
            compared.append(place | {"a": a, "b": b} | _welch_test(groups[a], groups[b], interval))
    return all_together(pd.DataFrame(compared), correction, interval)


def _welch_test(first: Array, second: Array, interval: float) -> dict[str, object]:
    import pingouin  # slow to load
    from scipy.stats import ttest_ind

    size = size_of(np.concatenate([first, second]))
    first, second = first / size, second / size
    row = {"difference": float(second.mean() - first.mean()) * size, "n_a": len(first), "n_b": len(second)}
    if max(np.ptp(first), np.ptp(second)) <= RELATIVE_ZERO:
        return row | dict.fromkeys(_TESTED) | {"status": "zero_error"}
    welch, student = (ttest_ind(second, first, equal_var=alike) for alike in (False, True))
    ends = welch.confidence_interval(interval)
    g = pingouin.compute_effsize(second, first, eftype="hedges")
    bayes = bayes_factor(float(student.statistic), len(second), len(first))
    tested = (ends.low * size, ends.high * size, welch.statistic, welch.df, welch.pvalue, g, bayes)
    return row | dict(zip(_TESTED, map(float, tested), strict=True)) | {"status": "ok"}
