"""Estimates of a study's procedures, replayed from recorded answers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from tactometry.analysis.tasks.rule_estimate import Replay, RuleEstimate
from tactometry.errors import InvalidParameter, TactometryError
from tactometry.files.durable import read_file
from tactometry.protocols.procedures.easy import EasyTrials
from tactometry.protocols.procedures.procedure import Procedure, after_answer
from tactometry.trials.cells import cell
from tactometry.trials.tasks import EASY

from ..study.cells import Wiring, tables
from ..study.procedure_table import ReadyProcedure
from ..study.study_file import parse


def replay_of(path: Path) -> Replay | None:
    """Return a function that replays blocks, or None without a readable study."""
    study = (path if path.is_dir() else path.parent.parent) / "study.toml"
    if not study.is_file():
        return None
    try:
        return _Replay(Wiring(parse(read_file(study, "the study that ran"), str(study))))
    except TactometryError:
        return None


@dataclass(frozen=True)
class _Replay:
    """Procedures of a study. Parts shared by blocks are built once."""

    wiring: Wiring

    def __call__(self, block: pd.DataFrame) -> Mapping[str, RuleEstimate]:
        names = [str(name) for name in dict.fromkeys(block["track"])]
        ready = self._rule(block)
        if ready is None:
            return dict.fromkeys(names, RuleEstimate(note="these are not trials of the study.toml next to the table"))
        if ready.rule.unreplayed:
            return dict.fromkeys(names, RuleEstimate(note=ready.rule.unreplayed))
        try:
            procedures = _procedures_after(ready, block, names)
        except InvalidParameter as refusal:
            return dict.fromkeys(
                names, RuleEstimate(note=f"the procedure of study.toml rejects these answers ({refusal})")
            )
        estimates = (procedure.estimate for procedure in procedures)
        return {name: RuleEstimate(of.level, of.sd, of.n, of.note) for name, of in zip(names, estimates, strict=True)}

    def _rule(self, block: pd.DataFrame) -> ReadyProcedure | None:
        """Return the procedure of a block's first cell, or None if unknown."""
        study, first = self.wiring.study, block.iloc[0]
        factors: dict[str, float | str] = {}
        for name, levels in study.factors.items():
            known = [level for level in levels if name in first and cell(level) == _text(first[name])]
            if not known:
                return None
            factors[name] = known[0]
        ready = self.wiring.procedure(tables(study, factors)["procedure"])
        return ready if set(block["procedure"]) - {EASY} == {ready.rule.name} else None


def _text(value: Any) -> str:
    return value if isinstance(value, str) else cell(float(value))


def _procedures_after(ready: ReadyProcedure, block: pd.DataFrame, names: list[str]) -> Sequence[Procedure]:
    alone = replace(ready, tracks=replace(ready.tracks, easy_share=0.0, easy_level=None))
    procedures = alone.for_tracks(
        names, np.random.default_rng(0)
    )  # procedures that draw a random order are not replayed
    procedures = tuple(
        _with_easy(each, block[block["track"] == name]) for each, name in zip(procedures, names, strict=True)
    )
    for track, yes, level in zip(block["track"], block["yes"], block["x"], strict=True):
        procedures = after_answer(procedures, names.index(str(track)), int(yes), float(level))
    return procedures


def _with_easy(procedure: Procedure, rows: pd.DataFrame) -> Procedure:
    """Add the easy trials of the table to the procedure of a track."""
    places = np.flatnonzero(rows["procedure"] == EASY)
    return EasyTrials(procedure, np.nan, frozenset(places.tolist())) if len(places) else procedure
