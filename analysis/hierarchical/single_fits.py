"""Fits of single cells and of pooled conditions, used as start values."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..arrays import Array, Indices
from ..threshold.fitting import ThresholdFit, fit_many
from ..threshold.status import Status
from .model import StudyCounts

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
