"""Interruptions of sessions, and interventions of the experimenter."""

from collections.abc import Iterator

from ...result import Analysis
from ..section import Content, Details, Heading, Lead, ResultKind, Section, grid, rows_of

COLUMNS = {
    "started_utc": "began (UTC)", "begun_s": "at (s)", "changes": "what is another than in the sitting before",
    "onset": "at (s)", "trial_type": "what", "text": "in words",
}  # fmt: skip
MOST_OPEN = 20
"""Longer tables are folded."""


def _sections(analysis: Analysis) -> Iterator[Section]:
    sittings, events = (analysis.table(name) for name in ("sittings", "happenings"))
    blocks: list[Content] = []
    if len(sittings):
        lead = "Sessions that were interrupted went on with the trial that was under way."
        blocks += [Heading("Sittings"), Lead(lead), grid(sittings.rename(columns=COLUMNS), ())]
    if len(events):
        blocks.append(Heading("What happened in them"))
        if "order" in set(events["trial_type"]):
            blocks.append(Lead("An order is what the experimenter asked for, an intervention what came of it."))
        listed = grid(events.rename(columns=COLUMNS), ())
        blocks.append(listed if len(events) <= MOST_OPEN else Details(f"All {len(events)} events", (listed,)))
    if blocks:
        yield Section("How the sessions went", tuple(blocks))


KIND = ResultKind(_sections, values=rows_of("sittings", "happenings"))
