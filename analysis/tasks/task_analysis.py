"""Classes that describe the analysis of a task."""

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
"""The prior of the lapse rate is Beta(1, 20) if the guess rate is known."""
DETECTION_SHAPE_IN_DB = "gumbel"
JND_PER_SD = float(ndtri(0.75))
"""Just noticeable difference divided by the standard deviation of the normal function: 0.6745."""
DIFFERENCE_PER_WIDTH = JND_PER_SD / SHAPES[SHAPE].z_width


@dataclass(frozen=True)
class Curve:
    """Psychometric function of a task.

    - `rate_label`, `success`: Label of the rate on an axis, and name of a success in a caption.
    - `options`: Returns the options of the fit from the number of alternatives and the unit of the levels.
    - `scored_by`: Column that is 1 for a success and 0 otherwise.
    - `has_difference`: True if the threshold is a point of subjective equality and the width a just noticeable
      difference.
    - `counts_catch`: True if catch trials inform the guess rate.
    - `methods`: Sentence of the methods section, which may contain ``{guess_rate}``.
    - `estimate`: Point estimate of the threshold. In forced choice the mode is biased upwards by lapses.
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
        """Names of the variables that are compared between conditions."""
        return ("pse", "jnd") if self.has_difference else ("threshold",)


def shape_of(unit: str) -> str:
    """Return the shape of a detection function from the unit of the levels.

    If levels are logarithms, the shape is Gumbel, which is a Weibull function of the amplitude (Watson 1979, Vision
    Res. 19, 515). Otherwise it is the cumulative normal.
    """
    return DETECTION_SHAPE_IN_DB if is_logarithm(unit) else SHAPE


def detection(unit: str, guess_rate: float | None) -> Mapping[str, Any]:
    """Return the options of a detection fit; a `guess_rate` of None is free."""
    options = {"shape": shape_of(unit), "guess_rate": guess_rate, "scale_free_width": True}
    return options if guess_rate is None else options | {"lapse_beta": FORCED_CHOICE_LAPSE_BETA}


@dataclass(frozen=True)
class Results:
    """Results of a task without a curve.

    - `tables`: Functions by table name, which make a table from the used rows of the task and the factors.
    - `methods`: Sentences of the methods section.
    - `works`: References that `methods` cites.
    - `dependent`: Column that is compared between conditions, or "".
    - `compared`: Name of the table with that column and one row per participant and condition. The default is the name
      of the task.
    - `further`: Columns of that table that count as conditions in addition to the factors.
    - `in_levels`: True if the dependent variable (and so an equivalence bound) is in the unit of the levels.
    - `title`, `lead`, `in_terminal`: Heading and first sentence on the page, and title in the terminal, of a table that
      is shown directly.
    - `view`: Formats the table for readers, given the table, the trials and the unit of the levels.
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

    - `course`: Course of a trial, as a sentence without full stop.
    - `r_model`: Model of the answers in R. ``{data}`` is the table, ``{times}`` crosses the level with the factors,
      ``{plus}`` is the sum of the factors, ``{n_choices}`` the number of alternatives.
    - `curve`: Psychometric function to fit.
    - `results`: Results of a task without a curve.
    """

    course: str
    r_model: str
    curve: Curve | None = None
    results: Results | None = None

    @property
    def dependents(self) -> tuple[str, ...]:
        """Names of the variables that are compared between conditions."""
        if self.curve is not None:
            return self.curve.dependents
        return (self.results.dependent,) if self.results is not None and self.results.dependent else ()


R_OF_LEVEL = 'lme4::glmer(as.integer(response) ~ level{times} + (1 + level | participant), {data}, binomial("probit"))'
"""R model of binary answers that depend on the level."""
R_OF_FORM = "ordinal::clmm(factor(response, ordered = TRUE) ~ {plus} + (1 | participant) + (1 | item), data = {data})"
"""R model of ratings on an ordinal scale."""
