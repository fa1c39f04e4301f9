"""Analysis of variance with censored or missing values.

No participant is excluded. If all values are known, F, degrees of freedom, corrections, effect sizes and comparisons
equal those of `repeated_measures`, `mixed_anova`, `pairs` and `group_pairs`. Missing values are assumed to be missing
at random.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd

from tactometry.arguments.require import expect

from ..arrays import Array
from ..distributions import Student
from .bounded_design import BoundedDesign, bounded_design
from .bounded_fit import BoundedFit, fit_bounded
from .design import MAX_FACTORS, DesignStatus, effect_places, epsilons, expect_defined, names_of
from .group_means import within_variances
from .post_hoc import all_together, two_one_sided, with_verdicts
from .within_subjects import INTERVAL, EffectTest, effect_table

LEAVE_OUT = "remove the conditions in which most values are bounds"
WIDEST_SE = 10.0
"""Largest standard error of a mean that counts as determined, in SDs of the known values."""
LEAST_SD = 1e-7
"""Standard deviations below this fraction of the values' SD count as rounding error."""


@dataclass(frozen=True)
class CensoredAnova:
    """Effects as in `repeated_measures`, with the fit in design units."""

    table: pd.DataFrame
    design: BoundedDesign
    fit: BoundedFit

    def means(self, interval: float = 0.95) -> pd.DataFrame:
        """Return condition means with the intervals described in `group_table`."""
        fit, (centre, scale) = self.fit, (self.design.centre, self.design.scale)
        kept = np.diagonal(fit.of_means) / np.tile(np.diagonal(fit.model), len(fit.means))
        sizes = np.repeat(fit.data.sizes, fit.means.shape[1])
        between = np.concatenate([np.diagonal(covariance) for covariance in fit.moments])
        inside = np.concatenate([within_variances(covariance) for covariance in fit.moments])
        mean = fit.means.ravel() + centre / scale
        columns = {"mean": mean, "sd": np.sqrt(between)}
        for name, variance in (("mean", between), ("within", inside)):
            half = Student.ppf((1 + interval) / 2, sizes - 1) * np.sqrt(variance * kept)
            columns |= {f"{name}_low": mean - half, f"{name}_high": mean + half}
        return pd.concat([pd.DataFrame(self.design.cells()), pd.DataFrame(columns) * scale], axis=1)


def censored_anova(
    table: pd.DataFrame,
    *,
    dependent: str,
    low: str,
    high: str,
    within: Sequence[str] | str,
    between: str | None = None,
    subject: str,
    interval: float = INTERVAL,
) -> CensoredAnova:
    """Compute an analysis of variance with values that may be censored.

    - `dependent`: Column of the values; empty if a value is unknown.
    - `low`, `high`: Columns of the bounds, used if the value is empty. An empty bound is infinite.
    - `within`: Up to three columns of conditions; without any, only the means are returned.
    - `between`: Column of the groups of participants.
    - `interval`: Coverage of the intervals of the effect sizes.

    Raises
    ------
    InvalidParameter
        For a missing column, a lower bound above the upper bound, several values in a cell, or a participant in two
        groups. `UndefinedStatistic` is raised for fewer than three participants, fewer than two levels, fewer than two
        known values in a condition, constant values, or too few known values.

    Notes
    -----
    Estimates are by maximum likelihood; variances are multiplied by n / (n - groups), as in restricted likelihood. F is
    the Wald statistic with the observed information. Its degrees of freedom are those of the design, reduced for bounds
    (Satterthwaite). Its epsilons come from the covariance expected under the fit.

    >>> values = [3.0, 4, 6, 2, 5, 6, 4, 4, None, 1, 3, 5]
    >>> table = pd.DataFrame({"who": list("aaabbbcccddd"), "force_n": [0.5, 1, 2] * 4, "y": values})
    >>> result = censored_anova(table.assign(low=6.5, high=None), dependent="y", low="low", high="high",
    ...     within="force_n", subject="who")
    >>> result.design.n_censored, result.means()["mean"].round(1).tolist()
    (1, [2.5, 4.0, 6.0])
    """
    factors = names_of(within)
    are_different = len({dependent, subject, *factors, between}) == len(factors) + 3
    is_possible = are_different and len(factors) <= MAX_FACTORS
    expect(is_possible, "within", ", ".join(factors), f"up to {MAX_FACTORS} different factors")
    names = {"dependent": dependent, "low": low, "high": high, "subject": subject}
    design = bounded_design(table, within=factors, between=between, **names)
    fit = _determined_fit(design)
    return CensoredAnova(_effects(design, fit, interval), design, fit)


def _determined_fit(design: BoundedDesign) -> BoundedFit:
    """Fit the design. Raises if the known values do not determine the fit."""
    try:
        fit = fit_bounded(design.data)
        with np.errstate(invalid="ignore"):
            errors = np.sqrt(np.diagonal(fit.covariance))
    except np.linalg.LinAlgError:
        errors = np.array([np.nan])
    is_determined = np.isfinite(errors).all() and fit.converged and errors[: fit.means.size].max() < WIDEST_SE
    found = "a likelihood without a maximum"
    expected = f"enough known values for each mean; {LEAVE_OUT}"
    expect_defined(is_determined, DesignStatus.NO_MAXIMUM, "censored_anova", found, expected)
    return fit


def _effects(design: BoundedDesign, fit: BoundedFit, interval: float) -> pd.DataFrame:
    """Return the effects in the order of `repeated_measures` or `mixed_anova`."""
    from scipy.linalg import helmert  # slow to load

    n_groups, between = len(fit.means), design.between
    together, apart = np.full((1, n_groups), 1 / n_groups), helmert(n_groups)
    tested = [] if between is None else [_wald_test(fit, 0, apart, between)]
    for stratum, places in enumerate(effect_places(len(design.factors)), 1):  # stratum 0 is the participants
        name = " * ".join(design.factors[place] for place in places)
        tested.append(_wald_test(fit, stratum, together, name))
        if between is not None:
            tested.append(_wald_test(fit, stratum, apart, f"{between} * {name}"))

    least = min((effect.df[1] for effect in tested), default=1.0)
    found, expected = f"{least:.1f} error degrees of freedom", f"at least 1; {LEAVE_OUT}"
    expect_defined(least >= 1, DesignStatus.NO_MAXIMUM, "censored_anova", found, expected)
    # With groups, a within-participant effect and its interaction with the group share an error.
    errors = sum(effect.ss_error for effect in (tested[1::2] if between else tested))
    residual = float(fit.variances[0] * fit.inflation * fit.df_of(0) + errors)
    table = effect_table(tested, residual, design.scale, interval) if tested else pd.DataFrame()
    table.attrs |= {"notes": [], "n": len(design.data.low), "status": DesignStatus.OK}
    return table


def _wald_test(fit: BoundedFit, stratum: int, of_groups: Array, name: str) -> EffectTest:
    """Test the contrasts of a stratum, averaged over groups or between groups."""
    contrasts = fit.data.strata[stratum]
    weights = np.kron(of_groups, contrasts)
    estimate = weights @ fit.means.ravel()
    covariance = weights @ fit.of_means @ weights.T * fit.inflation
    first, second = len(weights), len(contrasts) * fit.df_of(stratum)
    error = float(fit.variances[stratum]) * fit.inflation if fit.has_error[stratum] else 0.0
    f = float(estimate @ np.linalg.solve(covariance, estimate)) / first
    shape = epsilons(contrasts @ fit.pooled @ contrasts.T, fit.df_of(stratum))
    return EffectTest(name, f if error > 0 else np.nan, error * second, (first, second), shape)


@dataclass(frozen=True)
class CellContrast:
    """Difference between two levels, with standard error and df.

    `keys` names the levels `a` and `b`, and `estimate` is `b` minus `a`. `sd` is the standard deviation of the
    participants' differences. All values are in design units.
    """

    keys: Mapping[str, object]
    estimate: float
    error: float
    df: float
    sd: float


def censored_pairs(
    model: CensoredAnova, factor: str, *, by: str | None = None, correction: str = "holm", interval: float = 0.95
) -> pd.DataFrame:
    """Compare all pairs of levels, averaged or at each level of `by`.

    Averages are over the other factors and groups. The columns are those of `pairs`, without the Bayes factor and the
    interval of dz. Each pair has its own standard error. Bounds reduce the degrees of freedom.

    >>> values = [3.0, 4, 6, 2, 5, 6, 4, 4, None, 1, 3, 5]
    >>> table = pd.DataFrame({"who": list("aaabbbcccddd"), "force_n": [0.5, 1, 2] * 4, "y": values})
    >>> result = censored_anova(table.assign(low=6.5, high=None), dependent="y", low="low", high="high",
    ...     within="force_n", subject="who")
    >>> censored_pairs(result, "force_n")[["a", "b", "difference"]].round(1).values.tolist()
    [[0.5, 1.0, 1.5], [0.5, 2.0, 3.5], [1.0, 2.0, 2.0]]
    """
    rows, scale = [], model.design.scale
    for contrast in _contrasts(model, factor, by):
        row = {**contrast.keys, "difference": contrast.estimate * scale, "df": contrast.df}
        if contrast.sd <= LEAST_SD:
            names = ("difference_low", "difference_high", "t", "p_unc", "dz", "bf10")
            rows.append(row | dict.fromkeys(names) | {"status": "zero_error"})
        else:
            tested = _t_test(contrast.estimate, contrast.error, contrast.df, scale, interval)
            rows.append(row | tested | {"dz": contrast.estimate / contrast.sd, "bf10": None, "status": "ok"})
    return all_together(pd.DataFrame(rows), correction, interval)


def censored_equivalence(model: CensoredAnova, factor: str, *, bound: float, alpha: float = 0.05) -> pd.DataFrame:
    """Test all pairs of levels for equivalence within `bound`.

    The columns are those of `equivalence`.
    """
    rows, scale = [], model.design.scale
    for contrast in _contrasts(model, factor, None):
        tested = two_one_sided(contrast.estimate, contrast.error, contrast.df, bound, alpha, scale)
        rows.append({**contrast.keys, **tested, "bound": bound, "n": len(model.fit.data.low)})
    return with_verdicts(rows, bound, alpha)


def censored_group_pairs(
    model: CensoredAnova, *, by: str | None = None, correction: str = "holm", interval: float = 0.95
) -> pd.DataFrame:
    """Compare all pairs of groups, averaged or at each level of `by`.

    The columns are those of `group_pairs`, without the Bayes factor.
    """
    rows = [
        keys | _group_row(model, weights, places, interval)
        for keys, weights, _ in _averages(model, by)
        for places in combinations(range(len(model.design.groups)), 2)
    ]
    return all_together(pd.DataFrame(rows), correction, interval)


def _contrasts(model: CensoredAnova, factor: str, by: str | None) -> Iterator[CellContrast]:
    """Yield the difference between each pair of levels of `factor`."""
    place = model.design.factors.index(factor)
    levels = model.design.levels[place]
    for keys, average, group in _averages(model, by):
        by_level = np.moveaxis(average.reshape(model.fit.data.n_levels), place, 0)
        for i, j in combinations(range(len(levels)), 2):
            weights = np.zeros_like(by_level)
            weights[j], weights[i] = by_level[j], -by_level[i]
            # `by_level` weights each of n levels by 1 / n; a difference weights its two levels by 1.
            cell = np.moveaxis(weights, 0, place).ravel() * len(levels)
            yield _contrast(model, cell, group, keys | {"a": levels[i], "b": levels[j]})


def _averages(model: CensoredAnova, by: str | None) -> list[tuple[dict[str, object], Array, int | None]]:
    """Return the weights (cell,) of means, overall or at each level of `by`.

    Each item also contains the name of its level and the index of its group.
    """
    n_levels, groups = model.fit.data.n_levels, model.design.groups
    whole = np.full(n_levels, 1 / np.prod(n_levels))
    if by is None:
        return [({}, whole.ravel(), None)]
    if by == model.design.between:
        return [({by: name}, whole.ravel(), g) for g, name in enumerate(groups)]
    place = model.design.factors.index(by)
    shape = [-1 if axis == place else 1 for axis in range(len(n_levels))]
    masks = zip(model.design.levels[place], np.eye(n_levels[place]), strict=True)
    return [({by: level}, (whole * mask.reshape(shape) * n_levels[place]).ravel(), None) for level, mask in masks]


def _contrast(anova: CensoredAnova, cell: Array, group: int | None, keys: Mapping[str, object]) -> CellContrast:
    """Return a contrast in one group, or in the unweighted mean of groups."""
    fit, n_groups = anova.fit, len(anova.fit.means)
    if group is None:
        of_groups = np.full(n_groups, 1 / n_groups)
        moments, df = fit.pooled, float(fit.df)
    else:
        of_groups = np.eye(n_groups)[group]
        moments, df = fit.moments[group], float(fit.data.sizes[group] - 1)
    weights = np.kron(of_groups, cell)
    contrast_variance = max(float(cell @ moments @ cell), 0.0)
    variance, model = float(weights @ fit.of_means @ weights), float(cell @ fit.model @ cell)
    # Share of information that remains: variance if all values were known / actual variance.
    kept = min(1.0, model * float(np.sum(of_groups**2 / fit.data.sizes)) / variance)
    # Replace the model's common variance of the stratum with the variance of this contrast.
    error = float(np.sqrt(variance * contrast_variance / model))
    return CellContrast(keys, float(weights @ fit.means.ravel()), error, df * kept, float(np.sqrt(contrast_variance)))


def _t_test(estimate: float, error: float, df: float, scale: float, interval: float) -> dict[str, float]:
    t = estimate / error
    half = float(Student.isf((1 - interval) / 2, df)) * error
    ends = {"difference_low": (estimate - half) * scale, "difference_high": (estimate + half) * scale}
    return ends | {"t": t, "df": df, "p_unc": 2 * float(Student.sf(abs(t), df))}


def _group_row(model: CensoredAnova, cell: Array, places: Sequence[int], interval: float) -> dict[str, object]:
    fit, scale, k = model.fit, model.design.scale, len(cell)
    n = fit.data.sizes[list(places)]
    of_group = [slice(g * k, (g + 1) * k) for g in places]
    group_variances = np.array([cell @ fit.moments[g] @ cell for g in places])
    of_means = np.array([cell @ fit.of_means[rows, rows] @ cell for rows in of_group])
    # As in `_contrast`: replace the model's common variance with that of each group.
    variances = group_variances * of_means / float(cell @ fit.model @ cell)
    first, second = (float(cell @ fit.means[g]) for g in places)
    difference, error = second - first, np.sqrt(variances.sum())
    df = variances.sum() ** 2 / float(np.sum(variances**2 / (n - 1)))  # Welch-Satterthwaite

    pooled_sd = np.sqrt(np.sum((n - 1) * group_variances) / (n.sum() - 2))
    size = difference / pooled_sd * (1 - 3 / (4 * n.sum() - 9))  # Hedges' correction of Cohen's d
    row = {"a": model.design.groups[places[0]], "b": model.design.groups[places[1]]}
    row |= {"difference": difference * scale, "n_a": int(n[0]), "n_b": int(n[1])}
    return row | _t_test(difference, error, df, scale, interval) | {"g": size, "bf10": None, "status": "ok"}
