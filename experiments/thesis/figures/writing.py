"""Files of a reproduced figure: the picture, and its curves as numbers."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.container import ErrorbarContainer
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from tactometry.errors import attempt
from tactometry.files.rows import write_rows

RESOLUTION_DPI = 150
HEAD = ("panel", "curve", "x_label", "x", "y_label", "y", "place")


def write_drawing(figure: Figure, folder: Path, name: str) -> None:
    """Write NAME.png, and NAME.csv with a row for each curve point."""
    picture = folder / f"{name}.png"
    with attempt(picture, "cannot write", "a place to write to"):
        folder.mkdir(parents=True, exist_ok=True)
        figure.savefig(picture, dpi=RESOLUTION_DPI)
    write_rows(HEAD, points(figure), folder / f"{name}.csv")


def points(figure: Figure) -> Iterator[tuple[int | str | float, ...]]:
    """Yield the points of all curves, bars and maps.

    They are in the units of the axes; `place` is the name of a tick.
    """
    for panel, axes in enumerate(figure.axes, start=1):
        labels = axes.get_xlabel(), axes.get_ylabel()
        named = _tick_names(axes.xaxis), _tick_names(axes.yaxis)
        for curve, x, y in (*_lines(axes), *_bars(axes), *_maps(axes)):
            yield panel, curve, labels[0], x, labels[1], y, named[0].get(x) or named[1].get(y, "")


def _tick_names(axis: Axis) -> dict[float, str]:
    if not isinstance(axis.get_major_formatter(), FuncFormatter):
        return {}
    labels = (tick.get_text().replace("\n", " ") for tick in axis.get_majorticklabels())
    return dict(zip(map(float, axis.get_majorticklocs()), labels, strict=True))


def _lines(axes: Axes) -> Iterator[tuple[str, float, float]]:
    error_bars = (bars for bars in axes.containers if isinstance(bars, ErrorbarContainer))
    names = {bars.lines[0]: str(bars.get_label()) for bars in error_bars}
    for n, line in enumerate(axes.get_lines(), start=1):
        name = names.get(line, str(line.get_label()))
        for x, y in np.asarray(line.get_xydata(), float):
            yield (f"curve {n}" if name.startswith("_") else name), float(x), float(y)


def _bars(axes: Axes) -> Iterator[tuple[str, float, float]]:
    for bars in axes.containers:
        for bar in getattr(bars, "patches", ()):
            yield "bars", float(bar.get_x() + bar.get_width() / 2), float(bar.get_height())


def _maps(axes: Axes) -> Iterator[tuple[str, float, float]]:
    """Yield the position of the largest value of each map."""
    for image in axes.get_images():
        values = np.asarray(image.get_array(), float)
        left, right, bottom, top = image.get_extent()
        row, column = np.unravel_index(np.nanargmax(np.abs(values)), values.shape)
        x = left + (right - left) * column / max(values.shape[1] - 1, 1)
        y = bottom + (top - bottom) * row / max(values.shape[0] - 1, 1)
        yield f"map, largest value {values[row, column]:.6g}", float(x), float(y)
