"""Trials tables of participants whose psychometric functions are known."""

from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path

import numpy as np

from tactometry.psychometric import PsychometricFunction

COLUMNS = (
    "procedure,level,level_unit,task,response,correct,onset_s,latency_s,force_mean_n,force_sd_n,force_in_band,valid,"
    "timestamp_utc,catch,target"
)


def rows_of_a_cell(
    f: PsychometricFunction, levels: Sequence[float], n: int, n_catch: int, task: str, rng: np.random.Generator
) -> list[str]:
    """Return constant stimuli in random order as rows from `procedure` on."""
    shown: list[float | None] = [*np.repeat(levels, n).tolist(), *[None] * n_catch]
    rows = []
    for i in rng.permutation(len(shown)):
        level = shown[i]
        chance = f.guess_rate if level is None else f.probability(level)
        yes, target = int(rng.random() < chance), int(rng.integers(1, 3))
        response = yes if task != "forced_choice" else (target if yes else 3 - target)
        asked = "" if level is None else f"{level:g}"
        tail = f"{int(level is None)},{target if task == 'forced_choice' else ''}"
        rows.append(f"constant_stimuli,{asked},dB re 1 V,{task},{response},{yes},,,,,,1,,{tail}")
    return rows


def write_study(
    path: Path,
    thresholds: Mapping[tuple[str, tuple[float, ...]], float],
    factors: Sequence[str],
    *,
    rng: np.random.Generator,
    levels: Sequence[float] = tuple(range(6, 39, 4)),
    n: int = 12,
    n_catch: int = 20,
    task: str = "yes_no",
    width: float = 8.0,
    false_alarm_rate: float = 0.05,
) -> Path:
    """Write a CSV file with all participants and conditions."""
    guess = {"yes_no": false_alarm_rate, "forced_choice": 0.5, "comparison": 0.0}[task]
    lapse = 0.0 if task == "comparison" else 0.02
    lines = [f"participant,session,study,block,trial,{','.join(factors)},{COLUMNS}"]
    for (participant, condition), threshold in thresholds.items():
        f = PsychometricFunction("normal", threshold, width, guess, lapse)
        catch = n_catch if task == "yes_no" else 0
        for number, row in enumerate(rows_of_a_cell(f, levels, n, catch, task, rng), start=1):
            lines.append(f"{participant},1,made-up,1,{number},{','.join(f'{v:g}' for v in condition)},{row}")
    path.write_text("\n".join(lines) + "\n")
    return path


def grid_of_thresholds(
    n_participants: int, conditions: Mapping[tuple[float, ...], float], sd: float, rng: np.random.Generator
) -> dict[tuple[str, tuple[float, ...]], float]:
    """Return condition means, shifted by participant and slightly by cell."""
    shift = rng.normal(0, sd, n_participants)
    return {
        (f"P{i + 1:02d}", condition): mean + shift[i] + rng.normal(0, 0.3)
        for i, (condition, mean) in product(range(n_participants), conditions.items())
    }
