"""Dependent values: group table, primary analysis, checks and comparisons, and the hierarchical model."""

from collections.abc import Iterator, Sequence
from functools import partial

import pandas as pd

from ...anova.group_means import HIGH, LOW, bounds_of, is_of_fit
from ...figures import psychophysics
from ...outcomes.findings import Outcome
from ...outcomes.hierarchical_outcome import HierarchicalOutcome
from ...result import Analysis
from ...tasks.kinds import CURVES
from ...tasks.magnitude import DEPENDENT as EXPONENT, GROWTH
from ...wording import cross_table, dependent_name, dependent_title, in_words, interval_text, p_text, with_unit
from ..captions import figure_text, means_sentence, means_text
from ..section import Blocks, Details, Figure, Folded, Heading, Lead, ResultKind, Section, Sentences, TextTable, grid
from ..sentences import hierarchical_sentences, outcome_sentences, primary_sentences

EFFECT_COLUMNS = {
    "Source": "effect", "term": "effect", "SS": "SS", "ddof1": "df 1", "ddof2": "df 2", "df1": "df 1", "df2": "df 2",
    "F": "F", "eps_CM": "epsilon", "p_CM_corr": "p (dfs times epsilon)", "p": "p", "p_permutation": "p",
    "np2": "partial eta²", "ng2": "generalised eta²",
}  # fmt: skip
"""Columns of the primary analysis on the page; the file has all."""
DECIBELS = "dB re 1 "
P_COLUMNS = ("p_CM_corr", "p", "p_permutation")


def _sections(analysis: Analysis) -> Iterator[Section]:
    for outcome in analysis.outcomes:
        unit = outcome.unit(analysis.unit)
        title = dependent_title(outcome.dependent)
        yield Section(f"{title} ({unit})" if unit else title, tuple(_blocks(outcome, analysis)))
    for check in analysis.hierarchical:
        task = f" ({check.task.replace('_', ' ')})" if len(analysis.hierarchical) > 1 else ""
        yield Section(f"All participants at once{task}", tuple(_check_blocks(check, analysis)))


def _blocks(outcome: Outcome, analysis: Analysis) -> Blocks:
    factors = outcome.factors
    yield Lead(means_sentence(outcome.group))
    yield grid(outcome.cross, factors)
    yield from _amplitudes(outcome, analysis)
    yield _figure(outcome, analysis)
    if outcome.dependent == EXPONENT and GROWTH in analysis.tables:
        draw = partial(psychophysics.growth_figure, analysis.tables[GROWTH], analysis.factors, unit=analysis.unit)
        text = "Numbers given to each level: geometric means over participants after modulus equalisation."
        yield Figure(GROWTH, draw, text, GROWTH)
    sentences = outcome_sentences(outcome, analysis.unit)
    if outcome.effects is not None:
        heading = outcome.heading()
        yield Heading(in_words(heading, factors))
        yield grid(_effect_columns(outcome.effects, factors), ())
        # Shown open; the others are folded below.
        yield Sentences(sentences.pop(heading, []))
    yield Folded(sentences, n_open=2)


def _amplitudes(outcome: Outcome, analysis: Analysis) -> Blocks:
    """Yield the group table in the unit that decibels refer to."""
    unit = outcome.unit(analysis.unit)
    if not unit.startswith(DECIBELS) or outcome.group["mean"].isna().all():
        return
    peak = " peak" * bool(analysis.study.procedure)  # the levels of our own stimuli are peaks
    yield Lead(f"The same in {unit.removeprefix(DECIBELS)}{peak}, 10^(level / 20): means are geometric.")
    yield grid(cross_table(as_amplitudes(outcome.group), outcome.factors), outcome.factors)


def as_amplitudes(group: pd.DataFrame) -> pd.DataFrame:
    """Return a group table with amplitudes, 10^(level / 20), as `text` where there is a mean.

    >>> as_amplitudes(pd.DataFrame({"mean": [20.0], "mean_low": [0.0], "mean_high": [40.0], "text": [""]}))["text"][0]
    '10.0 [1.0, 100.0]'
    """
    ends = [(10 ** (group[name].astype(float) / 20)).tolist() for name in ("mean", "mean_low", "mean_high")]
    texts = [
        text if pd.isna(row[0]) else interval_text(*row)
        for text, row in zip(group["text"], zip(*ends, strict=True), strict=True)
    ]
    return group.assign(text=texts)


def _figure(outcome: Outcome, analysis: Analysis) -> Figure:
    name, values = dependent_title(outcome.dependent), bounds_of(outcome.estimates, outcome.dependent)
    label = with_unit(name, outcome.unit(analysis.unit))
    if is_of_fit(outcome.group):  # whose values are the means
        values = values[values[outcome.dependent].isna()]
    draw = partial(psychophysics.threshold_figure, outcome.group, values, outcome.factors, outcome.dependent, label)
    triangles = ", open triangles bounds" if values[[LOW, HIGH]].notna().any(axis=None) else ""
    text = f"{name}: {figure_text(outcome.group, f'faint dots are participants{triangles}')}."
    stem = analysis.stem(outcome)
    return Figure(stem, draw, text, f"group_{stem}")


def _effect_columns(table: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    effects = table[table["F"].notna()]
    shown = effects[[name for name in EFFECT_COLUMNS if name in effects.columns]].copy()
    for name in set(P_COLUMNS) & set(shown.columns):
        shown[name] = [p_text(p).removeprefix("p ").removeprefix("= ") for p in shown[name].astype(float)]
    for name in {"Source", "term"} & set(shown.columns):
        shown[name] = [in_words(source, factors) for source in shown[name]]
    return shown.rename(columns=EFFECT_COLUMNS)


def _terminal(analysis: Analysis) -> Iterator[TextTable]:
    for outcome in analysis.outcomes:
        unit = f", {outcome.unit(analysis.unit)}" if outcome.unit(analysis.unit) else ""
        primary = [outcome.heading(), *primary_sentences(outcome)] if outcome.primary else []
        title = f"{dependent_name(outcome.dependent)}{unit} ({means_text(outcome.group)}, n)"
        yield TextTable(outcome.cross, title, [*outcome.notes, *primary], across="condition")
    yield from _check_terminal(analysis)


def _values(analysis: Analysis) -> Iterator[tuple[str, object]]:
    yield "outcomes", [_values_of_outcome(outcome, analysis.unit) for outcome in analysis.outcomes]
    yield "hierarchical", [_values_of_check(outcome, analysis.unit) for outcome in analysis.hierarchical]


def _values_of_outcome(outcome: Outcome, unit: str) -> dict[str, object]:
    primary: dict[str, object] | None = None
    if outcome.primary is not None and outcome.effects is not None:
        title = outcome.title(outcome.primary)
        role: dict[str, object] = {"analysis": outcome.primary.value, "title": title, "reason": outcome.reason}
        primary = role | {"effects": outcome.effects}
    return {
        "task": outcome.task,
        "dependent": outcome.dependent,
        "group": outcome.group,
        "primary": primary,
        "checks": [outcome.title(name) for name in outcome.analyses() if name is not outcome.primary],
        "anova": outcome.anova,
        "left_out": list(outcome.left_out),
        "status": None if outcome.status is None else outcome.status.value,
        "sentences": primary_sentences(outcome),
        "statistics": outcome_sentences(outcome, unit),
        "notes": list(outcome.notes),
    }


MEANS = {"threshold": "mean", "interval_low": "mean_low", "interval_high": "mean_high"}
"""Columns of a group table for those of the conditions."""


def _check_blocks(outcome: HierarchicalOutcome, analysis: Analysis) -> Blocks:
    sentences = Sentences(hierarchical_sentences(outcome, analysis.unit))
    if outcome.fit is None:
        yield sentences
        return
    values = "points of subjective equality" if _dependent(outcome) == "pse" else "thresholds"
    yield Lead(
        f"A check of the primary analysis. Hierarchical model: {values} of the group with 95 % interval; "
        "estimates of participants are drawn to the group as far as their answers leave it open."
    )
    yield grid(cross_table(outcome.conditions, outcome.fit.factors), analysis.factors)
    yield _check_figure(outcome, analysis)
    yield sentences
    yield Details(f"Participants ({len(outcome.participants)} rows)", (grid(outcome.participants, analysis.factors),))


def _dependent(outcome: HierarchicalOutcome) -> str:
    return CURVES[outcome.task].dependents[0]


def _check_figure(outcome: HierarchicalOutcome, analysis: Analysis) -> Figure:
    name = dependent_title(_dependent(outcome))
    means, factors = outcome.conditions.rename(columns=MEANS), [f for f in analysis.factors if f in outcome.conditions]
    label = with_unit(name, analysis.unit)
    draw = partial(psychophysics.threshold_figure, means, outcome.participants, factors, "threshold", label)
    bars = " with 95 % intervals" if outcome.conditions["interval_low"].notna().any() else ""
    text = f"{name}: the hierarchical model's means{bars}; faint dots are participants, drawn to the group."
    stem = f"hierarchical_{outcome.task}"
    return Figure(stem, draw, text, stem)


def _check_terminal(analysis: Analysis) -> Iterator[TextTable]:
    for outcome in analysis.hierarchical:
        if outcome.fit is not None:
            unit = f", {analysis.unit}" if analysis.unit else ""
            name = dependent_name(_dependent(outcome))
            title = f"check, all participants at once: {name}{unit} (mean, 95 % interval)"
            cross = cross_table(outcome.conditions, outcome.fit.factors)
            yield TextTable(cross, title, hierarchical_sentences(outcome, analysis.unit), across="condition")


def _values_of_check(outcome: HierarchicalOutcome, unit: str) -> dict[str, object]:
    return {
        "task": outcome.task,
        "status": None if outcome.fit is None else outcome.fit.status.value,
        "conditions": outcome.conditions,
        "participants": outcome.participants,
        "components": {} if outcome.fit is None else dict(outcome.fit.components),
        "sentences": hierarchical_sentences(outcome, unit),
    }


KIND = ResultKind(_sections, _terminal, _values)
