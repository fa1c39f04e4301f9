"""The tables of a hierarchical fit: parameters in the unit of the levels."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.special import ndtri

from ..arrays import Array, Bools, Rows
from ..distributions import Student
from ..mixed_models.laplace import ClusteredModel, MixedFit, inner_mode, precision_of
from ..threshold.likelihood import LOG_WIDTH, THRESHOLD
from ..threshold.status import Status
from .starts import Alone
from .study import StudyCounts

CONDITION_COLUMNS = (
    "threshold",
    "standard_error",
    "interval_low",
    "interval_high",
    "width",
    "width_low",
    "width_high",
    "status",
)
CENSORED = (Status.BELOW, Status.ABOVE)
SCALE_STEP = 0.01
"""Of a difference along a standard deviation, in parts of it."""
WITHOUT_NUMBER = (*CENSORED, Status.FLAT, Status.NO_DATA)


@dataclass(frozen=True)
class ParameterPlace(Rows):
    """Thresholds (in ranges of the levels) and log widths with standard errors, each (n_conditions, ...); NaN for a
    condition without a threshold."""

    threshold: Array
    threshold_se: Array
    log_width: Array
    log_width_se: Array

    @classmethod
    def unknown(cls, *size: int) -> "ParameterPlace":
        return cls(*(np.full(size, np.nan) for _ in range(4)))

    def by_participant(self) -> "ParameterPlace":
        """Of cells (n_conditions, n_participants), in one row after the other of each participant."""
        return self._of_each(lambda values: values.T.ravel())

    def ends(self, reach: float) -> Array:
        """Of the intervals of the thresholds (..., 2)."""
        half = reach * self.threshold_se[..., None]
        return np.asarray(self.threshold[..., None] + half * np.array([-1.0, 1.0]))


def means(study: StudyCounts, mixed_fit: MixedFit, inflation: float) -> ParameterPlace:
    """Of the conditions: thresholds and log widths, each with standard errors."""
    c, group = study.n_conditions, study.n_conditions + study.width_group
    se = inflation * np.sqrt(np.diagonal(mixed_fit.covariance))
    return ParameterPlace(mixed_fit.parameters[:c], se[:c], mixed_fit.parameters[group], se[group])


def cells(model: ClusteredModel, mixed_fit: MixedFit) -> ParameterPlace:
    """Of the cells, shrunken: the variance is that of the effects at all parameters of the group, plus that which these
    bring: means, rates and variances (Kass and Steffey 1989, J. Am. Stat. Assoc. 84, 717-726).
    """
    inner, n_free = mixed_fit.inner, model.n_fixed + model.n_shared
    d, hessian = 2, inner.at.hessian  # two predictors of a cell: its threshold and its log width
    precision = precision_of(inner.loads, model.curvature(inner.points))
    spread = np.linalg.solve(precision[:, None], np.swapaxes(inner.loads, 2, 3))
    inside = np.einsum("csaq,csqa->csa", inner.loads, spread)
    # A parameter moves a cell's predictors directly, and by the mode of the effects, which follows it.
    nothing = np.zeros((*model.fixed.shape[:3], model.n_shared))
    direct = np.concatenate([model.fixed, nothing], axis=3)
    pushed = np.einsum("csab,csbp->csap", hessian[..., :d, :d], direct)
    pushed[..., model.n_fixed :] += hessian[..., :d, d:]
    by_effects = np.einsum("csaq,csap->cqp", inner.loads, pushed)
    pull = np.linalg.solve(precision, by_effects)
    along = direct + np.einsum("csaq,cqp->csap", inner.loads, pull)
    along = np.concatenate([along, _along_scales(model, mixed_fit, n_free)], axis=3)
    brought = np.einsum("csap,pr,csar->csa", along, mixed_fit.covariance, along, optimize=True)
    eta = np.swapaxes(inner.points[..., :d], 0, 1)
    se = np.swapaxes(np.sqrt(inside + brought), 0, 1)
    return ParameterPlace(eta[..., THRESHOLD], se[..., THRESHOLD], eta[..., LOG_WIDTH], se[..., LOG_WIDTH])


def _along_scales(model: ClusteredModel, mixed_fit: MixedFit, n_free: int) -> Array:
    """How the points of the cells move with each scale, (n_clusters, n_slots, 2, n_theta), by central differences."""
    parameters, effects = mixed_fit.parameters, mixed_fit.inner.effects
    moved = np.zeros((*mixed_fit.inner.points.shape[:2], 2, len(parameters) - n_free))
    for j in range(moved.shape[-1]):
        step = SCALE_STEP * max(abs(parameters[n_free + j]), SCALE_STEP)  # a scale may be 0, a step may not
        change = step * (np.arange(len(parameters)) == n_free + j)
        ahead = inner_mode(model, parameters + change, effects).points[..., :2]
        behind = inner_mode(model, parameters - change, effects).points[..., :2]
        moved[..., j] = (ahead - behind) / (2 * step)
    return moved


def condition_table(alone: Alone, place: ParameterPlace, reach: float) -> pd.DataFrame:
    """Of the means; where no participant tells a threshold, its status alone: bounds of participants bound no mean."""
    study = alone.study
    low, high, _ = study.ranges()
    status = [_status_of_mean(*one) for one in zip(alone.statuses(), place.threshold, low, high, strict=True)]
    table = _table(study, place, status, place.ends(reach), reach)
    if alone.separated:
        widest = np.where(table["width"].isna(), np.nan, study.spread * alone.width_bounds())
        table = table.assign(width=np.nan, width_low=np.nan, width_high=widest)
    return pd.concat([study.conditions, table], axis=1)


def participant_table(alone: Alone, place: ParameterPlace, reach: float) -> pd.DataFrame:
    """Of the cells, by participant, with the verdict that the cell's own answers have: where they hold no threshold
    there is none, but their own bound; others are drawn to the group."""
    study, rows = alone.study, place.by_participant()
    single = [cell[p] for p in range(study.n_participants) for cell in alone.cells]
    status = np.array([one.status for one in single], dtype=object)
    # Drawn to the group, a cell whose answers are one step has a width.
    status[(status == Status.SEPARATED) & ~np.isnan(rows.threshold)] = Status.OK
    cell_bounds = alone.cell_bounds().swapaxes(0, 1).reshape(-1, 2)  # participant by participant, as the rows are
    is_censored = np.isin(status, CENSORED)
    ends = np.where(is_censored[:, None], cell_bounds, rows.ends(reach))
    table = _table(study, rows, status.tolist(), ends, reach)
    n_trials = study.n_trials.sum(axis=2).ravel().astype(int)
    conditions = np.tile(np.arange(study.n_conditions), study.n_participants)
    keys = study.conditions.loc[conditions].reset_index(drop=True)
    keys.insert(0, "participant", np.repeat(study.participants, study.n_conditions))
    return pd.concat([keys, table.assign(n_trials=n_trials)], axis=1)


def _status_of_mean(status: Status, threshold: float, low: float, high: float) -> Status:
    if np.isnan(threshold):
        return status
    if threshold < low:
        return Status.BELOW
    return Status.ABOVE if threshold > high else status


def _table(study: StudyCounts, place: ParameterPlace, status: list[Status], ends: Array, reach: float) -> pd.DataFrame:
    has_number = np.array([one not in WITHOUT_NUMBER for one in status]) & ~np.isnan(place.threshold)
    # Of a threshold above the levels the lower end is a bound, of one below them the upper end.
    has_low = has_number | np.array([one == Status.ABOVE for one in status])
    has_high = has_number | np.array([one == Status.BELOW for one in status])
    steps = reach * place.log_width_se[:, None] * np.array([-1.0, 0.0, 1.0])
    with np.errstate(over="ignore"):
        widths = study.spread * np.exp(place.log_width[:, None] + steps)
    narrow, width, wide = widths.T
    columns = {
        "threshold": _where(has_number, study.level(place.threshold)),
        "standard_error": _where(has_number, study.spread * place.threshold_se),
        "interval_low": _where(has_low, study.level(ends[:, 0])),
        "interval_high": _where(has_high, study.level(ends[:, 1])),
        "width": _where(has_number, width),
        "width_low": _where(has_number, narrow),
        "width_high": _where(has_number & np.isfinite(wide), wide),
        "status": [one.value for one in status],
    }
    return pd.DataFrame(columns)


def _where(is_known: Bools, values: Array) -> Array:
    """The values that are known, NaN in place of the others."""
    return np.where(is_known, values, np.nan)


def reaches(n_participants: int, interval: float) -> tuple[float, float]:
    """Standard errors to an interval's end: of the group's means (t, n - 1 degrees of freedom), of a participant."""
    share = (1 + interval) / 2
    normal = float(ndtri(share))
    if n_participants == 1:
        return normal, normal
    return float(Student.ppf(share, n_participants - 1)), normal
