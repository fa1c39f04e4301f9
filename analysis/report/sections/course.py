"""Interruptions of sessions and interventions of the experimenter."""

from collections.abc import Iterator

from ...result import Analysis
from ..section import Content, Heading, Lead, ResultKind, Section, details, grid, rows_of

COLUMNS = {
    "started_utc": "began (UTC)", "begun_s": "at (s)", "changes": "changes since the previous sitting",
    "onset": "at (s)", "trial_type": "event", "text": "description",
}  # fmt: skip
MOST_OPEN = 20
"""Longer tables are folded."""


def _sections(analysis: Analysis) -> Iterator[Section]:
    sittings, events = (analysis.table(name).rename(columns=COLUMNS) for name in ("sittings", "happenings"))
    blocks: list[Content] = []
    if len(sittings):
        lead = "Interrupted sessions were resumed at the interrupted trial."
        blocks += [Heading("Sittings"), Lead(lead), grid(sittings, ())]
    if len(events):
        blocks.append(Heading("Events"))
        if "order" in set(events["event"]):
            blocks.append(Lead("Orders are requests by the experimenter; interventions are the resulting actions."))
        blocks.append(grid(events, ()) if len(events) <= MOST_OPEN else details("All events", events, ()))
    if blocks:
        yield Section("Course of the sessions", tuple(blocks))


KIND = ResultKind(_sections, values=rows_of("sittings", "happenings"))
