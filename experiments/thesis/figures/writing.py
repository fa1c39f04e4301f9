"""Drawings of reproductions as files: the picture, and its curves as numbers."""

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


def write_drawing(figure: Figure, folder: Path, name: str) -> list[Path]:
    """NAME.png, and NAME.csv with a row for each point of each curve; the paths.

    Raises
    ------
    DeviceFailed
        If a file cannot be written.
    """
    picture, numbers = folder / f"{name}.png", folder / f"{name}.csv"
    with attempt(picture, "cannot write", "a place to write to"):
        folder.mkdir(parents=True, exist_ok=True)
        figure.savefig(picture, dpi=RESOLUTION_DPI)
    write_rows(HEAD, points(figure), numbers)
    return [picture, numbers]


def points(figure: Figure) -> Iterator[tuple[int | str | float, ...]]:
    """The points of all curves, bars and maps of a figure, in the units of its axes; `place` is the word at a tick."""
    for panel, axes in enumerate(figure.axes, start=1):
        labels = axes.get_xlabel(), axes.get_ylabel()
        named = _words(axes.xaxis), _words(axes.yaxis)
        for curve, x, y in _curves(axes):
            yield panel, curve, labels[0], x, labels[1], y, named[0].get(x) or named[1].get(y, "")


def _words(axis: Axis) -> dict[float, str]:
    """What stands at the ticks of an axis whose ticks were named, by their place."""
    if not isinstance(axis.get_major_formatter(), FuncFormatter):
        return {}
    labels = (tick.get_text().replace("\n", " ") for tick in axis.get_majorticklabels())
    return dict(zip(map(float, axis.get_majorticklocs()), labels, strict=True))


def _curves(axes: Axes) -> Iterator[tuple[str, float, float]]:
    with_bars = {
        bars.lines[0]: str(bars.get_label()) for bars in axes.containers if isinstance(bars, ErrorbarContainer)
    }
    for n, line in enumerate(axes.get_lines(), start=1):
        name = with_bars.get(line, str(line.get_label()))
        for x, y in np.asarray(line.get_xydata(), float):
            yield (f"curve {n}" if name.startswith("_") else name), float(x), float(y)
    for bars in axes.containers:
        for bar in bars.patches if hasattr(bars, "patches") else ():
            yield "bars", float(bar.get_x() + bar.get_width() / 2), float(bar.get_height())
    for image in axes.get_images():
        values = np.asarray(image.get_array(), float)
        left, right, bottom, top = image.get_extent()
        place = np.unravel_index(np.nanargmax(np.abs(values)), values.shape)
        x, y = (
            low + (high - low) * at / max(n - 1, 1)
            for low, high, at, n in zip((left, bottom), (right, top), place[::-1], values.shape[::-1], strict=True)
        )
        yield f"map, largest value {values[place]:.6g}", x, y
