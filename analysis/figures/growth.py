"""Figure of magnitude estimates: geometric means against the level."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import pandas as pd

from .axes import FactorAxis, panels, series
from .style import Drawing, shades

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def growth_figure(growth: pd.DataFrame, factors: Sequence[str], *, unit: str) -> Drawing:
    """A panel per series, a line per value of the main factor; the numbers on a logarithmic axis, and the levels unless
    they are in decibels."""
    axis = FactorAxis.of(growth, factors)

    def draw(axes: "Axes", panel: pd.DataFrame) -> None:
        lines = series(panel, [axis.along] if axis.along else [])
        for (line, part), colour in zip(lines, shades(len(lines)), strict=True):
            axes.plot(part["level"], part["geometric_mean"], "o-", color=colour, label=line, markersize=3)
        axes.set_yscale("log")
        if not unit.startswith("dB"):
            axes.set_xscale("log")

    labels = f"Level ({unit})" if unit else "Level", "Magnitude (geometric mean)"
    return panels(growth, axis, draw, labels=labels, height_in=2.7, share_x=True)
