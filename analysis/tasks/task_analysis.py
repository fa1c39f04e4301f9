"""What is made of the answers of a task: the `ANALYSIS` of each task's file."""

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
    """How the answers of a task follow its levels.

    Parameters
    ----------
    rate_label : str
        What the rate of successes is called on an axis.
    success : str
        What a success is called in a caption.
    options : callable
        From the number of alternatives and the unit of the levels to options of the fit.
    scored_by : str
        The column that says whether a trial was a success, 1 or 0.
    has_difference : bool
        The threshold is a point of subjective equality, and the width a just noticeable difference.
    counts_catch : bool
        Answers in catch trials tell the guess rate.
    methods : str
        What the methods section says of the rates, with ``{guess_rate}``.
    estimate : str
        The threshold's point estimate. In forced choice the mode lies above the truth, the more the more lapses.
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
        """The values of each participant and condition that are compared."""
        return ("pse", "jnd") if self.has_difference else ("threshold",)


def shape_of(unit: str) -> str:
    """The psychometric function of detection: Weibull's of the amplitude, which is a Gumbel in decibels
    (Watson 1979, Vision Res. 19, 515), where levels are logarithms; else the cumulative normal."""
    return DETECTION_SHAPE_IN_DB if is_logarithm(unit) else SHAPE


def detection(unit: str, guess_rate: float | None) -> Mapping[str, Any]:
    """Options of the fit to a detection: a guess rate of None is free."""
    options = {"shape": shape_of(unit), "guess_rate": guess_rate, "scale_free_width": True}
    return options if guess_rate is None else options | {"lapse_beta": FORCED_CHOICE_LAPSE_BETA}


@dataclass(frozen=True)
class Results:
    """Results of a task that no curve is fitted to.

    Parameters
    ----------
    tables : mapping of str to callable
        By the name of its file each table, from the used rows of the task and the factors.
    methods : str
        What the methods section says of them.
    works : tuple of str
        The works that `methods` names.
    dependent : str
        The column that is compared between conditions; empty: none is.
    compared : str
        The table that holds it, with a row for each participant and condition; by default that named as the task.
    further : tuple of str
        Columns of that table that are conditions beside the factors.
    in_levels : bool
        The dependent value is in the unit of the levels, as are the differences that a plan counts as none.
    title, lead, in_terminal : str
        Of a table that is told as it stands, as that of a dependent value is not: the heading and the sentence of the
        page, and the title of the terminal.
    view : callable
        The table named as the task as a person reads it, from it, the trials and the unit of the levels.
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
    """How a report speaks of a task, and what it makes of the answers.

    Parameters
    ----------
    course : str
        What participants did in a trial, a sentence without its full stop.
    r_model : str
        A model of the answers in R: ``{data}`` is the table, ``{times}`` crosses the level with the factors, ``{plus}``
        are the factors alone, ``{n_choices}`` the alternatives.
    curve : Curve, optional
        The psychometric function that is fitted.
    results : Results, optional
        What is told in place of a curve.
    """

    course: str
    r_model: str
    curve: Curve | None = None
    results: Results | None = None

    @property
    def dependents(self) -> tuple[str, ...]:
        """The values of each participant and condition that are compared."""
        if self.curve is not None:
            return self.curve.dependents
        return (self.results.dependent,) if self.results is not None and self.results.dependent else ()


R_OF_LEVEL = 'lme4::glmer(as.integer(response) ~ level{times} + (1 + level | participant), {data}, binomial("probit"))'
"""Of answers 1 and 0 that follow the level."""
R_OF_FORM = "ordinal::clmm(factor(response, ordered = TRUE) ~ {plus} + (1 | participant) + (1 | item), data = {data})"
"""Of points of a scale."""
