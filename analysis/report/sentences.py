"""Every sentence of an outcome, of a hierarchical outcome, and of a questionnaire, from its numbers."""

from collections.abc import Callable

import numpy as np
import pandas as pd

from ..hierarchical.fitting import FactorEffect, HierarchicalFit
from ..outcomes.findings import Outcome
from ..outcomes.hierarchical_outcome import HierarchicalOutcome
from ..outcomes.primary import Primary
from ..outcomes.ratings import REFERENCE, Ratings
from ..wording.numbers import number_text, p_text
from . import apa


def outcome_sentences(outcome: Outcome, of_levels: str) -> dict[str, list[str]]:
    """Every sentence, by the heading that it stands under; `of_levels` is the unit of the levels."""
    told = {} if outcome.primary is None else {outcome.heading(): primary_sentences(outcome)}
    told |= _comparisons(outcome, outcome.unit(of_levels).partition(" re ")[0])  # a difference has no reference
    told["Assumptions"] = [] if outcome.checks is None else list(outcome.checks["text"])
    for name in outcome.analyses():
        if name is not outcome.primary:
            told[f"Check: {outcome.title(name)}"] = analysis_sentences(outcome, name)
    return {heading: sentences for heading, sentences in told.items() if sentences}


def primary_sentences(outcome: Outcome) -> list[str]:
    """Of the analysis that answers."""
    return [] if outcome.primary is None else analysis_sentences(outcome, outcome.primary)


def analysis_sentences(outcome: Outcome, name: Primary) -> list[str]:
    """Of one of its analyses."""
    if name is Primary.MIXED_MODEL and outcome.model is not None:
        return apa.model_sentences(outcome.model)
    tell = apa.permutation_sentences if name is Primary.PERMUTATION else apa.anova_sentences
    return tell(outcome.analyses()[name])


def _comparisons(outcome: Outcome, unit: str) -> dict[str, list[str]]:
    told = {}
    for (name, by), table in outcome.simple.items():
        told[f"Simple effects of {name} at each {by}"] = apa.simple_sentences(table, by)
    for name, table in outcome.pairs.items():
        told[f"Pairs of {name}"] = apa.pair_sentences(table, unit, factor=name)
    for (name, by), table in outcome.simple_pairs.items():
        tell = apa.group_sentences if name == outcome.between else apa.pair_sentences
        told[f"Pairs of {name} at each {by}"] = tell(table, unit, by=by, factor=name)
    for name, table in outcome.group_pairs.items():
        told[f"Groups of {name}"] = apa.group_sentences(table, unit, factor=name)
    for name, table in outcome.equivalence.items():
        told[f"Equivalence over {name}"] = apa.equivalence_sentences(table, unit, factor=name)
    return told


def hierarchical_sentences(outcome: HierarchicalOutcome, unit: str) -> list[str]:
    """Effects, variances and rates, and what a reader must know."""
    if outcome.fit is None:
        return [outcome.note]
    tested = [f"{name}: Wald's {_statistic(one)}, {p_text(one.p)}" for name, one in outcome.effects.items()]
    return [*tested, *_variance_sentences(outcome.fit, unit), *([outcome.note] if outcome.note else [])]


def _statistic(one: FactorEffect) -> str:
    if np.isinf(one.df_error):
        return f"chi-square({one.df}) = {one.df * one.f:.2f} (participants' deviations by condition have no variance)"
    return apa.f_text(one.f, one.df, one.df_error, one.epsilon)


def _variance_sentences(fit: HierarchicalFit, unit: str) -> list[str]:
    unit = f" {unit.partition(' re ')[0]}" if unit else ""
    names = {
        "threshold": f"thresholds {{}}{unit}",
        "threshold_cell": f"their deviations by condition {{}}{unit}",
        "log_width": "logarithms of the width {}",
        "log_width_cell": "their deviations by condition {}",
    }
    sds = [text.format(number_text(fit.components[name])) for name, text in names.items() if name in fit.components]
    rates = {"lapse": fit.lapse_rate, "guess": fit.guess_rate}
    told = [f"{name} rate of all {rate:.3f}" for name, rate in rates.items() if rate]
    found = [f"standard deviations between {fit.n_participants} participants: {', '.join(sds)}"] if sds else []
    return [*found, *([", ".join(told)] if told else [])]


def form_sentences(form: Ratings) -> dict[str, list[str]]:
    """Every sentence of a questionnaire, by the heading that it stands under."""
    told: dict[str, list[str]] = {}
    if form.crossed is not None:
        told["Frequency by envelope, without the single focus"] = _by_dimension(form.crossed, apa.anova_sentences)
    if form.against is not None:
        told[f"Patterns against {REFERENCE}"] = _by_dimension(form.against, apa.pair_sentences)
    for dimension, outcome in form.outcomes.items():
        for heading, lines in outcome_sentences(outcome, "").items():
            told.setdefault(heading, []).extend(f"{dimension}: {line}" for line in lines)
    return told | {"Consistency": apa.alpha_sentences(form.consistency, form.factors)}


def _by_dimension(table: pd.DataFrame, sentences: Callable[[pd.DataFrame], list[str]]) -> list[str]:
    found = []
    for dimension, part in table.groupby("dimension", sort=False):
        left_out = part["left_out"].iloc[0]
        tail = f" (left out, without a score: {left_out})" if left_out else ""
        tested = part[part["F" if "F" in part.columns else "t"].notna()] if {"F", "t"} & set(part.columns) else part[:0]
        found += [f"{dimension}: {text}{tail}" for text in (sentences(tested) if len(tested) else [])]
        found += [f"{dimension}: not tested, {note}" for note in part["note"][~part.index.isin(tested.index)]]
    return found
