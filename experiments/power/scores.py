"""Effects on questionnaire scores: attitudes, and tests of scores."""

from collections.abc import Mapping
from dataclasses import replace
from math import exp
from typing import Any, Final

import numpy as np
import pandas as pd

from tactometry.analysis.attrakdiff.scoring import BY, THESIS, against_reference, frequency_by_envelope
from tactometry.analysis.outcomes.findings import FORCE, Outcome, Primary
from tactometry.analysis.outcomes.outcome import MEASURED
from tactometry.analysis.outcomes.ratings import PATTERN, are_patterns, form_scores, score_outcome
from tactometry.analysis.reading.trials import Trials, asked_rows
from tactometry.observers.raters import Raters
from tactometry.protocols.tasks.task import AsksForm
from tactometry.questionnaire import Questionnaire
from tactometry.trials.cells import cell as cell_text
from tactometry.trials.tasks import FORM_TASK

from ..study.experiment import Experiment
from ..study.study import Levels, Study
from .effect import StatedEffect

OF_THESIS: Final[Mapping[str, Levels]] = {
    name: tuple(dict.fromkeys(values[place] for values in THESIS.values())) for place, name in enumerate(BY)
}
"""Levels of repetition frequency and of envelope, which the analysis of the patterns' ratings compares."""


def factors_of(study: Study) -> dict[str, Levels]:
    """Return the factors that an effect may name.

    These are the factors of the study. For the thesis's patterns, frequency and envelope are added.
    """
    return {**study.factors, **(OF_THESIS if has_patterns(study) else {})}


def has_patterns(study: Study) -> bool:
    """Return True if the study rates the thesis's patterns."""
    varied = {name: levels for name, levels in study.factors.items() if len(levels) > 1}
    return study.task.get("kind") == FORM_TASK and are_patterns(varied)


def applied_effect(effect: StatedEffect, study: Study) -> StatedEffect:
    """Return an effect as the effect of one of the study's factors.

    An effect of frequency or envelope becomes an effect of the factor `pattern`.

    >>> from ..study.study_file import load, parse
    >>> from .effect import parse_effect
    >>> _, content = load("time-reversal-patterns")
    >>> applied_effect(parse_effect("frequency: 1 points"), parse(content, "patterns")).words()
    'pattern: P1 = -0.5 points, P2 = -0.5 points, P3 = -0.5 points, P4 = 0.5 points, P5 = 0.5 points, P6 = 0.5 points'
    """
    if effect.factor in study.factors or effect.factor not in OF_THESIS:
        return effect
    of_level, place = effect.of_levels(OF_THESIS[effect.factor]), BY.index(effect.factor)
    by_pattern = tuple((pattern, of_level[levels[place]]) for pattern, levels in THESIS.items())
    return replace(effect, factor=PATTERN, change=None, by_level=by_pattern)


def form_of_task(experiment: Experiment) -> Questionnaire | None:
    """Return the questionnaire of the task, or None."""
    return experiment.task.form if isinstance(experiment.task, AsksForm) else None


def attitude_per_point(raters: Raters, form: Questionnaire, dimension: str) -> float:
    """Return the attitude that raises the mean score of a dimension by 1.

    The attitude applies to all items. It is computed from the mean of `observers.raters.Raters` over items and
    participants, assuming no answer at an end of the scale.

    >>> from tactometry.questionnaire import load
    >>> round(attitude_per_point(Raters(loading=0.5, extremity_cv=0.0), load("attrakdiff"), "ATT"), 4)
    0.6667
    """
    loading = float(np.mean([raters.loadings.get(item, raters.loading) for item in form.items_of(dimension)]))
    extremity = exp(raters.extremity_cv**2 / 2)  # mean of a lognormal factor
    return 2 / ((form.score_high - form.score_low) * loading * extremity)


def with_attitudes(study: Study, effect: StatedEffect, experiment: Experiment, dimension: str, share: float) -> Study:
    """Return the study with attitudes that are only `share` times the effect."""
    form, raters = form_of_task(experiment), experiment.people.raters
    assert form is not None
    assert raters is not None
    per_point = attitude_per_point(raters, form, dimension)
    parts = {item.dimension for item in form.items if item.id in form.items_of(dimension)}
    by_level = {
        level: dict.fromkeys(sorted(parts), share * points * per_point)
        for level, points in effect.of_levels(study.factors[effect.factor]).items()
    }
    table = study.observer["raters"]
    effects = {**table.get("effects", {}), effect.factor: by_level}
    return replace(study, observer={**study.observer, "raters": {**table, "effects": effects}})


def attitudes_of(study: Study, factor: str) -> dict[str, float]:
    """Return the attitude at each level, as in `with_attitudes`."""
    table: Mapping[str, Mapping[str, float]] = study.observer["raters"]["effects"][factor]
    return {cell_text(level): next(iter(of_level.values())) for level, of_level in table.items()}


def task_scores(trials: Trials, form: Questionnaire) -> pd.DataFrame:
    """Return the questionnaire scores by participant and condition."""
    rows = asked_rows(trials)
    rows = rows[(rows["task"] == FORM_TASK) & (rows["procedure"] == form.name)]
    return form_scores(rows, trials.factors, form) if len(rows) else pd.DataFrame()


def p_of_scores(scored: pd.DataFrame, study: Study, dimension: str, factor: str, primary: str | None) -> float | None:
    """Return the p value of a factor in the analysis of ratings.

    For frequency or envelope of the thesis's patterns, p is from the ANOVA of both. For the factor `pattern`, p is the
    smallest Holm-corrected p against the single focus.
    """
    if not has_patterns(study):
        return p_of(score_outcome(scored, scored.attrs["within"], dimension, primary), factor)
    if factor == PATTERN:
        return _least(against_reference(scored), {"dimension": dimension}, "p_corr")
    return _least(frequency_by_envelope(scored), {"dimension": dimension, "Source": factor}, "p_CM_corr")


def _least(table: pd.DataFrame, rows: Mapping[str, Any], column: str) -> float | None:
    """Return the smallest value of a column in matching rows, or None."""
    if column not in table.columns:
        return None
    kept = np.logical_and.reduce([table[name] == value for name, value in rows.items()])
    least = table.loc[kept, column].min()
    return None if pd.isna(least) else float(least)


P_COLUMNS: Final = ("p_CM_corr", "p", "p_permutation")
"""Columns with a reported p value. The first one in a table is used."""


def p_of(tested: Outcome, factor: str) -> float | None:
    """Return a factor's p value in the primary analysis, or None if missing."""
    effects = tested.effects
    if effects is None:
        return None
    name = MEASURED if tested.primary is Primary.MIXED_MODEL and factor == FORCE else factor
    of_factor = effects[effects.iloc[:, 0] == name]
    column = next((column for column in P_COLUMNS if column in effects.columns), None)
    if of_factor.empty or column is None or pd.isna(of_factor[column].iloc[0]):
        return None
    return float(of_factor[column].iloc[0])
