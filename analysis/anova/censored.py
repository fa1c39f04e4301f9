"""Analysis of variance of values of which some are bounds or missing: nobody is left out.

The model is that of `anova.repeated_measures` and `split_plot.mixed_anova` (`strata`), and so are F, degrees of
freedom, corrections and sizes of effects where all values are known. A bound counts as a value below or above it, a
missing value as one that could be any (missing at random, which a bound is not).

Which conditions and groups differ: contrasts that equal `post_hoc.pairs` and `split_plot.group_pairs` where all values
are known.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd

from tactometry.arguments.require import expect

from ..arrays import Array
from ..distributions import Student
from .bounded_design import BoundedDesign, bounded_design
from .contrasts import effect_places, epsilons
from .design import MAX_FACTORS, DesignStatus, expect_defined, names_of
from .group_means import within_variances
from .post_hoc import all_together, two_one_sided, with_verdicts
from .strata import StrataFit, fit_strata
from .within_subjects import INTERVAL, EffectTest, effect_table

LEAVE_OUT = "leave the conditions out in which most values are bounds"
WIDEST_SE = 10.0
"""A mean of a larger standard error, in standard deviations of the known values, is not held by them."""


@dataclass(frozen=True)
class CensoredAnova:
    """`table` has the columns of `repeated_measures` (Mauchly's test is missing), `fit` is the model in the units of
    `design`."""

    table: pd.DataFrame
    design: BoundedDesign
    fit: StrataFit

    def means(self, interval: float = 0.95) -> pd.DataFrame:
        """Per condition (and group) `mean` with its t-interval between participants (`mean_low`, `mean_high`), their
        standard deviation `sd`, and the interval within participants (`within_low`, `within_high`; Cousineau and
        Morey's): each from the condition's own variance. Where nothing is censored they are those of `group_table`."""
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
    """Analysis of variance within participants, and between groups of them, of values that may be bounds.

    Parameters
    ----------
    dependent : str
        Its column; missing where the value is not known.
    low, high : str
        Columns of bounds, read where the value is missing; a missing bound is infinite.
    within : str or sequence of str
        Up to three columns of conditions (none: the means alone).
    between : str, optional
        The column of the groups of participants.
    interval : float
        Coverage of the intervals of the effect sizes.

    Raises
    ------
    InvalidParameter
        For a column that is not there, crossed bounds, several values in a cell, a participant in two groups. As
        `UndefinedStatistic`: for fewer than three participants, two levels or two known values in a condition, the same
        value everywhere, and where too little is known for an answer.

    Notes
    -----
    Maximum likelihood with the variances of the restricted likelihood (n / (n - groups)). F is Wald's with the observed
    information; its degrees of freedom are those of the design less what bounds leave open (Satterthwaite), its
    epsilons those of the covariance of the completed values.

    >>> values = [3.0, 4, 6, 2, 5, 6, 4, 4, None, 1, 3, 5]
    >>> table = pd.DataFrame({"who": list("aaabbbcccddd"), "force_n": [0.5, 1, 2] * 4, "y": values})
    >>> found = censored_anova(table.assign(low=6.5, high=None), dependent="y", low="low", high="high",
    ...     within="force_n", subject="who")
    >>> found.design.n_censored, found.means()["mean"].round(1).tolist()
    (1, [2.5, 4.0, 6.0])
    """
    factors = names_of(within)
    are_different = len({dependent, subject, *factors, between}) == len(factors) + 3
    holds = are_different and len(factors) <= MAX_FACTORS
    expect(holds, "within", ", ".join(factors), f"up to {MAX_FACTORS} different factors")
    design = bounded_design(
        table, dependent=dependent, low=low, high=high, within=factors, between=between, subject=subject
    )
    fit = _held_fit(design)
    tested = _tests(design, fit)
    least = min((effect.df[1] for effect in tested), default=1.0)
    found, expected = f"{least:.1f} degrees of freedom of an error", f"at least 1; {LEAVE_OUT}"
    expect_defined(least >= 1, DesignStatus.NO_MAXIMUM, "censored_anova", found, expected)
    # With groups the first effect is theirs, and each effect within is followed by its interaction, which shares its
    # error.
    errors = tested[1::2] if between else tested
    residual = fit.variances[0] * fit.inflation * fit.df_of(0) + sum(effect.ss_error for effect in errors)
    effect_rows = effect_table(tested, float(residual), design.scale, interval) if tested else pd.DataFrame()
    effect_rows.attrs |= {"notes": [], "n": len(design.data.low), "status": DesignStatus.OK}
    return CensoredAnova(effect_rows, design, fit)


def _held_fit(design: BoundedDesign) -> StrataFit:
    """The fit, if it is a maximum that known values hold."""
    try:
        fit = fit_strata(design.data)
        with np.errstate(invalid="ignore"):
            errors = np.sqrt(np.diagonal(fit.covariance))
    except np.linalg.LinAlgError:
        errors = np.array([np.nan])
    holds = np.isfinite(errors).all() and fit.converged and errors[: fit.means.size].max() < WIDEST_SE
    found = "no maximum of the likelihood"
    expected = f"known values that hold each mean; {LEAVE_OUT}"
    expect_defined(holds, DesignStatus.NO_MAXIMUM, "censored_anova", found, expected)
    return fit


def _tests(design: BoundedDesign, fit: StrataFit) -> list[EffectTest]:
    """In the order of `repeated_measures`, or of `mixed_anova`."""
    from scipy.linalg import helmert  # slow to load

    n_groups = len(fit.means)
    together, apart = np.full((1, n_groups), 1 / n_groups), helmert(n_groups)
    tests = [] if design.between is None else [_wald_test(fit, 0, apart, design.between)]
    for stratum, places in enumerate(effect_places(len(design.factors)), 1):  # stratum 0 is that of the participants
        name = " * ".join(design.factors[place] for place in places)
        tests.append(_wald_test(fit, stratum, together, name))
        if design.between is not None:
            tests.append(_wald_test(fit, stratum, apart, f"{design.between} * {name}"))
    return tests


def _wald_test(fit: StrataFit, stratum: int, of_groups: Array, name: str) -> EffectTest:
    """Wald's F of the contrasts of a stratum, of all groups together or between them."""
    contrasts = fit.data.strata[stratum]
    weights = np.kron(of_groups, contrasts)
    estimate = weights @ fit.means.ravel()
    covariance = weights @ fit.of_means @ weights.T * fit.inflation
    first, second = len(weights), len(contrasts) * fit.df_of(stratum)
    error = float(fit.variances[stratum]) * fit.inflation
    if not fit.has_error[stratum]:
        error = 0.0
    f = float(estimate @ np.linalg.solve(covariance, estimate)) / first
    shape = epsilons(contrasts @ fit.pooled @ contrasts.T, fit.df_of(stratum))
    return EffectTest(name, f if error > 0 else np.nan, error * second, (first, second), shape)


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
    levels = model.design.levels[place]
    by_level = np.moveaxis(average.reshape(model.fit.data.n_levels), place, 0)
    pairs = []
    for i, j in combinations(range(len(levels)), 2):
        weights = np.zeros_like(by_level)
        weights[j], weights[i] = by_level[j], -by_level[i]
        names: dict[str, object] = {"a": levels[i], "b": levels[j]}
        # The mean weighs every level 1 / n, a difference weighs two of them 1.
        pairs.append((names, np.moveaxis(weights, 0, place).ravel() * len(levels)))
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
    averages: list[tuple[dict[str, object], Array, int | None]] = []
    for level, mask in zip(model.design.levels[place], np.eye(n_levels[place]), strict=True):
        at_level = whole * mask.reshape(shape) * n_levels[place]
        averages.append(({by: level}, at_level.ravel(), None))
    return averages


def _contrast(anova: CensoredAnova, cell: Array, group: int | None, keys: Mapping[str, object]) -> CellContrast:
    """Of conditions in one group, or in the plain mean of all groups."""
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
    # What is left of the information: the variance that all values known would leave, over the one there is.
    complete = model * float(np.sum(of_groups**2 / fit.data.sizes))
    kept = min(1.0, complete / variance)
    # The model shares a variance within a stratum; the contrast has its own.
    error = float(np.sqrt(variance * contrast_variance / model))
    estimate = float(weights @ fit.means.ravel())
    return CellContrast(keys, estimate, error, df * kept, float(np.sqrt(contrast_variance)))


def _row(contrast: CellContrast, scale: float, interval: float) -> dict[str, object]:
    estimate, df = contrast.estimate, contrast.df
    row = {**contrast.keys, "difference": estimate * scale, "df": df}
    if not contrast.has_error:
        names = ("difference_low", "difference_high", "t", "p_unc", "dz", "bf10")
        return row | dict.fromkeys(names) | {"status": "zero_error"}
    tested = _t_test(estimate, contrast.error, df, scale, interval)
    return row | tested | {"dz": estimate / contrast.sd, "bf10": None, "status": "ok"}


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
    # As in `_contrast`: the model shares a variance, each group has its own.
    variances = group_variances * of_means / float(cell @ fit.model @ cell)
    first, second = (float(cell @ fit.means[g]) for g in places)
    error = np.sqrt(variances.sum())
    df = variances.sum() ** 2 / float(np.sum(variances**2 / (n - 1)))  # Welch and Satterthwaite's
    difference = second - first
    pooled_sd = np.sqrt(np.sum((n - 1) * group_variances) / (n.sum() - 2))
    size = difference / pooled_sd * (1 - 3 / (4 * n.sum() - 9))  # Hedges' correction of Cohen's d
    counts = {"a": model.design.groups[places[0]], "b": model.design.groups[places[1]]}
    counts |= {"difference": difference * scale, "n_a": int(n[0]), "n_b": int(n[1])}
    return counts | _t_test(difference, error, df, scale, interval) | {"g": size, "bf10": None, "status": "ok"}
