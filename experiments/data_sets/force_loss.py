"""Results of the study `force-loss`, for figures 5.4 and 5.5."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from tactometry.analysis.reading.trials import read_trials, used_rows
from tactometry.analysis.tasks.measurement import TASK, loss_table
from tactometry.errors import InvalidFile
from tactometry.stimuli.time_reversal.finger import FINGER_DIAMETER_M, LossRow

from ..study.study_file import load

FACTORS: Final = ("contactor", "place", "force_n")


def measured_losses(path: Path) -> list[LossRow]:
    """Return the mean loss of each condition of the study `force-loss`.

    `figures.prototype.loss_over_force(model, measured)` plots them. The study file states kind and diameter of each
    contactor.

    Raises `InvalidFile` if the data set has other factors or no readings.
    """
    trials = read_trials(path)
    if set(trials.factors) != set(FACTORS):
        raise InvalidFile(f"{path}: found the factors {', '.join(trials.factors)}, expected {', '.join(FACTORS)}")
    used = used_rows(trials)
    losses = loss_table(used[used["task"] == TASK], FACTORS)
    if losses.empty:
        raise InvalidFile(f"{path}: found no measured level, expected readings of the study force-loss")
    variants = load(str(path / "study.toml"))[0].variants["contactor"]
    rows = losses.to_dict("records")
    return [LossRow(*_contactor(variants, row), row["place"], row["force_n"], row["mean"]) for row in rows]


def _contactor(variants: Mapping[str, Mapping[str, Any]], row: Mapping[Any, Any]) -> tuple[str, float]:
    sensation = variants[row["contactor"]]["sensation"]
    return sensation["contactor"], sensation.get("diameter_m", FINGER_DIAMETER_M)
