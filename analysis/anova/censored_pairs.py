"""Which conditions and groups differ, where some values are bounds: contrasts of `censored_anova`.

They equal `post_hoc.pairs` and `split_plot.group_pairs` where all values are known.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd
from scipy.stats import t as student

from ..arrays import Array
from .censored import CensoredAnova
from .post_hoc import all_together, two_one_sided, with_verdicts

LEAST_SD = 1e-7
"""In standard deviations of the values: the root of what a variance keeps of rounding."""


@dataclass(frozen=True)
class CellContrast:
    """The difference of two levels of a factor (`b` less `a` of its `keys`, which name a level of another factor too if
    there is one), with its standard error and degrees of freedom, and the standard deviation of the participants'
    differences; all in the unit of the design."""

    keys: Mapping[str, object]
    estimate: float
    error: float
    df: float
    sd: float

    @property
    def has_error(self) -> bool:
        return self.sd > LEAST_SD


def censored_pairs(
    model: CensoredAnova, factor: str, *, by: str | None = None, correction: str = "holm", interval: float = 0.95
) -> pd.DataFrame:
    """All pairs of levels of `factor`, averaged over the other factors and groups, or at each level of `by` (a factor
    or the groups); columns as those of `pairs`, without a Bayes factor and the interval of dz.

    A pair has its own error, that of the completed values, and loses the degrees of freedom that bounds leave open.

    >>> values = [3.0, 4, 6, 2, 5, 6, 4, 4, None, 1, 3, 5]
    >>> table = pd.DataFrame({"who": list("aaabbbcccddd"), "force_n": [0.5, 1, 2] * 4, "y": values})
    >>> from tactometry.analysis.anova.censored import censored_anova
    >>> found = censored_anova(table.assign(low=6.5, high=None), dependent="y", low="low", high="high",
    ...     within="force_n", subject="who")
    >>> censored_pairs(found, "force_n")[["a", "b", "difference"]].round(1).values.tolist()
    [[0.5, 1.0, 1.5], [0.5, 2.0, 3.5], [1.0, 2.0, 2.0]]
    """
    rows = [_row(contrast, model.design.scale, interval) for contrast in _contrasts(model, factor, by)]
    return all_together(pd.DataFrame(rows), correction, interval)


def censored_equivalence(model: CensoredAnova, factor: str, *, bound: float, alpha: float = 0.05) -> pd.DataFrame:
    """Two one-sided tests of all pairs of levels against +-`bound`; columns as those of `equivalence`."""
    rows, scale = [], model.design.scale
    for contrast in _contrasts(model, factor, None):
        tested = two_one_sided(contrast.estimate, contrast.error, contrast.df, bound, alpha, scale)
        rows.append({**contrast.keys, **tested, "bound": bound, "n": len(model.fit.data.low)})
    return with_verdicts(rows, bound, alpha)


def censored_group_pairs(
    model: CensoredAnova, *, by: str | None = None, correction: str = "holm", interval: float = 0.95
) -> pd.DataFrame:
    """All pairs of groups of participants, averaged over the conditions, or at each level of `by`; columns as those of
    `group_pairs`, without a Bayes factor."""
    rows = [
        keys | _group_row(model, weights, places, interval)
        for keys, weights, _ in _averages(model, by)
        for places in combinations(range(len(model.design.groups)), 2)
    ]
    return all_together(pd.DataFrame(rows), correction, interval)


def _contrasts(model: CensoredAnova, factor: str, by: str | None) -> list[CellContrast]:
    return [
        _contrast(model, cell, group, keys | names)
        for keys, average, group in _averages(model, by)
        for names, cell in _differences(model, factor, average)
    ]


def _differences(model: CensoredAnova, factor: str, average: Array) -> list[tuple[dict[str, object], Array]]:
    """Of all pairs of levels, the weights (cell,) of their difference in a mean of weights `average`."""
    place = model.design.factors.index(factor)
    levels, by_level = model.design.levels[place], np.moveaxis(average.reshape(model.fit.data.n_levels), place, 0)
    pairs = []
    for i, j in combinations(range(len(levels)), 2):
        weights = np.zeros_like(by_level)
        weights[j], weights[i] = by_level[j], -by_level[i]
        # The mean weighs every level 1 / n, a difference weighs two of them 1.
        pairs.append(({"a": levels[i], "b": levels[j]}, np.moveaxis(weights, 0, place).ravel() * len(levels)))
    return pairs


def _averages(model: CensoredAnova, by: str | None) -> list[tuple[dict[str, object], Array, int | None]]:
    """Weights (cell,) of the mean over all conditions (of each group, by its place), or over those at each level of a
    factor; each with the name of its level."""
    n_levels, groups = model.fit.data.n_levels, model.design.groups
    whole = np.full(n_levels, 1 / np.prod(n_levels))
    if by is None:
        return [({}, whole.ravel(), None)]
    if by == model.design.between:
        return [({by: name}, whole.ravel(), g) for g, name in enumerate(groups)]
    place = model.design.factors.index(by)
    shape = [-1 if axis == place else 1 for axis in range(len(n_levels))]
    masks = np.eye(n_levels[place])
    return [
        ({by: level}, (whole * mask.reshape(shape) * n_levels[place]).ravel(), None)
        for level, mask in zip(model.design.levels[place], masks, strict=True)
    ]


def _contrast(anova: CensoredAnova, cell: Array, group: int | None, keys: Mapping[str, object]) -> CellContrast:
    """Of conditions in one group, or in the plain mean of all groups."""
    fit, n_groups = anova.fit, len(anova.fit.means)
    of_groups = np.full(n_groups, 1 / n_groups) if group is None else np.eye(n_groups)[group]
    moments, df = (fit.pooled, fit.df) if group is None else (fit.moments[group], fit.data.sizes[group] - 1)
    weights, own_variance = np.kron(of_groups, cell), max(float(cell @ moments @ cell), 0.0)
    variance, model = float(weights @ fit.of_means @ weights), float(cell @ fit.model @ cell)
    # What is left of the information: the variance that all values known would leave, over the one there is.
    kept = min(1.0, model * float(np.sum(of_groups**2 / fit.data.sizes)) / variance)
    # The model shares a variance within a stratum; the contrast has its own.
    error = float(np.sqrt(variance * own_variance / model))
    estimate, sd = float(weights @ fit.means.ravel()), float(np.sqrt(own_variance))
    return CellContrast(keys, estimate, error, float(df) * kept, sd)


def _row(contrast: CellContrast, scale: float, interval: float) -> dict[str, object]:
    estimate, df = contrast.estimate, contrast.df
    row = {**contrast.keys, "difference": estimate * scale, "df": df}
    if not contrast.has_error:
        names = ("difference_low", "difference_high", "t", "p_unc", "dz", "bf10")
        return row | dict.fromkeys(names) | {"status": "zero_error"}
    tested = _t_test(estimate, contrast.error, df, scale, interval)
    return row | tested | {"dz": estimate / contrast.sd, "bf10": None, "status": "ok"}


def _t_test(estimate: float, error: float, df: float, scale: float, interval: float) -> dict[str, float]:
    t, half = estimate / error, float(student.isf((1 - interval) / 2, df)) * error
    ends = {"difference_low": (estimate - half) * scale, "difference_high": (estimate + half) * scale}
    return ends | {"t": t, "df": df, "p_unc": 2 * float(student.sf(abs(t), df))}


def _group_row(model: CensoredAnova, cell: Array, places: Sequence[int], interval: float) -> dict[str, object]:
    fit, scale, k = model.fit, model.design.scale, len(cell)
    n = fit.data.sizes[list(places)]
    blocks = [fit.of_means[g * k : (g + 1) * k, g * k : (g + 1) * k] for g in places]
    own_variances = np.array([cell @ fit.moments[g] @ cell for g in places])
    variances = own_variances * np.array([cell @ block @ cell for block in blocks]) / float(cell @ fit.model @ cell)
    first, second = (float(cell @ fit.means[g]) for g in places)
    error = np.sqrt(variances.sum())
    df = variances.sum() ** 2 / float(np.sum(variances**2 / (n - 1)))  # Welch and Satterthwaite's
    difference = second - first
    pooled_sd = np.sqrt(np.sum((n - 1) * own_variances) / (n.sum() - 2))
    size = difference / pooled_sd * (1 - 3 / (4 * n.sum() - 9))  # Hedges' correction of Cohen's d
    counts = {"a": model.design.groups[places[0]], "b": model.design.groups[places[1]]}
    counts |= {"difference": difference * scale, "n_a": int(n[0]), "n_b": int(n[1])}
    return counts | _t_test(difference, error, df, scale, interval) | {"g": size, "bf10": None, "status": "ok"}
