"""Force and speed around stimulus onset, if they were recorded."""

from collections.abc import Iterator
from functools import partial

from ...figures.curves import courses_figure
from ...result import Analysis
from ..section import Content, Figure, Lead, ResultKind, Section
from ..texts import caption

QUANTITIES = {"force_n": "Applied force", "speed_m_per_s": "Finger speed"}


def _sections(analysis: Analysis) -> Iterator[Section]:
    table = analysis.table("touches")
    if not len(table):
        return
    n_unread = int(table.groupby("participant")["n_unread"].first().sum())
    blocks: list[Content] = [Lead(caption("touches_lead", n_unread))]
    for quantity in (name for name in QUANTITIES if (table["quantity"] == name).any()):
        rows = table[table["quantity"] == quantity]
        n_touches = int(rows.groupby(["participant", "target"])["n_touches"].max().sum())
        text = caption("touches", QUANTITIES[quantity], n_touches, rows["band_low"].notna().any())
        draw = partial(courses_figure, table, quantity)
        blocks.append(Figure(f"touches_{quantity}", draw, text, "touches", of=("quantity", quantity)))
    yield Section("Touches", tuple(blocks))


KIND = ResultKind(_sections)
