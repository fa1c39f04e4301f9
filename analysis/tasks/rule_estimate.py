"""Tracks of the procedure, and its own threshold estimate."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from statistics import fmean, stdev
from typing import Any

import numpy as np
import pandas as pd

from tactometry.trials.tasks import EASY

from ..reading.rows import COUNTED
from .cell import Estimate

RUN = ("session", "study", "block")
"""Columns that identify a block, together with the participant."""
DISCARDED = 2
"""Number of initial reversals that are discarded (Levitt 1971)."""
FIXED = ("constant", "constant_stimuli", COUNTED, EASY)
"""Procedures whose levels do not depend on the answers."""


@dataclass(frozen=True)
class RuleEstimate:
    """Estimate of one run, with SD and number of reversals or answers."""

    estimate: float | None = None
    sd: float | None = None
    n: int | None = None
    note: str = ""


Replay = Callable[[pd.DataFrame], Mapping[str, RuleEstimate]]
"""Function that maps the trials of a block (in order, with `yes` and level `x`) to the estimate of each track."""


def rule_columns(
    answers: pd.DataFrame, factors: Sequence[str], estimates: Sequence[Estimate], replay: Replay | None = None
) -> pd.DataFrame:
    """Return one row per cell with the estimate, averaged over its runs."""
    runs = _runs(answers[~answers["is_catch"]], factors, replay)
    keys = ((one.cell.participant, *one.cell.condition, one.cell.task) for one in estimates)
    return pd.DataFrame([_mean_estimate(runs.get(key, [])) for key in keys]).add_prefix("rule_")


def _runs(
    rows: pd.DataFrame, factors: Sequence[str], replay: Replay | None
) -> dict[tuple[object, ...], list[RuleEstimate]]:
    unsaid = {name: rows[name].fillna(0) for name in RUN if name in rows.columns}
    rows = rows.assign(track=rows["track"].fillna("") if "track" in rows.columns else "", **unsaid)
    of_block = ["participant", *(name for name in RUN if name in rows.columns)]
    # Replay whole blocks, as tracks of a block may share answers.
    replayed = {} if replay is None else {key: replay(block) for key, block in _groups(rows, of_block)}
    runs: dict[tuple[object, ...], list[RuleEstimate]] = {}
    for key, run in _groups(rows, [*of_block, "track", *factors, "task"]):
        block, (track, *condition) = key[: len(of_block)], key[len(of_block) :]
        by_replay = None if replay is None else replayed[block].get(str(track))
        runs.setdefault((block[0], *condition), []).append(from_rows(run) if by_replay is None else by_replay)
    return runs


def _groups(rows: pd.DataFrame, keys: Sequence[str]) -> Iterable[tuple[tuple[Any, ...], pd.DataFrame]]:
    return rows.groupby(list(keys), sort=True, observed=True, dropna=False)


def _mean_estimate(runs: Sequence[RuleEstimate]) -> RuleEstimate:
    known = [(run.estimate, run.sd, run.n or 0) for run in runs if run.estimate is not None]
    notes = "; ".join(dict.fromkeys(run.note for run in runs)) or "no trials"
    if not known:
        return RuleEstimate(note=notes)
    estimates, sds, n = zip(*known, strict=True)
    several = f"mean of {len(known)} of {len(runs)} runs: " if len(runs) > 1 else ""
    spreads = [sd for sd in sds if sd is not None]
    return RuleEstimate(fmean(estimates), fmean(spreads) if spreads else None, sum(n), several + notes)


def from_rows(run: pd.DataFrame) -> RuleEstimate:
    """Estimate from the levels of a run, as the mean of reversals."""
    run = run[run["procedure"] != EASY] if "procedure" in run.columns else run
    names = set(run["procedure"]) if "procedure" in run.columns else set()
    name = str(next(iter(names))) if len(names) == 1 else ""
    if not name:
        return RuleEstimate(note="no estimate: the table does not name the procedure")
    if name in FIXED:
        return RuleEstimate(note=f"no estimate: the levels of {name} do not depend on the answers")
    if "stair" not in name.lower():
        return RuleEstimate(
            note=f"no estimate: without study.toml next to the table, the parameters of {name} are unknown"
        )
    return of_reversals(reversals(run["x"].tolist()), "in the levels")


def reversals(levels: Sequence[float]) -> list[float]:
    """Return the levels at which a track changes direction."""
    # Skip repeated levels: a reversal is a change of direction between two moves.
    moves = [(level, np.sign(then - level)) for level, then in pairwise(levels) if then != level]
    return [level for (_, old_sign), (level, sign) in pairwise(moves) if old_sign != sign]


def of_reversals(turns: Sequence[float], where: str) -> RuleEstimate:
    """Return the mean of an even number of late reversals."""
    kept = turns[DISCARDED + (len(turns) - DISCARDED) % 2 :]  # equal numbers of peaks and valleys
    if len(kept) < 2:
        return RuleEstimate(note=f"too few reversals: {len(turns)} {where}")
    return RuleEstimate(fmean(kept), stdev(kept), len(kept), f"mean of reversals {where}")


def tracks(judged: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Return the trials of adaptive tracks, numbered by `step` from 1."""
    if "procedure" not in judged.columns:
        return pd.DataFrame()
    rows = judged[~judged["procedure"].isin(FIXED) & ~judged["is_catch"]]
    within = [name for name in ("session", "track") if name in rows.columns and name not in factors]
    keys = ["participant", *factors, *within]
    steps = rows[[*keys, "task", "procedure", "level", "yes"]].reset_index(drop=True)
    return steps.assign(step=steps.groupby(keys, observed=True, dropna=False).cumcount() + 1)
