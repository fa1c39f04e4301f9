"""Checks of group tests and intervals, starting from simulated answers."""

import math
from collections.abc import Mapping
from contextlib import suppress
from functools import partial
from typing import Any, Final

import numpy as np
import pandas as pd

from tactometry.analysis.anova.post_hoc import pairs
from tactometry.analysis.hierarchical.fitting import fit_hierarchical
from tactometry.analysis.hierarchical.result import HierarchicalFit
from tactometry.analysis.outcomes.outcome import outcome
from tactometry.analysis.tasks.cell import Cell
from tactometry.analysis.tasks.cells import estimate_table, estimates
from tactometry.errors import InvalidParameter
from tactometry.psychometric import PsychometricFunction

from ..check import NO_ANSWER, Estimate, Simulate

N_PARTICIPANTS, N_CONDITIONS, N_TRIALS = 10, 3, 14
LEVELS: Final = np.linspace(8.0, 32.0, 7)
MEAN_DB, PARTICIPANT_SD_DB, WIDTH_DB, WIDTH_LOG_SD, LAPSE_RATE = 20.0, 2.5, 8.0, 0.2, 0.02
EFFECT_DB: Final = 1.5
CELL_SDS_DB: Final = (0.0, 1.0)
GUESS_RATE: Final = 0.5
FACTOR: Final = "condition"
FIRST, LAST = 0.0, float(N_CONDITIONS - 1)


def study(cell_sd_db: float, effect_db: float, rng: np.random.Generator) -> list[Cell]:
    """Simulate a study whose thresholds rise in equal steps over conditions."""
    people = MEAN_DB + PARTICIPANT_SD_DB * rng.standard_normal((N_PARTICIPANTS, 1))
    own = cell_sd_db * rng.standard_normal((N_PARTICIPANTS, N_CONDITIONS))
    at = people + own + effect_db * (np.arange(N_CONDITIONS) / LAST - 0.5)
    widths = WIDTH_DB * np.exp(WIDTH_LOG_SD * rng.standard_normal(N_PARTICIPANTS))
    functions = [
        [PsychometricFunction("normal", place, width, GUESS_RATE, LAPSE_RATE) for place in own_places]
        for own_places, width in zip(at, widths, strict=True)
    ]
    n_correct = rng.binomial(N_TRIALS, [[each.probability(LEVELS) for each in person] for person in functions])
    return [
        Cell(
            f"P{person:02d}",
            (float(condition),),
            "forced_choice",
            tuple(LEVELS.tolist()),
            tuple(n_correct[person, condition].tolist()),
            (N_TRIALS,) * len(LEVELS),
            0,
            0,
        )
        for person in range(N_PARTICIPANTS)
        for condition in range(N_CONDITIONS)
    ]


def hierarchical(cells: list[Cell]) -> HierarchicalFit:
    """Fit all participants as `analyse` does."""
    levels, n_yes = np.tile(LEVELS, len(cells)), np.concatenate([cell.n_yes for cell in cells])
    names = np.repeat([cell.participant for cell in cells], len(LEVELS)).tolist()
    condition = {FACTOR: np.repeat([cell.condition[0] for cell in cells], len(LEVELS)).tolist()}
    return fit_hierarchical(levels, n_yes, N_TRIALS, names, condition, shape="normal", guess_rate=GUESS_RATE)


def _fitted(cells: list[Cell]) -> pd.DataFrame:
    return estimate_table(estimates(cells), [FACTOR], "")


def tested(cells: list[Cell]) -> dict[str, float]:
    """Return p of each test of the factor, or NaN without a result."""
    anova = outcome(_fitted(cells), [FACTOR], "forced_choice", "threshold").anova
    p_of_group = math.nan
    with suppress(InvalidParameter):
        p_of_group = hierarchical(cells).effect(FACTOR).p
    return {
        "ANOVA of fitted thresholds": math.nan if anova is None else float(anova["p_CM_corr"].iloc[0]),
        "hierarchical": p_of_group,
    }


def estimated(cells: list[Cell]) -> dict[str, Estimate]:
    """Estimate the last condition minus the first with each method."""
    of_pairs = of_group = NO_ANSWER
    with suppress(InvalidParameter):  # raised if a cell has no threshold
        compared = pairs(_fitted(cells), dependent="threshold", factor=FACTOR, subject="participant")
        pair = compared[(compared["a"] == FIRST) & (compared["b"] == LAST)].iloc[0]
        of_pairs = pair["difference"], pair["difference_low"], pair["difference_high"]
    with suppress(InvalidParameter):
        contrast = hierarchical(cells).contrast({(LAST,): 1.0, (FIRST,): -1.0})
        of_group = contrast.estimate, contrast.interval_low, contrast.interval_high
    return {"fitted thresholds, pairs": of_pairs, "hierarchical": of_group}


def false_alarms(cell_sd_db: float, n_sets: int, rng: np.random.Generator) -> pd.DataFrame:
    """Test simulated studies without an effect, and others with an effect."""
    rows = [
        (effect, test, p)
        for effect in (0.0, EFFECT_DB)
        for _ in range(n_sets)
        for test, p in tested(study(cell_sd_db, effect, rng)).items()
    ]
    return pd.DataFrame(rows, columns=["effect", "test", "p"]).assign(own_sd_db=cell_sd_db)


def effects(cell_sd_db: float, n_sets: int, rng: np.random.Generator) -> pd.DataFrame:
    """Estimate the effect in simulated studies that have one."""
    rows = [
        (method, EFFECT_DB, *result)
        for _ in range(n_sets)
        for method, result in estimated(study(cell_sd_db, EFFECT_DB, rng)).items()
    ]
    named = pd.DataFrame(rows, columns=["method", "truth", "estimate", "low", "high"])
    return named.assign(own_sd_db=cell_sd_db)


def _settings(simulate: Any) -> Mapping[str, Simulate]:
    return {f"own differences of {sd:g} dB": partial(simulate, sd) for sd in CELL_SDS_DB}


PEOPLE: Final = f"""\
{N_PARTICIPANTS} participants answer {N_TRIALS} two-alternative trials at each of {len(LEVELS)} levels in
{N_CONDITIONS} conditions. Thresholds have a mean of {MEAN_DB:g} dB, an SD of {PARTICIPANT_SD_DB:g} dB between
participants, and an SD of `own_sd_db` between a participant's conditions. Psychometric functions are normal, with
widths of {WIDTH_DB:g} dB that vary by {WIDTH_LOG_SD:.0%}, and {LAPSE_RATE:.0%} lapses."""
FALSE_ALARMS: Final[Mapping[str, Simulate]] = _settings(false_alarms)
EFFECTS: Final[Mapping[str, Simulate]] = _settings(effects)
