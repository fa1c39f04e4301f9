"""False effects of conditions that differ only in lapse rate."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
from scipy.stats import ttest_rel

from tactometry.analysis.tasks.cell import Cell, Estimate
from tactometry.analysis.tasks.cells import estimates
from tactometry.analysis.tasks.lapses import ALPHA, lapse_table
from tactometry.protocols.procedures.easy import with_easy_trials
from tactometry.protocols.procedures.procedure import Rule
from tactometry.psychometric import PsychometricFunction

from .participants import HIGH_DB, SHAPE, quest_plus, up_down, widths_db

TASK, UNIT, GUESS_RATE = "forced_choice", "dB re 1 V", 0.5
N_PEOPLE, N_TRIALS, MEAN_DB, SD_DB = 10, 40, 20.0, 4.0
RULES = {
    "QUEST+": replace(quest_plus(GUESS_RATE, "threshold"), n_trials=N_TRIALS),
    "1 up 3 down": replace(up_down(3), n_trials=N_TRIALS),
}
SHARES = (0.0, 0.1, 0.2)
LAPSE_RATES = ((0.0, 0.08), (0.02, 0.02))
"""Lapse rates of the first and of the second condition."""


def track(
    rule: Rule[Any], share: float, function: PsychometricFunction, rng: np.random.Generator
) -> tuple[list[float], list[bool]]:
    """Simulate a track with easy trials, and return levels and answers."""
    procedure = with_easy_trials(rule, share, HIGH_DB, rng) if share else rule.begin(rng)
    levels: list[float] = []
    answers: list[bool] = []
    while not procedure.finished:
        levels.append(procedure.level)
        answers.append(bool(rng.random() < function.probability(procedure.level)))
        procedure = procedure.after(answers[-1])
    return levels, answers


def study(rule: Rule[Any], share: float, lapse_rates: Sequence[float], rng: np.random.Generator) -> list[Estimate]:
    """Return estimates of participants whose conditions have equal thresholds."""
    thresholds, widths = rng.normal(MEAN_DB, SD_DB, N_PEOPLE), widths_db(rng.random(N_PEOPLE))
    cells = []
    for condition, lapse_rate in enumerate(lapse_rates):
        for n, (threshold, width) in enumerate(zip(thresholds, widths, strict=True)):
            levels, answers = track(
                rule, share, PsychometricFunction(SHAPE, threshold, width, GUESS_RATE, lapse_rate), rng
            )
            known, places = np.unique(levels, return_inverse=True)
            yes, trials = np.bincount(places, answers).astype(int), np.bincount(places)
            counts = tuple(known.tolist()), tuple(yes.tolist()), tuple(trials.tolist())
            cells.append(Cell(f"P{n}", (condition,), TASK, *counts, n_catch=0, n_false_alarms=0))
    return estimates(cells, UNIT)


def outcomes_of(
    n_studies: int, rng: np.random.Generator, rules: Sequence[str] = tuple(RULES)
) -> Iterator[dict[str, float | str]]:
    """Yield a row for each rule, lapse rate pair, and share of easy trials.

    `error` is the mean difference of thresholds (dB). `false_effects` is the share of studies with p < 0.05 in the
    paired t-test, and `detected` the share with p < 0.05 in the test of equal lapse rates.
    """
    for name, (first, second), share in product(rules, LAPSE_RATES, SHARES):
        result = [_judged(study(RULES[name], share, (first, second), rng)) for _ in range(n_studies)]
        error, false_effects, detected = np.mean(result, axis=0).tolist()
        row: dict[str, float | str] = {"rule": name, "first": first, "second": second, "share": share}
        yield row | {"error": error, "false_effects": false_effects, "detected": detected}


def _judged(found: Sequence[Estimate]) -> tuple[float, float, float]:
    thresholds = np.array([one.fit.threshold for one in found], dtype=float).reshape(-1, N_PEOPLE)
    first, second = thresholds[:, ~np.isnan(thresholds).any(axis=0)]
    detected = lapse_table(found, ["condition"])["p"].iloc[0] < ALPHA
    return float((second - first).mean()), float(ttest_rel(first, second).pvalue < 0.05), float(detected)
