"""Analysis of a task: the `ANALYSIS` of each task's file."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import pandas as pd
from scipy.special import ndtri

from tactometry.psychometric import SHAPES

from ..reading.level_scale import is_logarithm
from ..reading.trials import Trials

SHAPE = "normal"
FORCED_CHOICE_LAPSE_BETA = 20.0
"""The prior of lapses is Beta(1, 20) where the guess rate is known."""
DETECTION_SHAPE_IN_DB = "gumbel"
JND_PER_SD = float(ndtri(0.75))
"""The just noticeable difference over the standard deviation of the normal function: 0.6745."""
DIFFERENCE_PER_WIDTH = JND_PER_SD / SHAPES[SHAPE].z_width


@dataclass(frozen=True)
class Curve:
    """Psychometric function of a task.

    Parameters
    ----------
    rate_label, success : str
        Names of the rate on an axis, and of a success in a caption.
    options : callable
        Options of the fit, from the number of alternatives and the unit of the levels.
    scored_by : str
        Column with 1 for a success, 0 else.
    has_difference : bool
        The threshold is a point of subjective equality, the width a just noticeable difference.
    counts_catch : bool
        Catch trials determine the guess rate.
    methods : str
        Sentence of the methods section, with ``{guess_rate}``.
    estimate : str
        Point estimate of the threshold. In forced choice the mode is biased upwards by lapses.
    """

    rate_label: str
    success: str
    options: Callable[[int, str], Mapping[str, Any]]
    scored_by: Literal["response", "correct"] = "response"
    has_difference: bool = False
    counts_catch: bool = False
    methods: str = ""
    estimate: Literal["mode", "median"] = "median"

    @property
    def dependents(self) -> tuple[str, ...]:
        """Values that are compared between conditions."""
        return ("pse", "jnd") if self.has_difference else ("threshold",)


def shape_of(unit: str) -> str:
    """Return the shape of a detection function for a unit of the levels.

    A Weibull of the amplitude, which is a Gumbel if levels are logarithms (Watson 1979, Vision Res. 19, 515), else the
    cumulative normal.
    """
    return DETECTION_SHAPE_IN_DB if is_logarithm(unit) else SHAPE


def detection(unit: str, guess_rate: float | None) -> Mapping[str, Any]:
    """Return the options of a detection fit; a guess rate of None is free."""
    options = {"shape": shape_of(unit), "guess_rate": guess_rate, "scale_free_width": True}
    return options if guess_rate is None else options | {"lapse_beta": FORCED_CHOICE_LAPSE_BETA}


@dataclass(frozen=True)
class Results:
    """Results of a task without a curve.

    Parameters
    ----------
    tables : mapping of str to callable
        Tables by name, each from the used rows of the task and the factors.
    methods : str
        Sentences of the methods section.
    works : tuple of str
        References that `methods` cites.
    dependent : str
        Column that is compared between conditions; empty: none.
    compared : str
        Table with that column, a row for each participant and condition; by default that named as the task.
    further : tuple of str
        Columns of that table that are conditions in addition to the factors.
    in_levels : bool
        The dependent value is in the unit of the levels, as are the equivalence bounds of a plan.
    title, lead, in_terminal : str
        Heading and first sentence on the page, and title in the terminal, of a table that is shown as it is.
    view : callable
        The table named as the task for readers, from it, the trials and the unit of the levels.
    """

    tables: Mapping[str, Callable[[pd.DataFrame, Sequence[str]], pd.DataFrame]]
    methods: str = ""
    works: tuple[str, ...] = ()
    dependent: str = ""
    compared: str = ""
    further: tuple[str, ...] = ()
    in_levels: bool = True
    title: str = ""
    lead: str = ""
    in_terminal: str = ""
    view: Callable[[pd.DataFrame, Trials, str], pd.DataFrame] = field(default=lambda table, trials, unit: table)


@dataclass(frozen=True)
class TaskAnalysis:
    """Text and analysis of a task.

    Parameters
    ----------
    course : str
        Course of a trial, a sentence without its full stop.
    r_model : str
        Model of the answers in R: ``{data}`` is the table, ``{times}`` crosses the level with the factors, ``{plus}``
        are the factors alone, ``{n_choices}`` the alternatives.
    curve : Curve, optional
        Psychometric function that is fitted.
    results : Results, optional
        Results of a task without a curve.
    """

    course: str
    r_model: str
    curve: Curve | None = None
    results: Results | None = None

    @property
    def dependents(self) -> tuple[str, ...]:
        """Values that are compared between conditions."""
        if self.curve is not None:
            return self.curve.dependents
        return (self.results.dependent,) if self.results is not None and self.results.dependent else ()


R_OF_LEVEL = 'lme4::glmer(as.integer(response) ~ level{times} + (1 + level | participant), {data}, binomial("probit"))'
"""Model of answers 1 and 0 that depend on the level."""
R_OF_FORM = "ordinal::clmm(factor(response, ordered = TRUE) ~ {plus} + (1 | participant) + (1 | item), data = {data})"
"""Model of points of a scale."""
