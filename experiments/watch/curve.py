"""Psychometric function of the current condition, with its posterior band."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import nan
from typing import Any

import numpy as np
import pandas as pd

from tactometry.analysis.tasks.cell import Cell
from tactometry.analysis.tasks.cells import cells, estimates
from tactometry.analysis.tasks.kinds import CURVES
from tactometry.analysis.threshold.band import CurveBand, curve_band
from tactometry.analysis.threshold.estimates import ThresholdFit
from tactometry.analysis.wording import (
    dependent_name,
    ends_text,
    in_unit,
    interval_text,
    percent_text,
    plain_text,
    with_unit,
)
from tactometry.errors import count_of
from tactometry.session.progress import Progress
from tactometry.trials.trial import Trial

from .plots import BOTTOM, LEFT, RIGHT, TOP, Mark, Plot, Ruler, condition_words, last_presented, ruler_over, success

N_PLACES = 61
FEWEST_ANSWERS = 6
"""Smallest number of answers for a curve. With fewer, the band would mostly show the prior."""


@dataclass(frozen=True)
class Answers:
    """Counted answers in a condition, with unit and standard of the levels."""

    cell: Cell
    unit: str
    standard: float | None = None

    @property
    def n(self) -> int:
        return sum(self.cell.n_trials)


def answers_of(progress: Progress) -> Answers | None:
    """Return the answers of the current condition, without practice.

    Returns None if no function is fitted for the task, or there are too few answers.
    """
    last = last_presented(progress)
    if last is None or last.task not in CURVES:
        return None
    rows = list(_judged(progress, last.task))
    present = condition_words(last.factors)
    # Cells are built from all conditions, as together they determine the number of alternatives.
    counted = cells(pd.DataFrame(rows), ["condition"]) if rows else []
    cell = next((cell for cell in counted if cell.condition == (present,)), None)
    if cell is None or sum(cell.n_trials) < FEWEST_ANSWERS:
        return None
    return Answers(cell, last.level_unit, last.standard_level)


def _judged(progress: Progress, task: str) -> Iterator[dict[str, Any]]:
    for track in progress.tracks.values():
        for trial in track.presented:
            if trial.valid and not trial.practice and trial.task == task and success(trial) is not None:
                yield _row(trial)


def _row(trial: Trial) -> dict[str, Any]:
    level = trial.level if trial.level_delivered is None else trial.level_delivered
    return {
        "participant": "",
        "condition": condition_words(trial.factors),
        "task": trial.task,
        "response": trial.response,
        "target": trial.target,
        "is_catch": trial.catch is True,
        "x": nan if level is None else float(level),
        "yes": float(success(trial) or False),
    }


def fit_of(answers: Answers) -> ThresholdFit:
    """Fit the psychometric function exactly as `analyse` fits it."""
    return estimates([answers.cell], answers.unit)[0].fit


def band_of(answers: Answers) -> CurveBand | None:
    """Return the posterior band of the curve, or None with a single level."""
    cell, curve = answers.cell, CURVES[answers.cell.task]
    return curve_band(
        cell.levels,
        cell.n_yes,
        cell.n_trials,
        np.linspace(min(cell.levels), max(cell.levels), N_PLACES),
        n_false_alarms=cell.n_false_alarms if curve.counts_catch else 0,
        n_catch=cell.n_catch if curve.counts_catch else 0,
        **curve.options(cell.n_choices, answers.unit),
    )


def curve_plot(answers: Answers) -> Plot:
    """Plot rates, the curve with its band, the threshold and the standard."""
    cell, band, fit = answers.cell, band_of(answers), fit_of(answers)
    x, y = ruler_over(cell.levels, LEFT, RIGHT, margin=0.02), Ruler(-0.03, 1.03, BOTTOM, TOP)
    label = CURVES[cell.task].rate_label
    plot = Plot(
        name="curve",
        title=", ".join(filter(None, (label, str(cell.condition[0])))),
        words=_words(answers, fit),
        x_label=with_unit("level", answers.unit),
        y_label=label.lower(),
        x=x,
        y=y,
    )
    most = max(cell.n_trials)
    for level, k, n in zip(cell.levels, cell.n_yes, cell.n_trials, strict=True):
        plot.marks.append(Mark(x.at(level), y.at(k / n), "rate", round(3 + 4 * (n / most) ** 0.5, 2)))
    if band is not None:
        outline = np.concatenate([band.levels, band.levels[::-1]]), np.concatenate([band.low, band.high[::-1]])
        plot.area("band", zip(*outline, strict=True))
        plot.line("curve", zip(band.levels, band.median, strict=True))
    for kind, place in {"threshold": fit.threshold, "standard": answers.standard}.items():
        if place is not None and x.low <= place <= x.high:
            plot.line(kind, [(place, 0.0), (place, 1.0)])
    return plot


def _words(answers: Answers, fit: ThresholdFit) -> str:
    """Return a sentence with the estimates that `analyse` would report.

    >>> levels = (36.0, 38.0, 40.0, 42.0, 44.0)
    >>> of = Answers(Cell("", ("",), "comparison", levels, (0, 1, 6, 11, 12), (12,) * 5, 0, 0), "dB", standard=40.0)
    >>> _words(of, fit_of(of))
    '60 answers at 5 levels; point of subjective equality 40.0 [39.2, 40.8] dB, standard 40 dB (95 % interval).'
    """
    result = f"{answers.n} answers at {count_of(len(answers.cell.levels), 'level')}"
    if fit.threshold is None:
        ends = fit.interval_low, fit.interval_high
        interval = "" if ends == (None, None) else f"; 95 % interval {in_unit(ends_text(*ends), answers.unit)}"
        return f"{result}; {fit.note}{interval}."
    name = dependent_name(CURVES[answers.cell.task].dependents[0])
    threshold = in_unit(interval_text(fit.threshold, fit.interval_low, fit.interval_high), answers.unit)
    standard = "" if answers.standard is None else f", standard {in_unit(plain_text(answers.standard), answers.unit)}"
    note = f"; {fit.note}" if fit.note else ""
    return f"{result}; {name} {threshold}{standard} ({percent_text(fit.interval)} interval){note}."
