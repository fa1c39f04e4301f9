"""The layout of a hierarchical fit: rows of counts to cells, parameters to tables in the unit of the levels."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.special import ndtri
from scipy.stats import t as t_distribution

from tactometry.psychometric import Shape

from ..arrays import Array, Indices
from ..mixed_models.glmm import lay_out
from ..mixed_models.laplace import ClusteredModel, MixedFit, inner_mode, precision_of
from ..threshold.counts import normalise
from ..threshold.likelihood import LOG_WIDTH, THRESHOLD
from ..threshold.status import Status
from .model import StudyCounts
from .starts import Alone

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
class Layout:
    """Cells of participants by conditions; a level is centre + spread * u."""

    participants: tuple[str, ...]
    conditions: pd.DataFrame
    width_group: Indices
    u: Array
    n_yes: Array
    n_trials: Array
    catch: Array
    centre: float
    spread: float
    on_log_levels: bool

    @classmethod
    def of(
        cls,
        names: NDArray[np.str_],
        factors: Mapping[str, NDArray[np.generic]],
        width_by: Sequence[str],
        answers: tuple[Array, Array, Array],
        *,
        on_log_levels: bool,
        catch: tuple[Array, Array] | None = None,
    ) -> "Layout":
        """From rows of a level each; `catch` are the false alarms and catch trials of each row's cell."""
        keys = pd.DataFrame(dict(factors))
        conditions = keys.drop_duplicates().sort_values(list(factors)).reset_index(drop=True)
        place = conditions.reset_index().merge(keys.reset_index(), on=list(factors)).sort_values("index_y")["index_x"]
        who, participant = np.unique(names, return_inverse=True)
        cell = participant * len(conditions) + place.to_numpy()
        centre, spread = _scale(answers[0])
        u, k, n = _stacked(cell, len(who) * len(conditions), ((answers[0] - centre) / spread, *answers[1:]))
        group = (
            conditions.groupby(list(width_by), sort=True).ngroup().to_numpy() if width_by else np.zeros(len(conditions))
        )
        layout, codes, kinds = (len(who), len(conditions), -1), tuple(map(str, who)), group.astype(np.int64)
        own_catch = np.zeros((2, len(who) * len(conditions)))
        if catch is not None:
            own_catch[:, cell] = catch
        u, k, n = (rows.reshape(layout) for rows in (u, k, n))
        by_cell = own_catch.reshape(2, *layout[:2])
        return cls(codes, conditions, kinds, u, k, n, by_cell, centre, spread, on_log_levels)

    def study(self, shape: Shape, asymptotes: tuple[float | None, float | None], catch: tuple[int, int]) -> StudyCounts:
        return StudyCounts(shape, self.u, self.n_yes, self.n_trials, self.width_group, *asymptotes, *catch, self.catch)

    def level(self, u: Array) -> Array:
        """In the unit of the levels."""
        with np.errstate(over="ignore"):
            level = self.centre + self.spread * u
            return np.asarray(np.exp(level) if self.on_log_levels else level)


def _scale(x: Array) -> tuple[float, float]:
    low, high = float(x.min()), float(x.max())
    return low + (high - low) / 2, (high - low) or 1.0


def _stacked(cell: Indices, n_cells: int, columns: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
    """Rows as (n_cells, n_rows of the largest cell), equal levels of a cell pooled."""
    counts = normalise(*lay_out(cell, *columns, n_clusters=n_cells))
    # Back from each cell's own scale to that of the study, which the means of conditions need.
    u = np.where(counts.n_trials > 0, counts.centre[:, None] + counts.spread[:, None] * counts.u, 0.0)
    return u, counts.n_yes, counts.n_trials


@dataclass(frozen=True)
class ParameterPlace:
    """Thresholds (in ranges of the levels) and log widths with standard errors, each (n_conditions, ...); NaN for a
    condition without a threshold."""

    threshold: Array
    threshold_se: Array
    log_width: Array
    log_width_se: Array

    @classmethod
    def of(cls, estimates: Sequence[Array], told: Indices, n_conditions: int) -> "ParameterPlace":
        columns = [np.full((n_conditions, *values.shape[1:]), np.nan) for values in estimates]
        for column, values in zip(columns, estimates, strict=True):
            column[told] = values
        return cls(*columns)

    def by_participant(self) -> "ParameterPlace":
        """Of cells (n_conditions, n_participants), in one row after the other of each participant."""
        return ParameterPlace(
            self.threshold.T.ravel(), self.threshold_se.T.ravel(), self.log_width.T.ravel(), self.log_width_se.T.ravel()
        )

    def ends(self, reach: float) -> Array:
        """Of the intervals of the thresholds (..., 2)."""
        return np.asarray(self.threshold[..., None] + reach * self.threshold_se[..., None] * np.array([-1.0, 1.0]))


def means(study: StudyCounts, mixed_fit: MixedFit, inflation: float) -> tuple[Array, ...]:
    """Of the conditions: thresholds and log widths, each with standard errors."""
    c, group = study.n_conditions, study.n_conditions + study.width_group
    se = inflation * np.sqrt(np.diagonal(mixed_fit.covariance))
    return mixed_fit.parameters[:c], se[:c], mixed_fit.parameters[group], se[group]


def cells(model: ClusteredModel, mixed_fit: MixedFit) -> tuple[Array, ...]:
    """Of the cells, shrunken: the variance is that of the effects at all parameters of the group, plus that which these
    bring: means, rates and variances (Kass and Steffey 1989, J. Am. Stat. Assoc. 84, 717-726).
    """
    inner, n_free = mixed_fit.inner, model.n_fixed + model.n_shared
    d, hessian = 2, inner.at.hessian
    precision = precision_of(inner.loads, model.curvature(inner.points))
    spread = np.linalg.solve(precision[:, None], np.swapaxes(inner.loads, 2, 3))
    inside = np.einsum("csaq,csqa->csa", inner.loads, spread)
    # A parameter moves a cell's predictors directly, and by the mode of the effects, which follows it.
    direct = np.concatenate([model.fixed, np.zeros((*model.fixed.shape[:3], model.n_shared))], axis=3)
    pushed = np.einsum("csab,csbp->csap", hessian[..., :d, :d], direct)
    pushed[..., model.n_fixed :] += hessian[..., :d, d:]
    pull = np.linalg.solve(precision, np.einsum("csaq,csap->cqp", inner.loads, pushed))
    along = direct + np.einsum("csaq,cqp->csap", inner.loads, pull)
    along = np.concatenate([along, _along_scales(model, mixed_fit, n_free)], axis=3)
    variance = inside + np.einsum("csap,pr,csar->csa", along, mixed_fit.covariance, along, optimize=True)
    eta, se = np.swapaxes(inner.points[..., :d], 0, 1), np.swapaxes(np.sqrt(variance), 0, 1)
    return eta[..., THRESHOLD], se[..., THRESHOLD], eta[..., LOG_WIDTH], se[..., LOG_WIDTH]


def _along_scales(model: ClusteredModel, mixed_fit: MixedFit, n_free: int) -> Array:
    """How the points of the cells move with each scale, (n_clusters, n_slots, 2, n_theta), by central differences."""
    moved = np.zeros((*mixed_fit.inner.points.shape[:2], 2, len(mixed_fit.parameters) - n_free))
    for j in range(moved.shape[-1]):
        step = SCALE_STEP * max(abs(mixed_fit.parameters[n_free + j]), SCALE_STEP)
        change = step * (np.arange(len(mixed_fit.parameters)) == n_free + j)
        ahead, behind = (
            inner_mode(model, mixed_fit.parameters + side * change, mixed_fit.inner.effects).points[..., :2]
            for side in (1, -1)
        )
        moved[..., j] = (ahead - behind) / (2 * step)
    return moved


def condition_table(
    layout: Layout, study: StudyCounts, place: ParameterPlace, alone: Alone, reach: float
) -> pd.DataFrame:
    """Of the means; where no participant tells a threshold, its status alone: bounds of participants bound no mean."""
    low, high, _ = study.ranges()
    status = [_placed(*each) for each in zip(alone.statuses(), place.threshold, low, high, strict=True)]
    table = _table(layout, place, status, place.ends(reach), reach)
    if alone.separated:
        widest = np.where(table["width"].isna(), np.nan, layout.spread * alone.width_bounds())
        table = table.assign(width=np.nan, width_low=np.nan, width_high=widest)
    return pd.concat([layout.conditions, table], axis=1)


def participant_table(
    layout: Layout, study: StudyCounts, place: ParameterPlace, alone: Alone, reach: float
) -> pd.DataFrame:
    """Of the cells, by participant, with the verdict that the cell's own answers have: where they hold no threshold
    there is none, but their own bound; others are drawn to the group."""
    rows = place.by_participant()
    single = [cell[p] for p in range(study.n_participants) for cell in alone.cells]
    status = [
        Status.OK if one.status == Status.SEPARATED and not none else one.status
        for one, none in zip(single, np.isnan(rows.threshold), strict=True)
    ]
    own_bounds = alone.own_bounds().swapaxes(0, 1).reshape(-1, 2)  # participant by participant, as the rows are
    is_censored = np.isin(status, CENSORED)
    table = _table(layout, rows, status, np.where(is_censored[:, None], own_bounds, rows.ends(reach)), reach)
    keys = layout.conditions.loc[np.tile(np.arange(study.n_conditions), study.n_participants)].reset_index(drop=True)
    keys.insert(0, "participant", np.repeat(layout.participants, study.n_conditions))
    return pd.concat([keys, table.assign(n_trials=study.n_trials.sum(axis=2).ravel().astype(int))], axis=1)


def _placed(status: Status, threshold: float, low: float, high: float) -> Status:
    if np.isnan(threshold):
        return status
    return Status.BELOW if threshold < low else Status.ABOVE if threshold > high else status


def _table(layout: Layout, place: ParameterPlace, status: list[Status], ends: Array, reach: float) -> pd.DataFrame:
    has_number = np.array([one not in WITHOUT_NUMBER for one in status]) & ~np.isnan(place.threshold)
    # Of a threshold above the levels the lower end is a bound, of one below them the upper end.
    has_low = has_number | np.array([one == Status.ABOVE for one in status])
    has_high = has_number | np.array([one == Status.BELOW for one in status])
    steps = reach * place.log_width_se[:, None] * np.array([-1.0, 0.0, 1.0])
    with np.errstate(over="ignore"):
        widths = layout.spread * np.exp(place.log_width[:, None] + steps)
    columns = {
        "threshold": np.where(has_number, layout.level(place.threshold), np.nan),
        "standard_error": np.where(has_number, layout.spread * place.threshold_se, np.nan),
        "interval_low": np.where(has_low, layout.level(ends[:, 0]), np.nan),
        "interval_high": np.where(has_high, layout.level(ends[:, 1]), np.nan),
        "width": np.where(has_number, widths[:, 1], np.nan),
        "width_low": np.where(has_number, widths[:, 0], np.nan),
        "width_high": np.where(has_number & np.isfinite(widths[:, 2]), widths[:, 2], np.nan),
        "status": [one.value for one in status],
    }
    return pd.DataFrame(columns)


def reaches(n_participants: int, interval: float) -> tuple[float, float]:
    """Standard errors to an interval's end: of the group's means (t, n - 1 degrees of freedom), of a participant."""
    share = (1 + interval) / 2
    normal = float(ndtri(share))
    return (float(t_distribution.ppf(share, n_participants - 1)) if n_participants > 1 else normal), normal
