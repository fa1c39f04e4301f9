"""Force and speed around the onset, if they were recorded."""

from collections.abc import Iterator
from functools import partial
from typing import Final

from ...figures.touches import courses_figure
from ...result import Analysis
from ..section import Content, Figure, Lead, ResultKind, Section

NAME: Final = "touches"
WORDS: Final = {"force_n": "Applied force", "speed_m_per_s": "Speed of the finger"}
LEAD: Final = (
    "Samples of the valid touches, practice aside, as the sensors told them; a single trial is drawn by tactometry "
    "show."
)


def _sections(analysis: Analysis) -> Iterator[Section]:
    table = analysis.table(NAME)
    if not len(table):
        return
    n_unread = int(table.groupby("participant")["n_unread"].first().sum())
    unread = f" Samples of touches that cannot be read: {n_unread}; tactometry validate names them." if n_unread else ""
    blocks: list[Content] = [Lead(LEAD + unread)]
    for quantity in (name for name in WORDS if (table["quantity"] == name).any()):
        rows = table[table["quantity"] == quantity]
        n_touches = int(rows.groupby(["participant", "target"])["n_touches"].max().sum())
        words = f"{WORDS[quantity]} around the onset of the stimulus, in valid touches ({n_touches})"
        band = "; dotted: the band to keep" if rows["band_low"].notna().any() else ""
        text = f"{words}: median over the touches of each participant, shaded: 5th to 95th percentile{band}."
        draw = partial(courses_figure, table, quantity)
        blocks.append(Figure(f"{NAME}_{quantity}", draw, text, NAME, of=("quantity", quantity)))
    yield Section("Touches", tuple(blocks))


KIND = ResultKind(_sections)
