"""The answers of a study: rows of counts laid out as cells of participants by conditions."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tactometry.psychometric import Shape

from ..arrays import Array, Indices, lay_out
from ..threshold.counts import POOLED_BELOW, normalise
from ..threshold.prior import BETA_B


@dataclass(frozen=True)
class StudyCounts:
    """Counts of all cells, on levels u = (level - centre) / spread of the whole study.

    `u`, `n_yes`, `n_trials` have the shape (n_participants, n_conditions, n_levels), 0 trials where there are none;
    `own_catch` (2, n_participants, n_conditions) are false alarms and catch trials of each cell, `n_false_alarms` and
    `n_catch` of all. `lapse_beta`, `guess_beta` and `scale_free_width` are those of `threshold.fit`. `conditions` has a
    row for each, `width_group` (n_conditions,) says which of them share a mean width.
    """

    participants: tuple[str, ...]
    conditions: pd.DataFrame
    width_group: Indices
    u: Array
    n_yes: Array
    n_trials: Array
    own_catch: Array
    centre: float
    spread: float
    shape: Shape
    guess_rate: float | None
    lapse_rate: float | None
    n_false_alarms: float = 0
    n_catch: float = 0
    lapse_beta: float = BETA_B
    guess_beta: float = BETA_B
    scale_free_width: bool = True

    @classmethod
    def of(
        cls,
        names: NDArray[np.str_],
        factors: Mapping[str, NDArray[np.generic]],
        width_by: Sequence[str],
        answers: tuple[Array, Array, Array],
        own_catch: Array | None = None,
        **known: Any,
    ) -> "StudyCounts":
        """From rows of a level each; `own_catch` are the false alarms and catch trials (2, n_rows) of their cells."""
        keys = pd.DataFrame(dict(factors))
        conditions = keys.drop_duplicates().sort_values(list(factors)).reset_index(drop=True)
        both = conditions.reset_index().merge(keys.reset_index(), on=list(factors))
        place = both.sort_values("index_y")["index_x"]  # of each row's condition, in the order of the rows again
        who, participant = np.unique(names, return_inverse=True)
        cell = participant * len(conditions) + place.to_numpy()
        n_cells = len(who) * len(conditions)
        levels, n_yes, n_trials = answers
        centre, spread = _scale(levels)
        columns = _counts_of_cells(cell, n_cells, ((levels - centre) / spread, n_yes, n_trials))
        u, k, n = (rows.reshape(len(who), len(conditions), -1) for rows in columns)
        group = conditions.groupby(list(width_by), sort=True).ngroup() if width_by else np.zeros(len(conditions))
        catch = np.zeros((2, n_cells))
        if own_catch is not None:
            catch[:, cell] = own_catch
            known |= dict(zip(("n_false_alarms", "n_catch"), catch.sum(axis=1), strict=True))
        by_cell, width_group = catch.reshape(2, *u.shape[:2]), np.asarray(group, dtype=np.int64)
        return cls(tuple(map(str, who)), conditions, width_group, u, k, n, by_cell, centre, spread, **known)

    @property
    def n_participants(self) -> int:
        return int(self.u.shape[0])

    @property
    def n_conditions(self) -> int:
        return int(self.u.shape[1])

    @property
    def n_groups(self) -> int:
        return int(self.width_group.max()) + 1

    def level(self, u: Array) -> Array:
        """In the unit of the levels."""
        with np.errstate(over="ignore"):
            level = self.centre + self.spread * u
            return np.asarray(np.exp(level) if self.shape.on_log_levels else level)

    def only(self, chosen: Indices) -> "StudyCounts":
        """Of some conditions."""
        u, k, n = (counts[:, chosen] for counts in (self.u, self.n_yes, self.n_trials))
        group = np.unique(self.width_group[chosen], return_inverse=True)[1].astype(np.int64)
        conditions, catch = self.conditions.iloc[chosen], self.own_catch[..., chosen]
        return replace(self, u=u, n_yes=k, n_trials=n, own_catch=catch, width_group=group, conditions=conditions)

    def ranges(self) -> tuple[Array, Array, Array]:
        """Lowest and highest level and smallest spacing of each condition (n_conditions,)."""
        used = self.n_trials > 0
        low = np.where(used, self.u, np.inf).min(axis=(0, 2))
        high = np.where(used, self.u, -np.inf).max(axis=(0, 2))
        gaps = [_gap(self.u[:, c][used[:, c]], high[c] - low[c]) for c in range(self.n_conditions)]
        return low, high, np.array(gaps)


def _scale(x: Array) -> tuple[float, float]:
    low, high = float(x.min()), float(x.max())
    return low + (high - low) / 2, (high - low) or 1.0


def _counts_of_cells(cell: Indices, n_cells: int, columns: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
    """Rows as (n_cells, n_rows of the largest cell), equal levels of a cell pooled."""
    counts = normalise(*lay_out(cell, *columns, n_clusters=n_cells))
    # Back from each cell's own scale to that of the study, which the means of conditions need.
    u = counts.centre[:, None] + counts.spread[:, None] * counts.u
    u = np.where(counts.n_trials > 0, u, 0.0)
    return u, counts.n_yes, counts.n_trials


def _gap(levels: Array, reach: float) -> float:
    gaps = [upper - lower for lower, upper in pairwise(np.unique(levels))]
    wide = [gap for gap in gaps if gap > POOLED_BELOW * reach]
    return float(min(wide, default=reach or 1.0))
