"""The result in a terminal."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from ..tasks.kinds import CURVES
from ..wording.cross_table import cross_table
from ..wording.labels import in_words
from .captions import means_text
from .choice_text import choice_table
from .grid import grid
from .sentences import form_sentences, hierarchical_sentences, primary_sentences

if TYPE_CHECKING:
    import pandas as pd
    from rich.table import Table

    from ..result import Analysis

NAMES = {
    "threshold": "threshold",
    "pse": "point of subjective equality",
    "jnd": "just noticeable difference",
    "setting": "setting by adjustment",
    "exponent": "exponent of magnitude estimates",
}
CHOICE_NAMES = {
    "preference": "preference (Bradley-Terry worths, 95 % interval)",
    "same_different": "same or different (d′ by either rule)",
}


def tables(found: "Analysis") -> "Iterator[tuple[Table, Sequence[str]]]":
    """For each outcome its group table and what is to be said below it; factors in words."""
    factors = found.trials.factors
    for cross, title, sentences in _told(found):
        yield text_table(cross, title, factors), [in_words(sentence, factors) for sentence in sentences]


def _told(found: "Analysis") -> "Iterator[tuple[pd.DataFrame, str, Sequence[str]]]":
    """Each table with its title and what is said below it."""
    for outcome in found.outcomes:
        unit = f", {outcome.unit(found.unit)}" if outcome.unit(found.unit) else ""
        primary = [outcome.heading(), *primary_sentences(outcome)] if outcome.primary else []
        said = (*outcome.notes, *primary)
        yield outcome.cross, f"{NAMES[outcome.dependent]}{unit} ({means_text(outcome.group)}, n)", said
    for each in found.together:
        if each.fit is not None:
            cross = cross_table(each.conditions, each.fit.factors)
            title = NAMES[CURVES[each.task].dependents[0]]
            unit = f", {found.unit}" if found.unit else ""
            title = f"check, all participants at once: {title}{unit} (mean, 95 % interval)"
            yield cross, title, hierarchical_sentences(each, found.unit)
    for form in found.forms:
        heading, lines = next(iter(form_sentences(form).items()))
        compared = [heading, *lines] if form.tests_effects else []
        yield form.cross(), f"{form.form.title} ({means_text(form.summary)}, n)", [*form.notes, *compared]
    for name, title in CHOICE_NAMES.items():
        if name in found.tables:
            yield choice_table(found.tables[name], name, found.trials, found.unit), title, ()
    for name, title in (("loss", "loss of amplitude"), ("force", "applied force")):
        if name in found.tables:
            table = found.tables[name]
            yield cross_table(table, found.trials.factors), f"{title} ({_spread(table, name)})", ()


def _spread(table: "pd.DataFrame", name: str) -> str:
    """What a table of means tells beside them."""
    over = "participants" if table["n"].max() > 1 else "readings"
    told = f", 95 % interval over {over}" if name == "loss" else " ± SD between participants"
    return "mean" + (told if table["mean_low"].notna().any() else "")


def text_table(cross: "pd.DataFrame", title: str, factors: Sequence[str]) -> "Table":
    """Rows as they stand, under heads in words."""
    from rich.table import Table

    table = Table(title=title, title_justify="left", min_width=min(len(title), 78))
    told = grid(cross, factors)
    for head in told.header:
        table.add_column(head, justify="right", overflow="fold")
    for row in told.rows:
        table.add_row(*row)
    return table
