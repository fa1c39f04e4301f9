"""Figure of paired comparisons of preference."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from .style import SPREAD, Drawing, bars, drawing_of, look, new_figure, series

CHANCE = 0.5
EDGE = 0.02
"""Axis range with a margin for dots at 0 and 1."""


def share_figure(shares: pd.DataFrame, items: Sequence[str]) -> Drawing:
    """Draw how often each item was preferred, with intervals."""
    lines = series(shares, list(shares.columns[: shares.columns.get_loc("item")]))
    with new_figure(5.4, (0.3 + 0.1 * len(lines)) * len(items) + 0.9) as figure:
        axes = figure.add_subplot()
        for n, (name, rows) in enumerate(lines):
            share, reach = bars(rows.set_index("item").reindex(list(items)), "share")
            y = np.arange(len(items)) + min(SPREAD, SPREAD * 4 / len(lines)) * (n - (len(lines) - 1) / 2)
            style: dict[str, Any] = {"capsize": 2.5, "elinewidth": 1.0, "linestyle": "none"} | look(n)
            axes.errorbar(share, y, xerr=reach, label=name, **style)
        axes.axvline(CHANCE, color="#777777", linestyle=":", linewidth=0.9, zorder=0)
        axes.set_yticks(range(len(items)), list(items))
        axes.set(xlabel="Share of its pairs won", xlim=(-EDGE, 1 + EDGE), ylim=(len(items) - 0.5, -0.5))
        if len(lines) > 1:
            figure.legend(loc="outside right center")
        return drawing_of(figure)
