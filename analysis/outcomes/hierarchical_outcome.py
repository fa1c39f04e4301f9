"""Hierarchical fit of all participants of a task, as part of an analysis."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from types import MappingProxyType
from typing import Any

import numpy as np
import pandas as pd

from tactometry.errors import InvalidParameter

from ..hierarchical.fitting import FactorEffect, GroupStatus, HierarchicalFit, fit_hierarchical
from ..hierarchical.tables import Known
from ..tasks.cell import Cell
from ..tasks.cells import count_table
from ..tasks.kinds import CURVES
from ..tasks.task_analysis import DIFFERENCE_PER_WIDTH, SHAPE
from ..threshold.fitting import ThresholdFit
from ..threshold.status import Status
from ..wording import condition_name, interval_text, number_text

MOST_CELLS = 500
"""Largest number of cells fitted for a report, as more take too long; `fit_hierarchical` has no limit."""
ALL = "condition"
WITHOUT_LAPSES = {"shape": SHAPE, "guess_rate": 0.0, "lapse_rate": 0.0, "scale_free_width": False}
"""Comparisons use the published probit model (Moscatelli, Mezzetti and Lacquaniti 2012), without lapses."""
OTHER_MODEL = (
    "no test of effects: this model of comparisons has asymptotes of 0 and 1, while the fits of single participants "
    "have free asymptotes. Points of equality and just noticeable differences differ if a level is sometimes not felt"
)


@dataclass(frozen=True)
class HierarchicalOutcome:
    """Hierarchical fit of a task; without a fit, `note` is the reason."""

    task: str
    fit: HierarchicalFit | None
    note: str
    conditions: pd.DataFrame
    participants: pd.DataFrame
    effects: Mapping[str, FactorEffect] = field(default_factory=dict)

    def tables(self, name: str) -> dict[str, pd.DataFrame]:
        """Return all tables by file name."""
        by_file = {f"hierarchical_{name}": self.conditions, f"hierarchical_{name}_participants": self.participants}
        return {key: table for key, table in by_file.items() if len(table)}


def group_fit(
    cells: Sequence[Cell],
    factors: Sequence[str],
    unit: str,
    fits: Mapping[Cell, ThresholdFit] = MappingProxyType({}),
) -> HierarchicalOutcome | None:
    """Fit the cells of one task jointly; None for fewer than two participants.

    Existing `fits` of the same curve are reused.
    """
    task = cells[0].task
    if len({cell.participant for cell in cells}) < 2:
        return None
    if len(cells) > MOST_CELLS:
        return _no_outcome(task, f"{len(cells)} cells, a report fits at most {MOST_CELLS} (use fit_hierarchical)")
    n_choices = cells[0].n_choices
    if any(cell.n_choices != n_choices for cell in cells):
        return _no_outcome(task, "conditions differ in the number of alternatives, but the model has one guess rate")
    varied = [name for place, name in enumerate(factors) if len({cell.condition[place] for cell in cells}) > 1]
    table = count_table(cells, factors)
    if table.empty:
        return _no_outcome(task, "no trial has a level")
    n_levels = [len(cell.levels) for cell in cells]
    # The fit requires a factor: if none varies, all cells share one condition.
    conditions = {name: table[name].tolist() for name in varied} or {ALL: ["all"] * len(table)}
    places = [factors.index(name) for name in varied]
    conditions_of = {cell: tuple(cell.condition[place] for place in places) or ("all",) for cell in fits}
    known: Known = {(cell.participant, conditions_of[cell]): fit for cell, fit in fits.items()}
    curve = CURVES[task]
    options = WITHOUT_LAPSES if curve.has_difference else curve.options(n_choices, unit)
    fit = fit_hierarchical(
        table["level"],
        table["n_yes"],
        table["n_trials"],
        table["participant"].tolist(),
        conditions,
        n_false_alarms=np.repeat([cell.n_false_alarms for cell in cells], n_levels),
        n_catch=np.repeat([cell.n_catch for cell in cells], n_levels),
        width_by=varied if curve.has_difference else (),
        known={} if curve.has_difference else known,
        **options,
    )
    return _outcome(task, fit, varied, table)


def _no_outcome(task: str, why: str) -> HierarchicalOutcome:
    return HierarchicalOutcome(task, None, f"no hierarchical fit: {why}", pd.DataFrame(), pd.DataFrame())


def _outcome(task: str, fit: HierarchicalFit, varied: Sequence[str], table: pd.DataFrame) -> HierarchicalOutcome:
    if fit.status is not GroupStatus.OK:
        return _no_outcome(task, fit.note)
    if CURVES[task].has_difference:
        conditions, participants = map(_with_difference, (fit.conditions, fit.participants))
        effects, notes = dict[str, FactorEffect](), OTHER_MODEL
    else:
        conditions, participants = fit.conditions, fit.participants
        effects, notes = _effects(fit, varied, table)
    conditions = conditions.assign(text=[_text(row) for _, row in conditions.iterrows()])
    note = "; ".join(filter(None, (fit.note, notes)))
    return HierarchicalOutcome(task, fit, note, conditions, participants, effects)


def _with_difference(table: pd.DataFrame) -> pd.DataFrame:
    """Add the just noticeable difference, a fixed fraction of the width."""
    names = {"jnd": "width", "jnd_low": "width_low", "jnd_high": "width_high"}
    return table.assign(**{ours: table[width] * DIFFERENCE_PER_WIDTH for ours, width in names.items()})


def _effects(fit: HierarchicalFit, varied: Sequence[str], table: pd.DataFrame) -> tuple[dict[str, FactorEffect], str]:
    """Return effects within participants, or the reason for none."""
    between = [name for name in varied if table.groupby("participant")[name].nunique().max() < 2]
    if between:
        return {}, f"no test of effects: {', '.join(between)} does not vary within participants"
    lost = fit.conditions[fit.conditions["threshold"].isna()]
    if varied and len(lost):
        names = [condition_name(varied, values) for values in lost[list(varied)].itertuples(index=False, name=None)]
        return {}, f"no test of effects: no mean threshold of {'; '.join(names)}"
    factors_of = [factors for r in range(1, len(varied) + 1) for factors in combinations(varied, r)]
    try:
        return {" * ".join(factors): fit.effect(*factors) for factors in factors_of}, ""
    except InvalidParameter:
        return {}, "no test of effects: the conditions do not form a complete factorial"


def _text(row: "pd.Series[Any]") -> str:
    """Format the threshold with its interval, or as a bound."""
    low, high = row["interval_low"], row["interval_high"]
    if pd.notna(row["threshold"]):
        return interval_text(row["threshold"], low, high)
    if pd.notna(high):
        return f"< {number_text(high)}"
    if pd.notna(low):
        return f"> {number_text(low)}"
    return {Status.BELOW: "all below the levels", Status.ABOVE: "all above the levels"}.get(row["status"], "none")
