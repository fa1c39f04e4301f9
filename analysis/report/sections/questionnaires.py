"""Questionnaires: scores by condition, word pairs and comparisons."""

from collections.abc import Iterator, Sequence
from functools import partial

import pandas as pd

from ...attrakdiff.scoring import THESIS
from ...figures import attrakdiff
from ...outcomes.ratings import REFERENCE, Ratings
from ...result import Analysis
from ..section import Draw, Figure, Folded, Lead, ResultKind, Section, TextGrid, TextTable
from ..texts import caption, facts_of, form_sentences, means_text

MOST_LINES = 7
"""Largest number of conditions in a figure of word pairs (one colour each)."""


def _sections(analysis: Analysis) -> Iterator[Section]:
    for form in analysis.forms:
        low, high, cross = form.form.score_low, form.form.score_high, form.cross()
        lead = Lead(f"Scores from {low:g} to {high:g}. {means_text('sentence', form.summary)}")
        table = TextGrid(tuple(cross.columns), tuple(cross.itertuples(index=False, name=None)))
        sentences = Folded(form_sentences(form), n_open=1)
        yield Section(form.form.title, (lead, table, *_figures(form), sentences))


def _figures(form: Ratings) -> Iterator[Figure]:
    names = list(dict.fromkeys(form.summary["condition"]))
    order = list(form.form.dimensions)
    low, high = form.form.score_low, form.form.score_high

    scores = partial(attrakdiff.scores_figure, form.summary, names[:MOST_LINES], order, low, high)
    yield _figure(form, "scores", scores, f"Scores: {means_text('figure', form.summary)}.", "summary")
    if form.portfolio is not None:
        bars = " with 95 % confidence rectangles" if form.portfolio["PQ_low"].notna().any() else ""
        text = f"Portfolio: {means_text('whose', form.summary)}{bars}."
        yield _figure(form, "portfolio", partial(attrakdiff.portfolio_figure, form.portfolio), text, "portfolio")
    if form.crossed is not None:
        draw = partial(attrakdiff.crossed_figure, form.summary, THESIS, order, REFERENCE, (low, high))
        text = caption("crossed", facts_of(form.summary), REFERENCE)
        yield _figure(form, "frequency_by_envelope", draw, text, "summary")
    items = "Word pairs" if form.profile["negative"].astype(bool).any() else "Items"
    for name, conditions in _profiles(form, names):
        draw = partial(attrakdiff.profile_figure, form.profile, conditions, low, high)
        of = f" of {', '.join(conditions)}" if len(names) > 1 else ""
        yield _figure(form, name, draw, f"{items}: {means_text('whose', form.summary)}{of}.", "word_pairs")
    if form.grouped is not None:
        yield from _grouped_figures(form, form.grouped)


def _figure(
    form: Ratings, name: str, draw: Draw, caption: str, table: str, of: tuple[str, str] | None = None
) -> Figure:
    return Figure(f"{form.stem}_{name}", draw, caption, f"{form.stem}_{table}", of)


def _profiles(form: Ratings, names: Sequence[str]) -> list[tuple[str, list[str]]]:
    """Return the conditions of each word-pair figure."""
    if form.crossed is None:
        return [("word_pairs", list(names[:MOST_LINES]))]
    groups = {f: [p for p, (frequency, _) in THESIS.items() if frequency == f] for f, _ in THESIS.values()}
    start = [REFERENCE] if REFERENCE in names else []
    return [(f"word_pairs_{f}_frequency", [*start, *codes]) for f, codes in groups.items()]


def _grouped_figures(form: Ratings, grouped: pd.DataFrame) -> Iterator[Figure]:
    """Yield figures that compare frequencies and envelopes."""
    for of, profile in grouped.groupby("of", sort=False):
        names = list(dict.fromkeys(profile["condition"]))
        draw = partial(attrakdiff.profile_figure, profile, names, form.form.score_low, form.form.score_high)
        text = f"Word pairs by {of}: {means_text('whose', form.summary)}, over patterns; with {REFERENCE}."
        yield _figure(form, f"word_pairs_by_{of}", draw, text, "word_pairs_grouped", ("of", str(of)))


def _terminal(analysis: Analysis) -> Iterator[TextTable]:
    for form in analysis.forms:
        heading, lines = next(iter(form_sentences(form).items()))
        compared = [heading, *lines] if form.tests_effects else []
        title = f"{form.form.title} ({means_text('cells', form.summary)}, n)"
        yield TextTable(form.cross(), title, [*form.notes, *compared], across="scale")


def _values(analysis: Analysis) -> Iterator[tuple[str, object]]:
    yield "questionnaires", {form.name: form.summary for form in analysis.forms}
    yield "questionnaire_statistics", {form.name: form_sentences(form) for form in analysis.forms}


KIND = ResultKind(_sections, _terminal, _values)
