"""Common parts of figures: style, output, and assignment of factors."""

import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tactometry.palette import COLOURS

from ..arrays import Array
from ..wording import condition_name, title_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PRINT_DPI = 300
PACKING = 2
"""PNG compression (0 to 9): twice as fast as the default, with slightly larger files."""
LIGHTEST = 0.8
"""Lightest position in viridis that is visible on white."""
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
_SETTINGS: dict[str, Any] = {
    "svg.fonttype": "none",  # keep text as text, so that it can be searched and edited
    "svg.hashsalt": "tactometry",  # fixed salt, as element names are random by default
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "axes.titlesize": 9.0,
    "legend.frameon": False,
    "lines.linewidth": 1.3,
    "lines.markersize": 4.0,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
}


@contextmanager
def house_style() -> Iterator[None]:
    """Apply the settings of all figures."""
    import matplotlib as mpl

    with mpl.rc_context():
        mpl.rcdefaults()  # ignore the user's matplotlib settings
        mpl.rcParams.update(_SETTINGS)  # type: ignore[arg-type,unused-ignore]
        yield


@contextmanager
def new_figure(width_in: float, height_in: float) -> "Iterator[Figure]":
    """Yield a figure without a window, in the common style."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    with house_style():
        figure = Figure(figsize=(width_in, height_in), layout="constrained")
        # pyplot would keep every figure and open windows.
        FigureCanvasSVG(figure)
        yield figure


@dataclass(frozen=True)
class Drawing:
    """A finished figure with reproducible output bytes."""

    figure: "Figure"
    svg: str
    """SVG element without a date."""
    about: str | None = None
    """Description written into the file."""

    def png(self) -> bytes:
        """Return the figure as PNG at print resolution."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        target, dpi = io.BytesIO(), self.figure.dpi
        with house_style():
            self.figure.set_dpi(PRINT_DPI)
            canvas: Any = FigureCanvasAgg(self.figure)
            about = {"Description": self.about} if self.about else {}
            # Omit "Software", which would contain the matplotlib version.
            canvas.print_png(target, metadata={"Software": None, **about}, pil_kwargs={"compress_level": PACKING})
            self.figure.set_dpi(dpi)
        return target.getvalue()


def drawing_of(figure: "Figure", about: str | None = None) -> Drawing:
    """Finish a figure; `about` is its description in the file."""
    target = io.StringIO()
    # `savefig` would draw everything twice.
    metadata = {"Date": None, "Creator": "tactometry", "Description": about}
    figure.canvas.print_svg(target, metadata=metadata)  # type: ignore[attr-defined]
    figure.set_layout_engine("none")  # reuse the layout for the PNG
    text = target.getvalue()
    # Omit the XML declaration, as the drawing is embedded in the page.
    return Drawing(figure, text[text.index("<svg") :], about)


def look(place: int) -> dict[str, Any]:
    """Return colour and marker of a series; reused colours have open markers."""
    style: dict[str, Any] = {"color": COLOURS[place % len(COLOURS)], "marker": MARKERS[place % len(MARKERS)]}
    return style | ({"mfc": "white"} if place >= len(COLOURS) else {})


def shades(n: int) -> Sequence[tuple[float, float, float, float]]:
    """Return n colours ordered from dark to light."""
    import matplotlib as mpl

    return [mpl.colormaps["viridis"](LIGHTEST * place / max(1, n - 1)) for place in range(n)]


LOG_RANGE = 4.0
SPREAD, MOST_SPREAD = 0.18, 0.7
STEP_ALONE = 1.0
"""Step of an axis with a single position."""


@dataclass(frozen=True)
class FactorAxis:
    """Factor along the x axis, and factors that form the series."""

    along: str | None
    series: tuple[str, ...]

    @classmethod
    def of(cls, table: pd.DataFrame, factors: Sequence[str]) -> "FactorAxis":
        """Put the numeric factor with the most levels along x."""
        numeric = [name for name in factors if pd.api.types.is_numeric_dtype(table[name])]
        along = max(numeric or list(factors), key=lambda name: table[name].nunique(), default=None)
        return cls(along, tuple(name for name in factors if name != along))

    def place(self, axes: "Axes", table: pd.DataFrame) -> dict[object, float]:
        """Set up the x axis and return the position of each level."""
        from matplotlib.ticker import NullLocator

        levels: list[Any] = ["all"] if self.along is None else sorted(set(table[self.along]))
        axes.set_xlabel("" if self.along is None else title_of(self.along))
        if not all(isinstance(level, int | float | np.number) for level in levels):
            axes.set_xticks(range(len(levels)), [str(level) for level in levels])
            return _centred(axes, {level: float(n) for n, level in enumerate(levels)})
        if levels[0] > 0 and levels[-1] / levels[0] > LOG_RANGE:
            axes.set_xscale("log")
            axes.xaxis.set_minor_locator(NullLocator())  # no ticks between the levels
        axes.set_xticks([float(level) for level in levels], [f"{level:g}" for level in levels])
        return _centred(axes, {level: float(level) for level in levels})

    def x(self, rows: pd.DataFrame, where: Mapping[object, float]) -> Array:
        """Return the x positions of rows."""
        values = ["all"] * len(rows) if self.along is None else rows[self.along]
        return np.array([where[value] for value in values])

    def lines(self, table: pd.DataFrame) -> Iterator[tuple[str, pd.DataFrame, tuple[float, float, float, float]]]:
        """Return the rows at each level of the x factor, with name and colour."""
        groups = series(table, [self.along] if self.along else [])
        return ((name, rows, colour) for (name, rows), colour in zip(groups, shades(len(groups)), strict=True))


def _centred(axes: "Axes", where: dict[object, float]) -> dict[object, float]:
    """Centre the axis on a single position."""
    if len(where) == 1:
        (x,) = where.values()
        axes.set_xlim(x - STEP_ALONE / 2, x + STEP_ALONE / 2)
    return where


def series(table: pd.DataFrame, names: Sequence[str]) -> list[tuple[str, pd.DataFrame]]:
    if not names:
        return [("", table)]
    grouped = table.groupby(list(names), sort=True, observed=True)
    return [(condition_name(names, key), rows) for key, rows in grouped]


def means_with_intervals(axes: "Axes", x: NDArray[Any], means: pd.DataFrame, **style: Any) -> None:
    """Draw means with intervals within and between participants.

    Without within-participants intervals, the bars are those between participants. `style` is passed to `errorbar`.
    """
    mean, between = bars(means, "mean")
    has_within = "within_low" in means.columns
    within = bars(means, "mean", "within")[1] if has_within else np.full_like(between, np.nan)
    known, is_within = np.isfinite(mean), np.isfinite(within).all(axis=0)
    reach = np.nan_to_num(np.where(is_within, within, between)[:, known], nan=0.0)
    drawn_bars = axes.errorbar(x[known], mean[known], yerr=reach, **({"capsize": 2.5, "elinewidth": 1.2} | style))
    behind = known & is_within & np.isfinite(between).all(axis=0)
    low, high = mean - between[0], mean + between[1]
    colour = drawn_bars.lines[0].get_color()
    axes.vlines(x[behind], low[behind], high[behind], color=colour, linewidth=0.6, alpha=0.7)


def bars(rows: pd.DataFrame, name: str, ends: str | None = None) -> tuple[Array, Array]:
    """Return a column, and distances (2, n_rows) to its interval ends.

    The columns of the interval begin with `ends`, by default the name of the column.
    """
    columns = name, f"{ends or name}_low", f"{ends or name}_high"
    middle, low, high = (rows[column].astype(float).to_numpy() for column in columns)
    return np.asarray(middle), np.stack([middle - low, high - middle])


def shift(place: float, n: int, where: dict[object, float], *, log: bool) -> dict[object, float]:
    """Return the positions of one of `n` series drawn side by side.

    All series together span at most `MOST_SPREAD` of the smallest step of the axis; neighbours are at most `SPREAD`
    apart.

    >>> {name: round(x, 6) for name, x in shift(1, 2, {"a": 0.0, "b": 1.0}, log=False).items()}
    {'a': 0.09, 'b': 1.09}
    """
    offset = (place - (n - 1) / 2) * min(SPREAD, MOST_SPREAD / n)
    spots = np.array(list(where.values()))
    scaled = np.log(spots) if log else spots
    step = min(np.diff(np.sort(scaled)), default=STEP_ALONE)
    moved = scaled + offset * step
    return dict(zip(where, (np.exp(moved) if log else moved).tolist(), strict=True))


@contextmanager
def grid_of(
    n: int, most: int, panel_in: tuple[float, float], margin_in: tuple[float, float], *, share_x: bool = True
) -> "Iterator[tuple[Figure, list[Axes], list[Axes]]]":
    """Yield a figure of `n` panels, at most `most` side by side.

    The axes of all panels and those of the left column follow the figure.
    """
    columns = min(most, n)
    rows = -(-n // columns)  # rounded up
    with new_figure(panel_in[0] * columns + margin_in[0], panel_in[1] * rows + margin_in[1]) as figure:
        grid = figure.subplots(rows, columns, squeeze=False, sharex=share_x, sharey=True)
        for axes in grid.flat[n:]:
            axes.set_visible(False)
        yield figure, list(grid.flat[:n]), list(grid[:, 0])


def panels(
    table: pd.DataFrame,
    axis: FactorAxis,
    draw: "Callable[[Axes, pd.DataFrame], None]",
    *,
    labels: tuple[str, str],
    height_in: float,
    share_x: bool,
) -> Drawing:
    """Draw a panel for each series with a common legend."""
    parts = series(table, axis.series)
    with grid_of(len(parts), 3, (2.6, height_in), (1.4, 0.4), share_x=share_x) as (figure, grid, left):
        for axes, (name, panel) in zip(grid, parts, strict=True):
            draw(axes, panel)
            axes.set_title(name)
            axes.set_xlabel(labels[0])
        for axes in left:
            axes.set_ylabel(labels[1])
        if axis.along:
            figure.legend(*grid[0].get_legend_handles_labels(), loc="outside right center")
        return drawing_of(figure)
