"""Style of the figures: width, colours, axes and units."""

from collections.abc import Iterator, Mapping
from itertools import cycle
from pathlib import Path
from typing import Any, Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tactometry.palette import BLACK, BLUE, GOLD, GREEN, ORANGE, PINK, SKY

COLOURS: Final = (BLUE, ORANGE, GREEN, PINK, SKY, GOLD, BLACK)
DIVERGING: Final = "RdBu_r"
RESOLUTION_DPI: Final = 150
ABOVE: Final[Mapping[str, Any]] = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0)}
"""Position of a legend above its axes."""


def sheet(
    n_rows: int = 1, n_columns: int = 1, *, width_in: float = 6.4, height_in: float = 4.0
) -> tuple[Figure, list[Axes]]:
    """Return a figure and its axes, row by row."""
    figure = Figure(figsize=(width_in, height_in), layout="constrained")
    return figure, list(figure.subplots(n_rows, n_columns, squeeze=False).ravel())


def label(axes: Axes, x: str, y: str, title: str = "", *, from_zero: bool = False, **legend: Any) -> None:
    """Label the axes with units, and draw a light grid and a legend."""
    axes.set(xlabel=x, ylabel=y)
    if from_zero:
        axes.set_ylim(0, 1.05 * axes.dataLim.y1)  # else values far above 0 touch the upper edge
    if axes.get_legend_handles_labels()[0]:
        axes.legend(frameon=False, **legend)
    axes.set_title(title, fontsize="medium")
    axes.grid(alpha=0.3)
    axes.spines[["top", "right"]].set_visible(False)


def colours() -> Iterator[str]:
    """Repeat the palette endlessly."""
    return cycle(COLOURS)


def save(figure: Figure, path: Path) -> None:
    """Write a figure in the format of the file's suffix."""
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=RESOLUTION_DPI)
