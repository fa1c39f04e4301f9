"""The psychometric curve of the present condition while it is measured, with the band in which its posterior lies."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pandas as pd

from tactometry.analysis.tasks.cell import Cell
from tactometry.analysis.tasks.cells import alternatives, estimates
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

from .plots import (
    BOTTOM,
    LEFT,
    RIGHT,
    TOP,
    Mark,
    Plot,
    Ruler,
    Stroke,
    condition_words,
    last_presented,
    polyline,
    ruler_over,
    success,
)

N_PLACES = 61
FEWEST_ANSWERS = 6
"""Before so many the band says the prior alone."""


@dataclass(frozen=True)
class Answers:
    """Answers in one `condition`: successes and trials by level, catch trials."""

    condition: str
    task: str
    unit: str
    n_choices: int
    levels: tuple[float, ...]
    n_yes: tuple[int, ...]
    n_trials: tuple[int, ...]
    n_false_alarms: int = 0
    n_catch: int = 0
    standard: float | None = None


def answers_of(progress: Progress) -> Answers | None:
    """Return the answers of the present condition without practice.

    None if no curve is fitted to the task, or there are too few answers.
    """
    last = last_presented(progress)
    if last is None or last.task not in CURVES:
        return None
    rows = [row for row in _rows(progress, last.task) if row.factors == last.factors]
    asked = [(_level(row), row) for row in rows if row.level is not None and success(row) is not None]
    if len(asked) < FEWEST_ANSWERS:
        return None
    n_trials = Counter(level for level, _ in asked)
    n_yes = Counter(level for level, row in asked if success(row))
    caught = [row for row in rows if row.catch and CURVES[last.task].counts_catch]
    levels = tuple(sorted(n_trials))
    return Answers(
        condition_words(last.factors),
        last.task,
        last.level_unit,
        _n_choices(progress, last),
        levels,
        tuple(n_yes[level] for level in levels),
        tuple(n_trials[level] for level in levels),
        sum(row.response == 1 for row in caught),
        len(caught),
        last.standard_level,
    )


def _rows(progress: Progress, task: str) -> Iterator[Trial]:
    for track in progress.tracks.values():
        for row in track.presented:
            if row.valid and not row.practice and row.task == task:
                yield row


def _level(row: Trial) -> float:
    return float((row.level if row.level_delivered is None else row.level_delivered) or 0.0)


def _n_choices(progress: Progress, last: Trial) -> int:
    """Return the number of alternatives in the present condition, as `analyse` finds it among all conditions."""
    rows = list(_rows(progress, last.task))
    table = pd.DataFrame([{"task": row.task, "response": row.response, "target": row.target} for row in rows])
    condition = pd.Series([condition_words(row.factors) for row in rows])
    return int(
        alternatives(table.assign(condition=condition), ["condition"])[condition == condition_words(last.factors)].iloc[
            0
        ]
    )


def fit_of(answers: Answers) -> ThresholdFit:
    """Fit the psychometric function exactly as `analyse` fits it."""
    counts = (answers.levels, answers.n_yes, answers.n_trials, answers.n_catch, answers.n_false_alarms)
    return estimates([Cell("", (), answers.task, *counts, answers.n_choices)], answers.unit)[0].fit


def band_of(answers: Answers) -> CurveBand | None:
    """Return the posterior band of the curve with the same options; None with one level."""
    return curve_band(
        answers.levels,
        answers.n_yes,
        answers.n_trials,
        np.linspace(min(answers.levels), max(answers.levels), N_PLACES),
        n_false_alarms=answers.n_false_alarms,
        n_catch=answers.n_catch,
        **CURVES[answers.task].options(answers.n_choices, answers.unit),
    )


def curve_plot(answers: Answers) -> Plot:
    """Plot the rates at their levels, the curve in its band, the threshold and the standard."""
    band, fit = band_of(answers), fit_of(answers)
    x = ruler_over(answers.levels, LEFT, RIGHT, margin=0.02)
    y = Ruler(-0.03, 1.03, BOTTOM, TOP)
    most = max(answers.n_trials)
    rates = zip(answers.levels, answers.n_yes, answers.n_trials, strict=True)
    label = CURVES[answers.task].rate_label
    curve = () if band is None else (Stroke(_along(x, y, band.levels, band.median), "curve"),)
    places = {"threshold": fit.threshold, "standard": answers.standard}
    upright = ((kind, at) for kind, at in places.items() if at is not None and x.low <= at <= x.high)
    return Plot(
        name="curve",
        title=", ".join(filter(None, (label, answers.condition))),
        words=_words(answers, fit),
        x_label=with_unit("level", answers.unit),
        y_label=label.lower(),
        x=x,
        y=y,
        marks=tuple(Mark(x.at(u), y.at(k / n), "rate", round(3 + 4 * (n / most) ** 0.5, 2)) for u, k, n in rates),
        strokes=(*curve, *(Stroke(polyline(x, y, [(at, 0.0), (at, 1.0)]), kind) for kind, at in upright)),
        areas=() if band is None else (Stroke(_around(x, y, band), "band"),),
    )


def _along(x: Ruler, y: Ruler, levels: np.ndarray, rates: np.ndarray) -> str:
    return polyline(x, y, zip(levels.tolist(), rates.tolist(), strict=True))


def _around(x: Ruler, y: Ruler, band: CurveBand) -> str:
    """Return the outline of a band."""
    return f"{_along(x, y, band.levels, band.low)} {_along(x, y, band.levels[::-1], band.high[::-1])}"


def _words(answers: Answers, fit: ThresholdFit) -> str:
    """State the estimates that `analyse` reports for these answers.

    >>> levels = (36.0, 38.0, 40.0, 42.0, 44.0)
    >>> of = Answers("", "comparison", "dB", 2, levels, (0, 1, 6, 11, 12), (12,) * 5, standard=40.0)
    >>> _words(of, fit_of(of))
    '60 answers at 5 levels; point of subjective equality 40.0 [39.2, 40.8] dB, standard 40 dB (95 % interval).'
    """
    found = f"{sum(answers.n_trials)} answers at {count_of(len(answers.levels), 'level')}"
    if fit.threshold is None:
        ends = fit.interval_low, fit.interval_high
        interval = "" if ends == (None, None) else f"; 95 % interval {in_unit(ends_text(*ends), answers.unit)}"
        return f"{found}; {fit.note}{interval}."
    name = dependent_name(CURVES[answers.task].dependents[0])
    threshold = in_unit(interval_text(fit.threshold, fit.interval_low, fit.interval_high), answers.unit)
    standard = "" if answers.standard is None else f", standard {in_unit(plain_text(answers.standard), answers.unit)}"
    note = f"; {fit.note}" if fit.note else ""
    return f"{found}; {name} {threshold}{standard} ({percent_text(fit.interval)} interval){note}."
