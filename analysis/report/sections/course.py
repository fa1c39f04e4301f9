"""Interruptions of sessions, and interventions of the experimenter."""

from collections.abc import Iterator

from ...result import Analysis
from ..section import Blocks, Details, Heading, Lead, ResultKind, Section, TextGrid, grid, rows_of

COLUMNS = {
    "started_utc": "began (UTC)", "begun_s": "at (s)", "changes": "what is another than in the sitting before",
    "onset": "at (s)", "trial_type": "what", "text": "in words",
}  # fmt: skip
MOST_OPEN = 20
"""Longer tables are folded."""


def _table(analysis: Analysis, name: str) -> TextGrid:
    return grid(analysis.table(name).rename(columns=COLUMNS), ())


def _blocks(analysis: Analysis) -> Blocks:
    if len(analysis.table("sittings")):
        yield Heading("Sittings")
        yield Lead("Sessions that were interrupted went on with the trial that was under way.")
        yield _table(analysis, "sittings")
    n_happenings = len(analysis.table("happenings"))
    if n_happenings:
        yield Heading("What happened in them")
        if "order" in set(analysis.table("happenings")["trial_type"]):
            yield Lead("An order is what the experimenter asked for, an intervention what came of it.")
        listed = _table(analysis, "happenings")
        yield listed if n_happenings <= MOST_OPEN else Details(f"All {n_happenings} events", (listed,))


def _sections(analysis: Analysis) -> Iterator[Section]:
    blocks = tuple(_blocks(analysis))
    if blocks:
        yield Section("How the sessions went", blocks)


KIND = ResultKind(_sections, values=rows_of("sittings", "happenings"))
