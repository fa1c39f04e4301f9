"""Tables of a hierarchical fit, in the unit of the levels.

With few trials, Laplace's approximation makes the intervals of participants 5 to 15 % too short. Draws are therefore
weighted by the exact density of the participant's answers and effects.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from ..arrays import Array, Indices, Rows
from ..threshold.fitting import ThresholdFit, fit_many
from ..threshold.status import Status
from .model import GroupModel, StudyCounts
from .posterior import InnerMode, Integrated, bordered, inner_at, quantiles

WITH_THRESHOLD = (Status.OK, Status.SEPARATED, Status.TOO_FEW_LEVELS)


@dataclass(frozen=True)
class SingleFits:
    """Fits of single cells (one list per condition) and of pooled conditions.

    The fit of a condition pools the answers of all participants. Levels are scaled as in the study.
    """

    study: StudyCounts
    cells: tuple[tuple[ThresholdFit, ...], ...]
    together: tuple[ThresholdFit, ...]

    @property
    def separated(self) -> bool:
        """True if every cell with a threshold changes in a single step."""
        statuses = [one.status for cell in self.cells for one in cell if has_threshold(one)]
        return bool(statuses) and all(status == Status.SEPARATED for status in statuses)

    def statuses(self) -> list[Status]:
        """Return a status per condition.

        The status is `ok` (or `separated`) if a cell or the pooled answers have a threshold. Otherwise it is the common
        status of the cells, or that of the pooled answers if the cells differ.
        """
        with_threshold, statuses = Status.SEPARATED if self.separated else Status.OK, []
        for cell, together in zip(self.cells, self.together, strict=True):
            of_cells = {one.status for one in cell} - {Status.NO_DATA}
            agreed = of_cells.pop() if len(of_cells) == 1 else together.status
            statuses.append(with_threshold if any(map(has_threshold, (*cell, together))) else agreed)
        return statuses

    @property
    def with_threshold(self) -> Indices:
        """Indices of the conditions with a threshold."""
        return np.flatnonzero([status in (Status.OK, Status.SEPARATED) for status in self.statuses()])

    def cell_bounds(self) -> Array:
        """Return bounds (n_conditions, n_participants, 2), NaN if none."""
        ends = [[(one.interval_low, one.interval_high) for one in cell] for cell in self.cells]
        return np.array(ends, dtype=np.float64)

    def width_bounds(self) -> Array:
        """Return the upper bound of each condition's pooled width, or NaN."""
        return np.array([np.nan if one.width_high is None else one.width_high for one in self.together])

    def start(self) -> tuple[Array, Array]:
        """Return a threshold and a log width of each condition with a threshold."""
        low, high, _ = self.study.only(self.with_threshold).ranges()
        middle, ends = (low + high) / 2, {Status.BELOW: low, Status.ABOVE: high}
        threshold, width = [], []
        for c, place in enumerate(self.with_threshold):
            cell, together = self.cells[place], self.together[place]
            fits = [one for one in cell if has_threshold(one)] or [together] * has_threshold(together)
            at = ends.get(together.status, middle)[c]  # lowest or highest level, whichever is nearer to the threshold
            threshold.append(np.mean([one.threshold for one in fits]) if fits else at)
            widths = [np.log(one.width) for one in fits if one.width is not None]
            half_range = max((high - low)[c] / 2, 1e-9)  # a single level has no range
            width.append(np.mean(widths) if widths else np.log(half_range))
        return np.array(threshold), np.array(width)


def has_threshold(one: ThresholdFit) -> bool:
    return one.status in WITH_THRESHOLD and one.threshold is not None


Known = Mapping[tuple[str, tuple[Any, ...]], ThresholdFit]
"""Fits of cells by participant and condition, in the original unit of the levels."""
PLACES = ("threshold", "interval_low", "interval_high", "threshold_mode", "threshold_median", "threshold_mean")
WIDTHS = ("width", "width_low", "width_high")


def single_fits(study: StudyCounts, shape: str, known: Known) -> SingleFits:
    """Fit the cells that are not in `known`, as `cells.estimates` does."""
    if study.shape.on_log_levels:  # a Weibull function is a Gumbel function of logarithms
        shape, known = "gumbel", {}
    n, c = study.n_participants, study.n_conditions
    by_condition = [np.moveaxis(rows, 1, 0) for rows in (study.u, study.n_yes, study.n_trials)]
    alarms, catch = np.swapaxes(study.own_catch, 1, 2)
    of_cells = [rows.reshape(n * c, -1) for rows in by_condition]
    of_conditions = [rows.reshape(c, -1) for rows in by_condition]
    conditions = study.conditions.itertuples(index=False, name=None)
    taken = [known.get((who, condition)) for condition in conditions for who in study.participants]
    left = np.array([one is None for one in taken])
    fitted = iter(_fits(study, shape, [rows[left] for rows in of_cells], alarms.ravel()[left], catch.ravel()[left]))
    fits = tuple(next(fitted) if one is None else _on_scale(one, study) for one in taken)
    cells = tuple(fits[i * n : (i + 1) * n] for i in range(c))
    together = _fits(study, shape, of_conditions, alarms.sum(axis=1), catch.sum(axis=1))
    return SingleFits(study, cells, together)


def _on_scale(one: ThresholdFit, study: StudyCounts) -> ThresholdFit:
    moved: dict[str, Any] = {}
    for name in (*PLACES, *WIDTHS):
        value = getattr(one, name)
        if value is not None:
            moved[name] = (value - study.centre * (name in PLACES)) / study.spread
    return replace(one, **moved)


def _fits(study: StudyCounts, shape: str, counts: list[Array], alarms: Array, catch: Array) -> tuple[ThresholdFit, ...]:
    if not len(counts[0]):
        return ()
    return fit_many(
        *counts,
        shape=shape,
        guess_rate=study.guess_rate,
        lapse_rate=study.lapse_rate,
        scale_free_width=study.scale_free_width,
        lapse_beta=study.lapse_beta,
        guess_beta=study.guess_beta,
        n_false_alarms=alarms,
        n_catch=catch,
    )


CONDITION_COLUMNS = (
    *("threshold", "standard_error", "interval_low", "interval_high"),
    *("width", "width_low", "width_high", "status"),
)
CENSORED = (Status.BELOW, Status.ABOVE)
FEWEST_DRAWS = 100.0
"""With fewer effective draws of a participant, the mixture of normals is used instead."""
MOST_EFFECTS = 40
"""Largest number of effects per participant for which draws fit in memory."""
N_DRAWS = 1024
SEED = 1
WIDENED = 1.15
"""Factor that widens the standard deviation of the draws, to bound their weights."""
WITHOUT_NUMBER = (*CENSORED, Status.FLAT, Status.NO_DATA)


@dataclass(frozen=True)
class ParameterPlace(Rows):
    """Thresholds (scaled as in the study) and log widths with uncertainty.

    `mean` and `se` have the shape (n_conditions, ..., 2); `ends` of intervals have one more axis. All are NaN for a
    condition without a threshold.
    """

    mean: Array
    se: Array
    ends: Array

    @classmethod
    def unknown(cls, *size: int) -> "ParameterPlace":
        both = np.full((*size, 2), np.nan)
        return cls(both, both, np.full((*size, 2, 2), np.nan))

    @classmethod
    def of(cls, found: Integrated, values: Array, variances: Array, interval: float) -> "ParameterPlace":
        """Summarise values (n_points, n_conditions, ..., 2) over all points."""
        mean = found.mean(values)
        se = np.sqrt(found.mean(variances + np.square(values - mean)))
        ends = [quantiles(found.weights, values, np.sqrt(variances), share) for share in _tails(interval)]
        return cls(mean, se, np.stack(ends, axis=-1))

    def turned(self) -> "ParameterPlace":
        """Swap the first two axes."""
        return self._of_each(lambda values: np.swapaxes(values, 0, 1))

    def by_participant(self) -> "ParameterPlace":
        """Return one row per cell, ordered by participant."""
        return self.turned()._of_each(lambda values: values.reshape(-1, *values.shape[2:]))


def _tails(interval: float) -> tuple[float, float]:
    return (1 - interval) / 2, (1 + interval) / 2


@dataclass(frozen=True)
class CellDraws:
    """Weighted draws of predictors and lapse rates.

    Predictors `points` have the shape (n, n_participants, n_conditions, 2), lapse rates and weights (n,
    n_participants). The weights of each participant sum to 1 over the draws.
    """

    points: Array
    lapse_rates: Array
    weights: Array

    @property
    def n_effective(self) -> Array:
        return np.asarray(1 / np.square(self.weights).sum(axis=0))


def draw_cells(model: GroupModel, found: Integrated, n_draws: int = N_DRAWS) -> CellDraws:
    """Draw predictors of the cells at hyperparameters sampled by weight."""
    rng = np.random.default_rng(SEED)
    steps = (np.arange(n_draws) + 0.5) / n_draws
    chosen = np.minimum(np.searchsorted(np.cumsum(found.weights), steps), len(found.weights) - 1)
    places, of_draw = np.unique(chosen, return_inverse=True)
    at = found.at[places]
    precision = model.precision(at.hyper)[0]
    inner = inner_at(model, at.hyper, precision, at.means, at.effects)
    hessian = bordered(model, model.information(inner.points, at.hyper), precision)
    root = WIDENED * np.linalg.cholesky(np.linalg.inv(hessian.local))[of_draw]
    normals = rng.standard_normal((n_draws, *at.effects.shape[1:]))
    away = (np.linalg.cholesky(at.covariance)[of_draw] @ rng.standard_normal((n_draws, at.means.shape[1], 1)))[..., 0]
    followed = np.einsum("niqp,np->niq", hessian.pulled[of_draw], away)  # the mode of the effects depends on the means
    effects = at.effects[of_draw] - followed + np.einsum("niqr,nir->niq", root, normals)
    hyper, priors = at.hyper[of_draw], precision[of_draw]
    drawn = inner_at(model, hyper, priors, at.means[of_draw] + away, effects)
    # The weight of a point already includes Laplace's density of the participant's answers at the drawn means.
    score = np.einsum("cdp,nicd->nip", model.fixed, inner.at.gradient)[of_draw]
    bent = np.einsum("np,nipr,nr->ni", away, hessian.own[of_draw], away, optimize=True)
    before = _log_density(inner, precision)[of_draw] + np.einsum("nip,np->ni", score, away) - 0.5 * bent
    log_weights = _log_density(drawn, priors) + 0.5 * np.square(normals).sum(axis=2) - before
    weights = np.exp(log_weights - log_weights.max(axis=0))
    return CellDraws(drawn.points[..., :2], model.lapses(hyper, effects), weights / weights.sum(axis=0))


def _log_density(inner: InnerMode, precision: Array) -> Array:
    """Return the log density of each participant's answers and effects."""
    bound = np.einsum("niq,nqr,nir->ni", inner.effects, precision, inner.effects, optimize=True)
    return np.asarray(inner.at.value.sum(axis=2) - 0.5 * bound)


def group_place(model: GroupModel, found: Integrated, interval: float) -> ParameterPlace:
    """Return the mean thresholds and widths of the conditions."""
    c, n_free = model.study.n_conditions, found.at.means.shape[1]
    every = model.every_mean(found.at.hyper, found.at.means)
    variances = np.zeros(every.shape)
    variances[:, :n_free] = np.diagonal(found.at.covariance, axis1=1, axis2=2)
    places = np.stack([np.arange(c), c + model.study.width_group], axis=-1)
    return ParameterPlace.of(found, every[:, places], variances[:, places], interval)


def cell_place(model: GroupModel, found: Integrated, interval: float) -> tuple[ParameterPlace, Array]:
    """Return the shrunken estimates and the lapse rates of the cells."""
    normal = ParameterPlace.of(found, found.at.cells, found.at.variances, interval)
    rates = found.mean(model.lapses(found.at.hyper, found.at.effects))
    if not 0 < model.random.shape[2] <= MOST_EFFECTS:
        return normal.turned(), rates
    draws = draw_cells(model, found)
    is_known = draws.n_effective >= FEWEST_DRAWS
    rates = np.where(is_known, (draws.weights * draws.lapse_rates).sum(axis=0), rates)
    weights = np.broadcast_to(draws.weights[..., None, None], draws.points.shape)
    mean = (weights * draws.points).sum(axis=0)
    se = np.sqrt((weights * np.square(draws.points - mean)).sum(axis=0))
    ends = np.quantile(draws.points, _tails(interval), axis=0, weights=weights, method="inverted_cdf")
    return ParameterPlace(mean, se, np.moveaxis(ends, 0, -1)).where(is_known, normal).turned(), rates


def condition_table(single: SingleFits, place: ParameterPlace) -> pd.DataFrame:
    """Return the table of condition means."""
    study = single.study
    low, high, _ = study.ranges()
    means = zip(single.statuses(), place.mean[:, 0], low, high, strict=True)
    table = _table(study, place, [_status_of_mean(*one) for one in means])
    if single.separated:
        widest = np.where(table["width"].isna(), np.nan, study.spread * single.width_bounds())
        table = table.assign(width=np.nan, width_low=np.nan, width_high=widest)
    return pd.concat([study.conditions, table], axis=1)


def participant_table(single: SingleFits, place: ParameterPlace, lapse_rates: Array | None) -> pd.DataFrame:
    """Return the table of participants by condition."""
    study, rows = single.study, place.by_participant()
    status = np.array([cell[p].status for p in range(study.n_participants) for cell in single.cells], dtype=object)
    # Shrinkage provides a width even for cells whose answers change in one step.
    status[(status == Status.SEPARATED) & ~np.isnan(rows.mean[:, 0])] = Status.OK
    # A cell without a threshold keeps its status and bound.
    is_censored = np.isin(status, CENSORED)
    rows.ends[is_censored, 0] = single.cell_bounds().swapaxes(0, 1).reshape(-1, 2)[is_censored]
    table = _table(study, rows, status.tolist())
    conditions = np.tile(np.arange(study.n_conditions), study.n_participants)
    keys = study.conditions.loc[conditions].reset_index(drop=True)
    keys.insert(0, "participant", np.repeat(study.participants, study.n_conditions))
    lapses = np.nan if lapse_rates is None else np.repeat(lapse_rates, study.n_conditions)
    n_trials = study.n_trials.sum(axis=2).ravel().astype(int)
    return pd.concat([keys, table.assign(n_trials=n_trials, lapse_rate=lapses)], axis=1)


def _status_of_mean(status: Status, threshold: float, low: float, high: float) -> Status:
    if np.isnan(threshold):
        return status
    if threshold < low:
        return Status.BELOW
    return Status.ABOVE if threshold > high else status


def _table(study: StudyCounts, place: ParameterPlace, status: list[Status]) -> pd.DataFrame:
    threshold, log_width = np.concatenate([place.mean[..., None], place.ends], axis=-1).swapaxes(0, 1)
    has_number = np.array([one not in WITHOUT_NUMBER for one in status]) & ~np.isnan(threshold[:, 0])
    # The bound is the lower end for a threshold above the levels, the upper end for one below.
    has_low = has_number | np.array([one == Status.ABOVE for one in status])
    has_high = has_number | np.array([one == Status.BELOW for one in status])
    with np.errstate(over="ignore"):
        width, narrow, wide = study.spread * np.exp(log_width.T)
    level, low, high = study.level(threshold.T)
    columns = {
        "threshold": (level, has_number),
        "standard_error": (study.spread * place.se[:, 0], has_number),
        "interval_low": (low, has_low),
        "interval_high": (high, has_high),
        "width": (width, has_number),
        "width_low": (narrow, has_number),
        "width_high": (wide, has_number & np.isfinite(wide)),
    }
    known = {name: np.where(is_known, values, np.nan) for name, (values, is_known) in columns.items()}
    return pd.DataFrame(known | {"status": [one.value for one in status]})
