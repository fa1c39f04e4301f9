"""Analysis of variance of values of which some are bounds or missing: nobody is left out.

The model is that of `anova.repeated_measures` and `split_plot.mixed_anova` (`strata`), and so are F, degrees of
freedom, corrections and sizes of effects where all values are known. A bound counts as a value below or above it, a
missing value as one that could be any (missing at random, which a bound is not).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd
from scipy.linalg import helmert
from scipy.stats import t as student

from tactometry.arguments.require import expect

from ..arrays import Array
from .bounded_design import BoundedDesign, bounded_design
from .contrasts import Sphericity, Tested, epsilons
from .design import MAX_FACTORS, DesignStatus, expect_defined, names_of
from .group_means import within_variances
from .strata import LEAST_VARIANCE, StrataFit, fit_strata
from .within_subjects import INTERVAL, effect_table

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
            half = student.ppf((1 + interval) / 2, sizes - 1) * np.sqrt(variance * kept)
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
        table,
        dependent=dependent,
        low=low,
        high=high,
        within=factors,
        between=between,
        subject=subject,
        where="censored_anova",
    )
    fit = _fitted(design)
    tested = _tests(design, fit)
    # With groups the first effect is theirs, and each effect within is followed by its interaction, which shares its
    # error.
    errors = tested[1::2] if between else tested
    residual = fit.variances[0] * fit.inflation * fit.df_of(0) + sum(effect.ss_error for effect in errors)
    effect_rows = effect_table(tested, float(residual), design.scale, interval) if tested else pd.DataFrame()
    effect_rows.attrs |= {"notes": [], "n": len(design.data.low), "status": DesignStatus.OK}
    return CensoredAnova(effect_rows, design, fit)


def _fitted(design: BoundedDesign) -> StrataFit:
    """The fit, if it is a maximum that known values hold."""
    try:
        fit = fit_strata(design.data)
        with np.errstate(invalid="ignore"):
            errors = np.sqrt(np.diagonal(fit.covariance))
    except np.linalg.LinAlgError:
        errors = np.array([np.nan])
    holds = np.isfinite(errors).all() and fit.converged and errors[: fit.means.size].max() < WIDEST_SE
    found = "no maximum of the likelihood"
    expected = "known values that hold each mean; leave the conditions out in which most values are bounds"
    expect_defined(holds, DesignStatus.NO_MAXIMUM, "censored_anova", found, expected)
    return fit


def _tests(design: BoundedDesign, fit: StrataFit) -> list[Tested]:
    """In the order of `repeated_measures`, or of `mixed_anova`."""
    n_groups, places = len(fit.means), range(len(design.factors))
    together, apart = np.full((1, n_groups), 1 / n_groups), helmert(n_groups)
    tests = [] if design.between is None else [_tested(fit, 0, apart, design.between)]
    effects = (effect for r in range(1, len(places) + 1) for effect in combinations(places, r))
    for stratum, effect in enumerate(effects, 1):  # stratum 0 is that of the participants
        name = " * ".join(design.factors[place] for place in effect)
        tests.append(_tested(fit, stratum, together, name))
        if design.between is not None:
            tests.append(_tested(fit, stratum, apart, f"{design.between} * {name}"))
    return tests


def _tested(fit: StrataFit, stratum: int, of_groups: Array, name: str) -> Tested:
    """Wald's F of the contrasts of a stratum, of all groups together or between them."""
    contrasts = fit.data.strata[stratum]
    weights = np.kron(of_groups, contrasts)
    estimate, covariance = weights @ fit.means.ravel(), weights @ fit.of_means @ weights.T * fit.inflation
    first, second = len(weights), len(contrasts) * fit.df_of(stratum)
    error = float(fit.variances[stratum]) * fit.inflation
    if fit.variances[stratum] <= LEAST_VARIANCE * fit.variances.max():
        error = 0.0
    f = float(estimate @ np.linalg.solve(covariance, estimate)) / first
    shape = Sphericity(None, None, *epsilons(contrasts @ fit.pooled @ contrasts.T, fit.df_of(stratum)), singular=False)
    # Back from F to sums of squares, which every other analysis of variance gives to the table.
    return Tested(name, f * first * error, error * second, (first, second), shape)
