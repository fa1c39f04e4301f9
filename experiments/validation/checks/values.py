"""Checks of tests and intervals for values, by distribution of errors."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tactometry.analysis.anova.censored import censored_anova
from tactometry.analysis.anova.design import UndefinedStatistic
from tactometry.analysis.anova.group_means import group_table
from tactometry.analysis.anova.post_hoc import pairs
from tactometry.analysis.anova.within_subjects import permutation_test, repeated_measures
from tactometry.analysis.mixed_models.linear import mixed_model

from ..check import NO_ANSWER, Estimate, Simulate

N_CONDITIONS: Final = 4
EFFECT: Final = 1.1
"""Effect in the last condition, in standard deviations of the errors."""
PARTICIPANTS_SD: Final = 2.0
SHARE_OF_BOUNDS: Final = 0.15
ERRORS: Final = ("spherical", "AR(1), 0.7", "noisy")
DESIGNS: Final = (*((errors, 10) for errors in ERRORS), ("spherical", 6), ("spherical", 14))
OF: Final[dict[str, Any]] = {"dependent": "y", "subject": "participant"}
FIRST, LAST = 0, N_CONDITIONS - 1


def studies(
    errors: str, n_participants: int, n: int, rng: np.random.Generator, n_conditions: int = N_CONDITIONS
) -> NDArray[np.float64]:
    """Draw values without an effect (n, n_participants, n_conditions).

    Errors with variance 1 are independent, correlated by 0.7 per step, or three times as large in the first condition.
    """
    places = np.arange(n_conditions)
    covariance = {
        "spherical": np.eye(n_conditions),
        "AR(1), 0.7": 0.7 ** np.abs(np.subtract.outer(places, places)),
        "noisy": np.diag(np.where(places == 0, 9.0, 1.0)),
    }[errors]
    drawn = rng.standard_normal((n, n_participants, n_conditions))
    return np.asarray(drawn @ np.linalg.cholesky(covariance + PARTICIPANTS_SD**2).T)


def long_table(values: NDArray[np.float64]) -> pd.DataFrame:
    """Return a row per participant and condition. `cut` omits low values."""
    shape = [range(length) for length in values.shape]
    table = pd.MultiIndex.from_product(shape, names=["participant", "condition"]).to_frame(index=False)
    y = values.ravel()
    at = float(np.quantile(values[:, 1:], SHARE_OF_BOUNDS))
    return table.assign(y=y, cut=np.where(y < at, np.nan, y), low=np.nan, high=at)


def _censored(table: pd.DataFrame) -> Any:
    return censored_anova(table, dependent="cut", low="low", high="high", within="condition", subject="participant")


def _anova(column: str) -> Callable[[pd.DataFrame], float]:
    return lambda table: repeated_measures(table, within="condition", **OF)[column].iloc[0]


TESTED: Final[Mapping[str, Callable[[pd.DataFrame], float]]] = {
    "ANOVA, Chi-Muller": _anova("p_CM_corr"),
    "ANOVA, Greenhouse-Geisser": _anova("p_GG_corr"),
    "ANOVA, uncorrected": _anova("p_unc"),
    "ANOVA of values and bounds": lambda table: _censored(table).table["p_CM_corr"].iloc[0],
    "permutation test": lambda table: permutation_test(table, within="condition", **OF)["p_permutation"].iloc[0],
    "mixed model": lambda table: mixed_model(table, factors=["condition"], **OF).terms["p"].iloc[0],
    "pairs, Holm: any of six": lambda table: pairs(table, factor="condition", **OF)["p_corr"].min(),
}
"""Functions that return p of each test of a study."""


def p_of(test: str, table: pd.DataFrame) -> float:
    """Return p of a test, or NaN without a result."""
    try:
        return float(TESTED[test](table))
    except UndefinedStatistic:
        return float("nan")


def false_alarms(errors: str, n_participants: int, n_sets: int, rng: np.random.Generator) -> pd.DataFrame:
    """Test each simulated study without and with an effect."""
    rows = []
    for values in studies(errors, n_participants, n_sets, rng):
        for effect in (0.0, EFFECT):
            table = long_table(with_effect(values, effect))
            rows += [(effect, test, p_of(test, table)) for test in TESTED]
    named = pd.DataFrame(rows, columns=["effect", "test", "p"])
    return named.assign(errors=errors, participants=n_participants)


def with_effect(values: NDArray[np.float64], effect: float) -> NDArray[np.float64]:
    """Add an effect to the last condition."""
    return np.asarray(values + effect * (np.arange(values.shape[-1]) == values.shape[-1] - 1))


def effects(errors: str, n_participants: int, n_sets: int, rng: np.random.Generator) -> pd.DataFrame:
    """Estimate the last condition, and its difference to the first."""
    rows = []
    for values in studies(errors, n_participants, n_sets, rng):
        table = long_table(with_effect(values, EFFECT))
        rows += [(method, EFFECT, *result) for method, result in estimates(table).items()]
    named = pd.DataFrame(rows, columns=["method", "truth", "estimate", "low", "high"])
    return named.assign(errors=errors, participants=n_participants)


def estimates(table: pd.DataFrame) -> dict[str, Estimate]:
    """Return the estimate and interval of each method."""
    compared = pairs(table, factor="condition", **OF)
    pair = compared[(compared["a"] == FIRST) & (compared["b"] == LAST)].iloc[0]
    model = mixed_model(table, factors=["condition"], **OF).coefficients.iloc[LAST]
    group = group_table(table, ["condition"], "y").iloc[LAST]
    result = {
        "difference, pairs": tuple(pair[["difference", "difference_low", "difference_high"]]),
        "difference, mixed model": tuple(model[["estimate", "low", "high"]]),
        "mean": tuple(group[["mean", "mean_low", "mean_high"]]),
    }
    try:
        of_bounds = _censored(table).means().iloc[LAST][["mean", "mean_low", "mean_high"]]
    except UndefinedStatistic:
        of_bounds = NO_ANSWER
    return result | {"mean, of values and bounds": tuple(of_bounds)}


def _settings(simulate: Callable[..., pd.DataFrame]) -> Mapping[str, Simulate]:
    return {f"{errors}, {n} participants": partial(simulate, errors, n) for errors, n in DESIGNS}


PEOPLE: Final = f"""\
Values of participants in {N_CONDITIONS} conditions are normally distributed. Participants differ with an SD of
{PARTICIPANTS_SD:g} standard deviations of the errors. Errors are independent and equal (*spherical*), correlated by 0.7
per step (*AR(1)*), or three times as large in the first condition (*noisy*)."""
FALSE_ALARMS: Final[Mapping[str, Simulate]] = _settings(false_alarms)
EFFECTS: Final[Mapping[str, Simulate]] = _settings(effects)
