"""Linear mixed models with a random intercept per participant.

Cells may be missing, and covariates such as the measured force are supported.

statsmodels' MixedLM computes likelihood, estimates and covariance. Its search over the variance of participants can
end away from the maximum, so here it starts from the best point of a grid.
"""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd

from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter

from ..anova.design import DesignStatus, codes_of, expect_defined, finite_rows, refuse_constant, refuse_one
from ..arrays import RELATIVE_ZERO, Array, Indices, size_of
from ..distributions import Fisher, Student

RATIOS = (1e-8, 1e10)
"""Grid of ratios of participant variance to residual variance (in addition to 0)."""
N_GRID = 73
TOLERANCE = 1e-9
ALIKE = "participants do not differ by more than the residuals, so their variance is 0 (a singular but valid fit)"


class ModelStatus(StrEnum):
    """Status of a mixed model.

    `SINGULAR` means that participants do not differ by more than the residuals. The result is valid; the variance of
    participants is 0.
    """

    OK = "ok"
    SINGULAR = "singular"


@dataclass(frozen=True)
class MixedModel:
    """Fitted model y = X b + u(participant) + e.

    `coefficients` contains estimate, standard error, df, t, p and interval for each column of X. `terms` contains F for
    each factor, covariate and interaction, averaged over the others. Standard deviations are in the unit of the
    dependent value; `log_likelihood` is restricted (for `censored_model` unrestricted). `notes` are
    warnings for the reader. `n_censored` of the `n` values are known only by a bound.
    """

    coefficients: pd.DataFrame
    terms: pd.DataFrame
    participant_sd: float
    residual_sd: float
    log_likelihood: float
    n: int
    n_participants: int
    n_censored: int = 0

    @property
    def status(self) -> ModelStatus:
        return ModelStatus.SINGULAR if self.participant_sd == 0 else ModelStatus.OK

    @property
    def notes(self) -> tuple[str, ...]:
        return (ALIKE,) if self.status is ModelStatus.SINGULAR else ()

    @property
    def participant_variance(self) -> float:
        return self.participant_sd**2

    @property
    def residual_variance(self) -> float:
        return self.residual_sd**2


def mixed_model(
    table: pd.DataFrame,
    *,
    dependent: str,
    factors: Sequence[str] = (),
    covariates: Sequence[str] = (),
    subject: str,
    interactions: bool = True,
    base: Mapping[str, object] | None = None,
    interval: float = 0.95,
) -> MixedModel:
    """Fit a linear mixed model by restricted maximum likelihood.

    The model has a random intercept per participant.

    - `factors`: Columns of categories. The base level is the first value, or the one named in `base`.
    - `covariates`: Numeric columns, such as the logarithm of the measured force.
    - `interactions`: Whether to include all interactions of factors and covariates.

    Raises
    ------
    InvalidParameter
        For unknown columns, fewer than two participants, a base that is not a level, or terms that the data cannot
        separate. `UndefinedStatistic` is raised for values that are not finite (naming the row), constant values,
        values without error, or a factor with one level.

    Notes
    -----
    Cells may be missing: the design need not be complete. The model assumes that they are missing at random, which does
    not hold for censored thresholds. t and F have the degrees of freedom of a balanced design. For terms that vary
    within participants, these are the number of values minus the number of participants minus the number of such
    coefficients. For terms that vary only between participants, they are the number of participants minus the number of
    such coefficients and 1. A random intercept implies that the differences between all conditions have equal variances
    (sphericity). `anova.repeated_measures` does not assume this.

    >>> values = [3.0, 4, 6, 2, 5, 6, 4, 4, 7, 1, 3, 5]
    >>> table = pd.DataFrame({"who": list("aaabbbcccddd"), "force_n": [0.5, 1, 2] * 4, "y": values})
    >>> result = mixed_model(table, dependent="y", factors=["force_n"], subject="who")
    >>> result.coefficients[["term", "estimate"]].round(3).values.tolist()
    [['Intercept', 2.5], ['force_n = 1.0', 1.5], ['force_n = 2.0', 3.5]]
    >>> round(result.participant_variance, 4), round(result.residual_variance, 4)
    (0.5556, 0.4444)
    """
    design = model_design(table, dependent, factors, covariates, subject, interactions=interactions, base=base or {})
    size = size_of(design.y)
    y = design.y / size
    centre, scale = float(y.mean()), float(y.std())
    refuse_constant(scale, float(np.abs(y).max()), dependent)
    found, expected = (
        "values that participants and terms explain exactly",
        "values with some error, as F is undefined without error",
    )
    expect_defined(_has_error(y, design), DesignStatus.ZERO_ERROR, dependent, found, expected)
    fit = _fit((y - centre) / scale, design)
    log_unit = (len(y) - len(fit.estimates)) * float(np.log(scale) + np.log(size))
    fit = replace(fit, log_likelihood=fit.log_likelihood - log_unit)
    return described_model(design, fit, (centre * size, scale * size), interval)


def _checked_rows(
    table: pd.DataFrame, dependent: str, factors: Sequence[str], covariates: Sequence[str], subject: str
) -> pd.DataFrame:
    """Return the rows, after checking that numeric columns are finite."""
    columns = [dependent, subject, *factors, *covariates]
    expect(len(set(columns)) == len(columns), "mixed_model", ", ".join(columns), "each column once")
    data = finite_rows(table, columns, dependent, "mixed_model")
    for name in covariates:
        others = [column for column in columns if column != name]
        data[name] = finite_rows(data, [name, *others], name, "mixed_model")[name]
    n = data[subject].nunique()
    expect(n >= 2, subject, f"{n} participant", "at least 2 for a mixed model")
    return data


@dataclass(frozen=True)
class ModelDesign:
    """Design matrix with the values and participants of its rows.

    `y` (row,) contains the values, `groups` (row,) the indices of participants, and `x` (row, column) has the column
    `names`. `terms` maps the name of each term to its columns.

    `averaged` contains the same columns, coded about the mean of each factor and covariate. The columns of a term then
    describe its effect averaged over the other terms.
    """

    y: Array
    groups: Indices
    x: Array
    names: tuple[str, ...]
    terms: Mapping[str, tuple[int, ...]]
    averaged: Array

    @property
    def n_participants(self) -> int:
        return int(self.groups.max()) + 1

    @property
    def df(self) -> Indices:
        """Error degrees of freedom of each column.

        See Pinheiro and Bates 2000, section 2.4.2.

        A column that varies only between participants is tested against participants, all others against residuals.
        """
        x = self.averaged
        away = x - _group_means(x, self.groups)[self.groups]
        is_between = np.abs(away).max(axis=0) <= TOLERANCE * np.abs(x).max(axis=0)
        n_between = int(is_between.sum())
        residual = len(x) - self.n_participants - (x.shape[1] - n_between)
        df = np.where(is_between, self.n_participants - n_between, residual)
        df[0] = residual
        return df


def model_design(
    table: pd.DataFrame,
    dependent: str,
    factors: Sequence[str],
    covariates: Sequence[str],
    subject: str,
    *,
    interactions: bool,
    base: Mapping[str, object],
) -> ModelDesign:
    """Return the design matrix of factors, covariates and their products.

    Factors have treatment codes.

    Raises `InvalidParameter` as `mixed_model`. Also if a base is not a level, or columns are linearly dependent.
    """
    data = _checked_rows(table, dependent, factors, covariates, subject)
    single = {name: _codes(data, name, base.get(name)) for name in factors}
    single |= {name: {name: data[name].to_numpy(dtype=np.float64)} for name in covariates}
    centred = {name: _centred(single[name]) for name in factors}
    centred |= {name: {name: single[name][name] - single[name][name].mean()} for name in covariates}
    columns: dict[str, Array] = {"Intercept": np.ones(len(data))}
    averaged = [np.ones(len(data))]
    terms: dict[str, tuple[int, ...]] = {}
    for r in range(1, (len(single) if interactions else 1) + 1):
        for term in combinations(single, r):
            added = _products([single[name] for name in term])
            first = len(columns)
            terms[" * ".join(term)] = tuple(range(first, first + len(added)))
            columns |= added
            averaged += _products([centred[name] for name in term]).values()
    x = np.stack(list(columns.values()), axis=1)
    _refuse_dependent(x, list(columns), terms)
    y, groups = data[dependent].to_numpy(dtype=np.float64), pd.factorize(data[subject])[0]
    return ModelDesign(y, groups, x, tuple(columns), terms, np.stack(averaged, axis=1))


def _centred(codes: Mapping[str, Array]) -> dict[str, Array]:
    different = np.unique(np.stack(list(codes.values()), axis=1), axis=0)
    means = different.mean(axis=0)
    return {name: column - mean for (name, column), mean in zip(codes.items(), means, strict=True)}


def _codes(data: pd.DataFrame, name: str, base: object) -> dict[str, Array]:
    levels = codes_of(data, name)[1]
    refuse_one(name, len(levels), "value")
    first = levels[0] if base is None else base
    expect(first in levels, "base", f"{name} = {base}", f"one of {', '.join(map(str, levels))}")
    others = [level for level in levels if level != first]
    return {f"{name} = {level}": (data[name] == level).to_numpy().astype(np.float64) for level in others}


def _products(factors: Sequence[Mapping[str, Array]]) -> dict[str, Array]:
    products = dict(factors[0])
    for factor in factors[1:]:
        products = {f"{one} * {other}": x * y for one, x in products.items() for other, y in factor.items()}
    return products


def _refuse_dependent(x: Array, names: Sequence[str], terms: Mapping[str, Sequence[int]]) -> None:
    norms = np.linalg.norm(x, axis=0)
    scaled = x / np.where(norms > 0, norms, 1.0)
    for n in range(1, x.shape[1] + 1):  # column by column, to name the first dependent column
        if np.linalg.matrix_rank(scaled[:, :n], tol=TOLERANCE * n) < n:
            term = next((term for term, places in terms.items() if n - 1 in places), names[n - 1])
            raise InvalidParameter(
                f"{term}: found a column ({names[n - 1]}) that depends on earlier terms, expected terms that the data "
                "can separate; remove the term or the condition"
            )


def _has_error(y: Array, design: ModelDesign) -> bool:
    """Return True if participants and terms do not explain the values exactly."""
    both = np.column_stack([design.x, y])
    within = both - _group_means(both, design.groups)[design.groups]
    x_within, y_within = within[:, :-1], within[:, -1]
    # Columns that vary only between participants are rounding errors here; `rcond` ignores them.
    residual = y_within - x_within @ np.linalg.lstsq(x_within, y_within, rcond=TOLERANCE)[0]
    return bool(np.abs(residual).max() > RELATIVE_ZERO * np.abs(y).max())


def _group_means(columns: Array, groups: Indices) -> Array:
    sums = np.stack([np.bincount(groups, column) for column in columns.T], axis=1)
    return np.asarray(sums / np.bincount(groups)[:, None])


@dataclass(frozen=True)
class InterceptFit:
    """Estimates for (y - centre) / scale, before inflation of variances."""

    estimates: Array
    covariance: Array
    participant_sd: float
    residual_sd: float
    log_likelihood: float
    inflation: float = 1.0


def _fit(y: Array, design: ModelDesign) -> InterceptFit:
    """Return statsmodels' fit at the best ratio of variances."""
    from scipy.optimize import minimize_scalar  # slow to load
    from statsmodels.regression.linear_model import OLS
    from statsmodels.regression.mixed_linear_model import MixedLM, MixedLMParams

    alone, model = OLS(y, design.x).fit(), MixedLM(y, design.x, design.groups)

    def fitted(ratio: float) -> Any:
        start = MixedLMParams.from_components(alone.params, cov_re=np.array([[ratio]]))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # ignore MixedLM's warning about a search without steps
            return model.fit(start_params=start, method="bfgs", maxiter=0)

    fitted(1.0)  # MixedLM computes a likelihood only after a first fit

    def log_likelihood(log_ratio: float) -> float:
        return float(model.loglike(np.exp([log_ratio / 2])))

    # Search a grid first, as the bounded search may end at a local maximum.
    grid = np.linspace(float(np.log(RATIOS[0])), float(np.log(RATIOS[1])), N_GRID)
    best = int(np.argmax([log_likelihood(log_ratio) for log_ratio in grid]))
    bounds = (grid[max(best - 1, 0)], grid[min(best + 1, N_GRID - 1)])
    summit = minimize_scalar(
        lambda log_ratio: -log_likelihood(log_ratio), bounds=bounds, method="bounded", options={"xatol": 1e-10}
    )
    if best == 0:  # the smallest ratio of the grid counts as 0
        return InterceptFit(alone.params, alone.cov_params(), 0.0, float(np.sqrt(alone.scale)), log_likelihood(grid[0]))
    fit = fitted(float(np.exp(summit.x)))
    n = len(fit.fe_params)
    participant_sd, residual_sd = float(np.sqrt(fit.cov_re[0, 0])), float(np.sqrt(fit.scale))
    return InterceptFit(fit.fe_params, fit.cov_params()[:n, :n], participant_sd, residual_sd, -float(summit.fun))


def described_model(
    design: ModelDesign, fit: InterceptFit, unit: tuple[float, float], interval: float, n_censored: int = 0
) -> MixedModel:
    """Convert a fit to the unit of y.

    `unit` is (centre, scale). The log-likelihood is already in the unit of y.
    """
    inflation = float(np.sqrt(fit.inflation))
    return MixedModel(
        coefficients=_coefficients(design, fit, unit, interval),
        terms=_terms(design, fit),
        participant_sd=fit.participant_sd * unit[1] * inflation,
        residual_sd=fit.residual_sd * unit[1] * inflation,
        log_likelihood=fit.log_likelihood,
        n=len(design.y),
        n_participants=design.n_participants,
        n_censored=n_censored,
    )


def _coefficients(design: ModelDesign, fit: InterceptFit, unit: tuple[float, float], interval: float) -> pd.DataFrame:
    (centre, scale), df = unit, design.df
    se = np.sqrt(np.diagonal(fit.covariance))
    is_intercept = np.arange(len(se)) == 0
    shifted = fit.estimates + np.where(is_intercept, centre / scale, 0.0)
    t = shifted / se
    half = Student.ppf((1 + interval) / 2, df) * se
    return pd.DataFrame(
        {
            "term": list(design.names),
            "estimate": shifted * scale,
            "se": se * scale,
            "df": df,
            "t": t,
            "p": 2 * Student.sf(np.abs(t), df),
            "low": (shifted - half) * scale,
            "high": (shifted + half) * scale,
        }
    )


def _terms(design: ModelDesign, fit: InterceptFit) -> pd.DataFrame:
    """Return Wald F of each term, averaged over the others (type III)."""
    # Refit with averaged codes: with treatment codes, a main effect would refer to the base levels of other factors.
    turn = np.linalg.lstsq(design.averaged, design.x, rcond=None)[0]
    estimates, covariance = turn @ fit.estimates, turn @ fit.covariance @ turn.T
    rows = []
    for name, columns in design.terms.items():
        term = list(columns)
        df1, df2 = len(term), int(design.df[term].min())
        of_term = covariance[np.ix_(term, term)]
        f = float(estimates[term] @ np.linalg.solve(of_term, estimates[term])) / df1
        p = float(Fisher.sf(f, df1, df2))
        rows.append({"term": name, "df1": df1, "df2": df2, "F": f, "p": p})
    return pd.DataFrame(rows)
