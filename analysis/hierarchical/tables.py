"""The tables of a hierarchical fit: parameters in the unit of the levels."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from ..arrays import Array, Bools, Rows
from ..threshold.status import Status
from .draws import CellDraws, draw_cells, weighted_quantiles
from .model import GroupModel
from .posterior import Integrated, quantiles
from .single_fits import Alone
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
FEWEST_DRAWS = 100.0
"""Effective draws of a participant; with fewer the mixture of normals is used."""
MOST_EFFECTS = 40
"""With more effects of a participant, draws of all at once take too much memory."""
WITHOUT_NUMBER = (*CENSORED, Status.FLAT, Status.NO_DATA)


@dataclass(frozen=True)
class ParameterPlace(Rows):
    """Thresholds (in ranges of the levels) with standard errors and intervals, and log widths with intervals, each
    (n_conditions, ...); NaN for a condition without a threshold. Intervals have a last axis of two ends."""

    threshold: Array
    threshold_se: Array
    ends: Array
    log_width: Array
    log_width_ends: Array

    @classmethod
    def unknown(cls, *size: int) -> "ParameterPlace":
        of_each, two = np.full(size, np.nan), np.full((*size, 2), np.nan)
        return cls(of_each, of_each, two, of_each, two)

    @classmethod
    def of(cls, found: Integrated, values: Array, variances: Array, interval: float) -> "ParameterPlace":
        """From values (n_points, n_conditions, ..., 2) and their variances at each point."""
        mean = found.mean(values)
        se = np.sqrt(found.mean(variances + np.square(values - mean)))
        shares = ((1 - interval) / 2, (1 + interval) / 2)
        ends = np.stack([quantiles(found.weights, values, np.sqrt(variances), p) for p in shares], axis=-1)
        return cls(mean[..., 0], se[..., 0], ends[..., 0, :], mean[..., 1], ends[..., 1, :])

    def turned(self) -> "ParameterPlace":
        """With the first two axes in the other order."""
        return self._of_each(lambda values: np.swapaxes(values, 0, 1))

    def by_participant(self) -> "ParameterPlace":
        """Of cells (n_conditions, n_participants), in one row after the other of each participant."""
        return self.turned()._of_each(lambda values: values.reshape(-1, *values.shape[2:]))


def group_place(model: GroupModel, found: Integrated, interval: float) -> ParameterPlace:
    """Return thresholds and widths of the conditions."""
    c, n_free = model.study.n_conditions, found.at.means.shape[1]
    every = model.every_mean(found.at.hyper, found.at.means)
    variances = np.zeros(every.shape)
    variances[:, :n_free] = np.diagonal(found.at.covariance, axis1=1, axis2=2)
    places = np.stack([np.arange(c), c + model.study.width_group], axis=-1)
    return ParameterPlace.of(found, every[:, places], variances[:, places], interval)


def cell_place(model: GroupModel, found: Integrated, interval: float) -> tuple[ParameterPlace, Array]:
    """Return shrunken values of the cells, with the lapse rates of the participants."""
    normal = ParameterPlace.of(found, found.at.cells, found.at.variances, interval)
    rates = found.mean(model.lapses(found.at.hyper, found.at.effects))
    if not 0 < model.random.shape[2] <= MOST_EFFECTS:
        return normal.turned(), rates
    draws = draw_cells(model, found)
    is_known = draws.n_effective >= FEWEST_DRAWS
    rates = np.where(is_known, (draws.weights * draws.lapse_rates).sum(axis=0), rates)
    return _place_of_draws(draws, interval).where(is_known, normal).turned(), rates


def _place_of_draws(draws: CellDraws, interval: float) -> ParameterPlace:
    weights = np.broadcast_to(draws.weights[..., None, None], draws.points.shape)
    mean = (weights * draws.points).sum(axis=0)
    se = np.sqrt((weights * np.square(draws.points - mean)).sum(axis=0))
    shares = ((1 - interval) / 2, (1 + interval) / 2)
    ends = np.stack([weighted_quantiles(draws.points, weights, share) for share in shares], axis=-1)
    return ParameterPlace(mean[..., 0], se[..., 0], ends[..., 0, :], mean[..., 1], ends[..., 1, :])


def condition_table(alone: Alone, place: ParameterPlace) -> pd.DataFrame:
    """Of the means; where no participant tells a threshold, its status alone: bounds of participants bound no mean."""
    study = alone.study
    low, high, _ = study.ranges()
    status = [_status_of_mean(*one) for one in zip(alone.statuses(), place.threshold, low, high, strict=True)]
    table = _table(study, place, status, place.ends)
    if alone.separated:
        widest = np.where(table["width"].isna(), np.nan, study.spread * alone.width_bounds())
        table = table.assign(width=np.nan, width_low=np.nan, width_high=widest)
    return pd.concat([study.conditions, table], axis=1)


def participant_table(alone: Alone, place: ParameterPlace, lapse_rates: Array | None) -> pd.DataFrame:
    """Of the cells, by participant, with the verdict that the cell's own answers have: where they hold no threshold
    there is none, but their own bound; others are drawn to the group."""
    study, rows = alone.study, place.by_participant()
    single = [cell[p] for p in range(study.n_participants) for cell in alone.cells]
    status = np.array([one.status for one in single], dtype=object)
    # Drawn to the group, a cell whose answers are one step has a width.
    status[(status == Status.SEPARATED) & ~np.isnan(rows.threshold)] = Status.OK
    cell_bounds = alone.cell_bounds().swapaxes(0, 1).reshape(-1, 2)  # participant by participant, as the rows are
    is_censored = np.isin(status, CENSORED)
    ends = np.where(is_censored[:, None], cell_bounds, rows.ends)
    table = _table(study, rows, status.tolist(), ends)
    n_trials = study.n_trials.sum(axis=2).ravel().astype(int)
    conditions = np.tile(np.arange(study.n_conditions), study.n_participants)
    keys = study.conditions.loc[conditions].reset_index(drop=True)
    keys.insert(0, "participant", np.repeat(study.participants, study.n_conditions))
    lapses = np.nan if lapse_rates is None else np.repeat(lapse_rates, study.n_conditions)
    return pd.concat([keys, table.assign(n_trials=n_trials, lapse_rate=lapses)], axis=1)


def _status_of_mean(status: Status, threshold: float, low: float, high: float) -> Status:
    if np.isnan(threshold):
        return status
    if threshold < low:
        return Status.BELOW
    return Status.ABOVE if threshold > high else status


def _table(study: StudyCounts, place: ParameterPlace, status: list[Status], ends: Array) -> pd.DataFrame:
    has_number = np.array([one not in WITHOUT_NUMBER for one in status]) & ~np.isnan(place.threshold)
    # Of a threshold above the levels the lower end is a bound, of one below them the upper end.
    has_low = has_number | np.array([one == Status.ABOVE for one in status])
    has_high = has_number | np.array([one == Status.BELOW for one in status])
    with np.errstate(over="ignore"):
        width, narrow, wide = study.spread * np.exp([place.log_width, *place.log_width_ends.T])
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
