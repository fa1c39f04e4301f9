"""One look for all figures: colours that the colour-blind tell apart, vector output with equal bytes for
equal data."""

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tactometry.palette import COLOURS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PRINT_DPI = 300
LIGHTEST = 0.8
"""Of viridis (dark to light): lighter is too faint on white."""
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
_SETTINGS: dict[str, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "tactometry",
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
    """Draw within this."""
    import matplotlib as mpl

    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_SETTINGS)  # type: ignore[arg-type,unused-ignore]
        yield


def new_figure(width_in: float, height_in: float) -> "Figure":
    """A figure that no window knows of."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width_in, height_in), layout="constrained")
    FigureCanvasSVG(figure)
    return figure


@dataclass(frozen=True)
class Drawing:
    """A finished figure; the same figure gives the same bytes."""

    figure: "Figure"
    svg: str
    """An SVG element without date."""

    def png(self) -> bytes:
        """Pixels for print."""
        target = io.BytesIO()
        with house_style():
            self.figure.savefig(target, format="png", dpi=PRINT_DPI, metadata={"Software": None})
        return target.getvalue()


def drawing_of(figure: "Figure") -> Drawing:
    """The figure as it stands, within the house style."""
    target = io.StringIO()
    figure.savefig(target, format="svg", metadata={"Date": None, "Creator": "tactometry"})
    text = target.getvalue()
    return Drawing(figure, text[text.index("<svg") :])


def look(place: int) -> dict[str, Any]:
    """Colour and marker of the series at this place; open markers where the colours come again."""
    style: dict[str, Any] = {"color": COLOURS[place % len(COLOURS)], "marker": MARKERS[place % len(MARKERS)]}
    return style | ({"mfc": "white"} if place >= len(COLOURS) else {})


def shades(n: int) -> Sequence[tuple[float, float, float, float]]:
    """n ordered colours, dark to light, for an ordered factor of many levels."""
    import matplotlib as mpl

    return [mpl.colormaps["viridis"](LIGHTEST * place / max(1, n - 1)) for place in range(n)]
