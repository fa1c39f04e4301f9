"""The psychometric curve of the present condition while it is measured, with the band in which its posterior lies."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tactometry.analysis.tasks.kinds import CURVES
from tactometry.analysis.threshold.band import CurveBand, curve_band
from tactometry.analysis.wording import in_unit, interval_text, with_unit
from tactometry.session.progress import Progress
from tactometry.trials.trial import Trial

from .condition import condition_words
from .plots import BOTTOM, LEFT, RIGHT, TOP, Mark, Plot, Ruler, Stroke, last_presented, polyline, ruler_over, success

N_PLACES = 61
FEWEST_ANSWERS = 6
"""Before so many the band says the prior alone."""


@dataclass(frozen=True)
class Answers:
    """What was answered in one `condition`: by level how many successes of how many answers, and the catch trials."""

    condition: str
    task: str
    unit: str
    n_choices: int
    levels: tuple[float, ...]
    n_yes: tuple[int, ...]
    n_trials: tuple[int, ...]
    n_false_alarms: int = 0
    n_catch: int = 0


def answers_of(progress: Progress) -> Answers | None:
    """Those of the present condition, practice left out; None where no curve is fitted to its task, or too few."""
    last = last_presented(progress)
    if last is None or last.task not in CURVES:
        return None
    rows = list(_rows(progress, last))
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
        _n_choices(rows),
        levels,
        tuple(n_yes[level] for level in levels),
        tuple(n_trials[level] for level in levels),
        sum(row.response == 1 for row in caught),
        len(caught),
    )


def _rows(progress: Progress, last: Trial) -> Iterator[Trial]:
    for track in progress.tracks.values():
        for row in track.presented:
            if row.valid and not row.practice and row.task == last.task and row.factors == last.factors:
                yield row


def _level(row: Trial) -> float:
    return float((row.level if row.level_delivered is None else row.level_delivered) or 0.0)


def _n_choices(rows: list[Trial]) -> int:
    """Intervals of a forced choice: the largest that was ever a target or an answer."""
    largest = [int(value) for row in rows for value in (row.target, row.response) if isinstance(value, int | float)]
    return max([2, *largest])


def band_of(answers: Answers) -> CurveBand | None:
    """As the analysis will fit it: with its shape, guess rate and priors; None where there is one level alone."""
    return curve_band(
        answers.levels,
        answers.n_yes,
        answers.n_trials,
        np.linspace(min(answers.levels), max(answers.levels), N_PLACES),
        n_false_alarms=answers.n_false_alarms,
        n_catch=answers.n_catch,
        **CURVES[answers.task].options(answers.n_choices, answers.unit),
    )


def curve_plot(answers: Answers, band: CurveBand | None) -> Plot:
    """The rates at their levels, and the curve in its band."""
    ends = answers.levels if band is None else (band.levels[0], band.levels[-1])
    x = ruler_over(map(float, ends), LEFT, RIGHT, margin=0.02)
    y = Ruler(-0.03, 1.03, BOTTOM, TOP)
    most = max(answers.n_trials)
    rates = zip(answers.levels, answers.n_yes, answers.n_trials, strict=True)
    label = CURVES[answers.task].rate_label
    return Plot(
        name="curve",
        title=", ".join(filter(None, (label, answers.condition))),
        words=_words(answers, band),
        x_label=with_unit("level", answers.unit),
        y_label=label.lower(),
        x=x,
        y=y,
        marks=tuple(Mark(x.at(u), y.at(k / n), "rate", round(3 + 4 * (n / most) ** 0.5, 2)) for u, k, n in rates),
        strokes=() if band is None else (Stroke(_along(x, y, band.levels, band.median), "curve"),),
        areas=() if band is None else (Stroke(_around(x, y, band), "band"),),
    )


def _along(x: Ruler, y: Ruler, levels: np.ndarray, rates: np.ndarray) -> str:
    return polyline(x, y, zip(levels.tolist(), rates.tolist(), strict=True))


def _around(x: Ruler, y: Ruler, band: CurveBand) -> str:
    """The outline of a band: along its lower end and back along its upper one."""
    return f"{_along(x, y, band.levels, band.low)} {_along(x, y, band.levels[::-1], band.high[::-1])}"


def _words(answers: Answers, band: CurveBand | None) -> str:
    of = f"{sum(answers.n_trials)} answers at {len(answers.levels)} levels"
    if band is None:
        return f"{of}: one level has no curve."
    low, median, high = band.threshold
    return f"{of}; threshold {in_unit(interval_text(median, low, high), answers.unit)} (median and 95 % interval)."
