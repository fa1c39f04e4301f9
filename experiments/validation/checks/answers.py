"""Tests and intervals of a group, from answers: the analysis of fitted thresholds, and the
hierarchical model."""

import math
from collections.abc import Mapping
from functools import partial
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tactometry.analysis.anova.post_hoc import pairs
from tactometry.analysis.hierarchical.fitting import fit_hierarchical
from tactometry.analysis.hierarchical.result import HierarchicalFit
from tactometry.analysis.outcomes.outcome import outcome
from tactometry.analysis.tasks.cell import Cell
from tactometry.analysis.tasks.cells import estimate_table, estimates
from tactometry.errors import InvalidParameter
from tactometry.psychometric import PsychometricFunction

from ..check import Check, Simulate
from ..kinds import ESTIMATES, NO_ANSWER, TESTS, Estimate

N_PARTICIPANTS, N_CONDITIONS, N_TRIALS = 10, 3, 14
LEVELS: Final = np.linspace(8.0, 32.0, 7)
MEAN_DB, PARTICIPANT_SD_DB, WIDTH_DB, WIDTH_LOG_SD, LAPSE_RATE = 20.0, 2.5, 8.0, 0.2, 0.02
EFFECT_DB: Final = 1.5
CELL_SDS_DB: Final = (0.0, 1.0)
GUESS_RATE: Final = 0.5
FACTOR: Final = "condition"
FIRST, LAST = 0.0, float(N_CONDITIONS - 1)


def study(cell_sd_db: float, effect_db: float, rng: np.random.Generator) -> list[Cell]:
    """Cells of people whose thresholds rise by so much from the first condition to the last, in equal steps."""
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


Columns = Mapping[str, NDArray[Any]]


def columns(cells: list[Cell]) -> Columns:
    """A row for each cell and level."""
    n_levels = len(LEVELS)
    return {
        "levels": np.tile(LEVELS, len(cells)),
        "n_yes": np.concatenate([cell.n_yes for cell in cells]),
        "participants": np.repeat([cell.participant for cell in cells], n_levels),
        FACTOR: np.repeat([cell.condition[0] for cell in cells], n_levels),
    }


def hierarchical(rows: Columns) -> HierarchicalFit:
    """As `analyse` asks for it."""
    names, condition = rows["participants"].tolist(), {FACTOR: rows[FACTOR].tolist()}
    options: dict[str, Any] = {"shape": "normal", "guess_rate": GUESS_RATE}
    return fit_hierarchical(rows["levels"], rows["n_yes"], N_TRIALS, names, condition, **options)


def _fitted(cells: list[Cell]) -> pd.DataFrame:
    return estimate_table(estimates(cells), [FACTOR], "")


def _p_of_hierarchical(found: HierarchicalFit) -> float:
    try:
        return found.effect(FACTOR).p
    except InvalidParameter:
        return math.nan


def _of_pairs(fitted: pd.DataFrame) -> Estimate:
    """None where a cell has no threshold."""
    try:
        compared = pairs(fitted, dependent="threshold", factor=FACTOR, subject="participant")
    except InvalidParameter:
        return NO_ANSWER
    pair = compared[(compared["a"] == FIRST) & (compared["b"] == LAST)].iloc[0]
    return pair["difference"], pair["difference_low"], pair["difference_high"]


def _of_contrast(found: HierarchicalFit) -> Estimate:
    try:
        contrast = found.contrast({(LAST,): 1.0, (FIRST,): -1.0})
    except InvalidParameter:
        return NO_ANSWER
    return contrast.estimate, contrast.interval_low, contrast.interval_high


def tested(cells: list[Cell]) -> dict[str, float]:
    """p of each test of the factor."""
    anova = outcome(_fitted(cells), [FACTOR], "forced_choice", "threshold").anova
    rows = columns(cells)
    return {
        "ANOVA of fitted thresholds": math.nan if anova is None else float(anova["p_CM_corr"].iloc[0]),
        "hierarchical": _p_of_hierarchical(hierarchical(rows)),
    }


def estimated(cells: list[Cell]) -> dict[str, Estimate]:
    """The last condition less the first, with its interval, by each method."""
    rows = columns(cells)
    return {
        "fitted thresholds, pairs": _of_pairs(_fitted(cells)),
        "hierarchical": _of_contrast(hierarchical(rows)),
    }


def false_alarms(cell_sd_db: float, n_sets: int, rng: np.random.Generator) -> pd.DataFrame:
    """Of studies without an effect, and of others with one."""
    rows = [
        (effect, test, p)
        for effect in (0.0, EFFECT_DB)
        for _ in range(n_sets)
        for test, p in tested(study(cell_sd_db, effect, rng)).items()
    ]
    return pd.DataFrame(rows, columns=["effect", "test", "p"]).assign(own_sd_db=cell_sd_db)


def effects(cell_sd_db: float, n_sets: int, rng: np.random.Generator) -> pd.DataFrame:
    """Of studies with an effect."""
    rows = [
        (method, EFFECT_DB, *found)
        for _ in range(n_sets)
        for method, found in estimated(study(cell_sd_db, EFFECT_DB, rng)).items()
    ]
    named = pd.DataFrame(rows, columns=["method", "truth", "estimate", "low", "high"])
    return named.assign(own_sd_db=cell_sd_db)


def _settings(simulate: Any) -> Mapping[str, Simulate]:
    return {f"own differences of {sd:g} dB": partial(simulate, sd) for sd in CELL_SDS_DB}


_PEOPLE: Final = f"""\
{N_PARTICIPANTS} participants answer {N_TRIALS} two-alternative trials at each of {len(LEVELS)} levels in
{N_CONDITIONS} conditions: thresholds of {MEAN_DB:g} dB that differ by {PARTICIPANT_SD_DB:g} dB between people, and
by an own deviation in each condition (`own_sd_db`); normal functions, widths of {WIDTH_DB:g} dB that differ by
{WIDTH_LOG_SD:.0%}, {LAPSE_RATE:.0%} lapses."""
FALSE_ALARMS: Final = Check(
    title="Tests of a group, from answers",
    words=f"""\
{_PEOPLE} Without an effect 5 % of tests ought to have p < 5 %; with {EFFECT_DB:g} dB from the first condition to the
last the share is the power.""",
    kind=TESTS,
    keys=("own_sd_db", "effect", "test"),
    settings=_settings(false_alarms),
    n_sets=5,
    reasons={
        "hierarchical": "the prior of the participants' deviations by condition makes few participants differ more",
    },
    reason_key="test",
    figure="tests-of-answers",
)
EFFECTS: Final = Check(
    title="Effects in a group, from answers",
    words=f"""\
{_PEOPLE} The last condition is {EFFECT_DB:g} dB above the first: its estimate, less the truth, and its interval.""",
    kind=ESTIMATES,
    keys=("own_sd_db", "method"),
    settings=_settings(effects),
    n_sets=5,
    reasons={
        "hierarchical": "the prior of the participants' deviations by condition makes few participants differ more",
    },
    reason_key="method",
    figure="effects-of-answers",
)
