"""Numbers of participants by answer to categorical questions."""

from collections.abc import Iterator

from ...result import Analysis
from ..section import Heading, Lead, ResultKind, Section, TextGrid, rows_of

LEAD = "Number of participants by answer. These answers are not tested and do not exclude participants."


def _sections(analysis: Analysis) -> Iterator[Section]:
    table = analysis.table("categories")
    if not len(table):
        return
    blocks: list[Heading | Lead | TextGrid] = [Lead(LEAD)]
    for question, counts in table.groupby("question", sort=False):
        rows = tuple((str(row.category), str(row.n)) for row in counts.itertuples())
        blocks += [Heading(str(question)), TextGrid(("answer", "n"), rows)]
    yield Section("About the participants", tuple(blocks))


KIND = ResultKind(_sections, values=rows_of("categories"))
