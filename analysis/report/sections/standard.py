"""Points of subjective equality against the standard."""

from collections.abc import Iterator

from ...result import Analysis
from ...tasks.standard import FLOORS, TESTS, standard_sentences
from ..section import Details, Lead, ResultKind, Section, Sentences, TextTable, grid, rows_of

TITLE = "Point of subjective equality and just noticeable difference"
LEAD = (
    "Mean difference from the standard with a t-test over participants (p is not corrected for the number of "
    "conditions), or the posterior interval of each participant if there are fewer than three. The Weber fraction is "
    "the mean just noticeable difference divided by the standard, both as amplitudes if levels are logarithms."
)


def _sections(analysis: Analysis) -> Iterator[Section]:
    table = analysis.table(TESTS)
    if len(table):
        sentences = Sentences(standard_sentences(table, analysis.factors, analysis.unit))
        floors = grid(analysis.table(FLOORS), analysis.factors)
        yield Section(TITLE, (Lead(LEAD), sentences, Details("Answers at the lowest levels", (floors,))))


def _terminal(analysis: Analysis) -> Iterator[TextTable]:
    table = analysis.table(TESTS)
    if len(table):
        shown = table[["participant", *analysis.factors, "n", "difference", "jnd", "weber_fraction"]]
        shown = shown.drop(columns="participant") if (shown["participant"] == "").all() else shown
        sentences = standard_sentences(table, analysis.factors, analysis.unit)
        yield TextTable(
            shown, "point of subjective equality minus standard, just noticeable difference, Weber fraction", sentences
        )


KIND = ResultKind(_sections, _terminal, rows_of(TESTS, FLOORS))
