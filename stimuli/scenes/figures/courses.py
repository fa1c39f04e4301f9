"""Time courses of a scene: one panel per output, numbers in the title."""

import shutil
from collections.abc import Mapping
from functools import cache
from importlib.util import find_spec
from io import BytesIO
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import animation, colormaps, rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure, SubFigure
from PIL import Image

from tactometry.arguments.require import expect
from tactometry.palette import BLUE, GOLD, GREEN, ORANGE, PINK, SKY

from ...time_reversal.focusing.merit import HALF, area_m2
from ..plan import FORCE, Result, loads_n, unit_of

COLOURS = (BLUE, ORANGE, GREEN, PINK, SKY, GOLD)
STYLES = ("-", "--", ":", "-.")
WIDTH_IN = 7.0
PANEL_IN = 1.7
PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
MOST_POINTS = 20_000
MOST_EVENTS = 200
RUBBED = ("friction_force_n", "skin_displacement_m")
FAINT = "#999999"
BESIDE_LOAD = "on top of the load; dotted: minus the load, where a finger lifts off"


def courses(result: Result, title: str) -> Figure:
    """Plot all outputs over ``t_s``, with single numbers in the title."""
    t_s, drawn = result.values["t_s"], names(result.values)
    figure = Figure(figsize=(WIDTH_IN, PANEL_IN * len(drawn) + 0.9), layout="constrained")
    panels = figure.subplots(len(drawn), 1, sharex=True, squeeze=False)[:, 0]
    for panel, name, colour in zip(panels, drawn, cycle(COLOURS), strict=False):
        draw_course(panel, t_s, result.values[name], name, colour)
        mark(panel, result, name)
    figure.align_ylabels(panels)
    panels[-1].set_xlabel("time (ms)")
    figure.suptitle("\n".join([title, *numbers(result.values)]), fontsize="medium")
    return figure


def names(values: Mapping[str, Any], time: str = "t_s") -> list[str]:
    """Return the names of the outputs that are time courses."""
    n = len(values[time])
    return [name for name, value in values.items() if np.ndim(value) and np.shape(value)[-1] == n and name != time]


def draw_course(panel: Axes, t_s: Any, course: Any, name: str, colour: str) -> None:
    """Plot one course with its unit, with a line style for each contact."""
    factor, prefix = prefix_of(float(np.abs(course).max()))
    step, rows = -(-len(t_s) // MOST_POINTS), np.atleast_2d(course)
    for n, (row, style) in enumerate(zip(rows, cycle(STYLES), strict=False), 1):
        drawn = t_s[::step] * 1e3, row[::step] / factor
        panel.plot(*drawn, color=colour, linewidth=0.8, linestyle=style, label=f"finger {n}")
    if len(rows) > 1:
        panel.legend(fontsize="x-small", loc="upper left", frameon=False)
    panel.set_ylabel(f"{label(name)}\n({prefix}{unit_of(name)})")
    panel.grid(alpha=0.3)
    panel.spines[["top", "right"]].set_visible(False)


def mark(panel: Axes, result: Result, name: str) -> None:
    """Mark stick, slip and lift-off in a panel."""
    if name in RUBBED and "slip_events_s" in result.values:
        events_s = np.asarray(result.values["slip_events_s"])[:MOST_EVENTS]
        for event_s in events_s:
            panel.axvline(event_s * 1e3, color=FAINT, linewidth=0.5, zorder=0)
        if events_s.size:
            panel.set_title("lines: onsets of slip and stick", fontsize="x-small", loc="right")
    if name == FORCE:
        factor, _ = prefix_of(float(np.abs(result.values[name]).max()))
        for load_n in loads_n(result.plan):
            panel.axhline(-load_n / factor, color="black", linewidth=0.6, linestyle=":")
        panel.set_title(BESIDE_LOAD, fontsize="x-small", loc="right")


def numbers(values: Mapping[str, Any]) -> list[str]:
    """Format the outputs that are single numbers."""
    return [f"{label(name)}: {reading(name, value)}" for name, value in values.items() if np.ndim(value) == 0]


def reading(name: str, value: float) -> str:
    """Format a number with a unit and a prefix.

    >>> reading("peak_m", 1.5e-5), reading("sensation_db", 12.0)
    ('15 µm', '12 dB SL')
    """
    unit = unit_of(name)
    factor, prefix = (1.0, "") if unit.startswith("dB") else prefix_of(abs(value))
    return f"{value / factor:.4g} {prefix}{unit}".rstrip()


def label(name: str) -> str:
    """Return a quantity's name without its unit.

    >>> label("friction_force_n"), label("sensation_db")
    ('friction force', 'sensation')
    """
    from tactometry.config.quantity import unit_suffix

    suffix = unit_suffix(name) or ("db" if name.endswith("_db") else "dba" if name.endswith("_dba") else "")
    return name.removesuffix(f"_{suffix}").replace("_", " ")


def prefix_of(value: float) -> tuple[float, str]:
    """Return the unit prefix that makes a number at least 1.

    >>> prefix_of(0.02)
    (0.001, 'm')
    """
    return next((pair for pair in PREFIXES if value >= pair[0]), PREFIXES[0] if value == 0 else PREFIXES[-1])


MAPS_WIDTH_IN, MAP_IN, HEAD_IN, AXIS_IN = 10.0, 3.6, 0.5, 0.3
SLIDING_TIME = "sliding_t_s"
NEAR_M, NEAR_S = 15e-3, 0.25e-3
AROUND = 1.5
DIVERGING = "RdBu_r"


def focus_sheet(result: Result, title: str) -> Figure:
    """Plot the map, its centre lines and all courses, numbers in the title."""
    values = result.values
    drawn = names(values) if "t_s" in values else []
    slid = names(values, SLIDING_TIME) if SLIDING_TIME in values else []
    texts = numbers(values)
    lines = [title, *(";  ".join(texts[n : n + 3]) for n in range(0, len(texts), 3))]
    head_in = HEAD_IN * (1 + len(lines) / 3)
    heights = [MAP_IN, *(PANEL_IN * len(part) + AXIS_IN for part in (drawn, slid) if part)]
    figure = Figure(figsize=(MAPS_WIDTH_IN, sum(heights) + head_in), layout="constrained")
    above, *below = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0]
    _maps(above, values)
    sheets = [(draw, outputs) for draw, outputs in ((_courses, drawn), (_sliding_courses, slid)) if outputs]
    for below_map, (draw, outputs) in zip(below, sheets, strict=True):
        draw(below_map, result, outputs)
    figure.suptitle("\n".join(lines), fontsize="medium")
    return figure


def _maps(figure: SubFigure, values: Any) -> None:
    x_m, y_m, field_m = values["x_m"], values["y_m"], values["field_m"]
    whole, near = figure.subplots(1, 2, width_ratios=(1.5, 1))
    peak = np.unravel_index(np.abs(field_m).argmax(), field_m.shape)
    image = draw_map(whole, x_m, y_m, field_m, float(np.abs(field_m).max()))
    draw_map(near, x_m, y_m, field_m, float(np.abs(field_m).max()))
    near.contour(x_m * 1e3, y_m * 1e3, field_m.T / field_m[peak], levels=[HALF], colors="k", linewidths=1.0)
    half_m2 = area_m2(field_m, (x_m, y_m)) if field_m.any() else 0.0
    reach_m = max(NEAR_M, AROUND * (half_m2 / np.pi) ** 0.5)
    for axis, at_m, limit in (("x", x_m[peak[0]], near.set_xlim), ("y", y_m[peak[1]], near.set_ylim)):
        limit((at_m - reach_m) * 1e3, (at_m + reach_m) * 1e3)
        near.set(**{f"{axis}label": f"{axis} (mm)"})
    whole.set_title("focus instant", fontsize="small")
    near.set_title(f"line: half of the peak, {half_m2 * 1e6:.0f} mm²", fontsize="small")
    figure.colorbar(image, ax=near, label="displacement (µm)", shrink=0.9)


def draw_map(axes: Axes, x_m: Any, y_m: Any, field_m: Any, largest_m: float) -> Any:
    """Plot a field in µm over mm; 0 is white."""
    extent = (x_m[0] * 1e3, x_m[-1] * 1e3, y_m[0] * 1e3, y_m[-1] * 1e3)
    shown = field_m.T * 1e6
    largest = largest_m * 1e6
    image = axes.imshow(shown, origin="lower", extent=extent, cmap=DIVERGING, vmin=-largest, vmax=largest)
    axes.set(xlabel="x (mm)", ylabel="y (mm)")
    return image


def _courses(figure: SubFigure, result: Result, drawn: list[str]) -> None:
    values = result.values
    panels = figure.subplots(len(drawn), 2, squeeze=False, width_ratios=(2, 1), sharex="col")
    for row, name, colour in zip(panels, drawn, cycle(COLOURS), strict=False):
        for panel in row:
            draw_course(panel, values["t_s"], values[name], name, colour)
            mark(panel, result, name)
        row[1].set(ylabel="")
        row[1].set_title("", loc="right")  # printed next to it
        row[1].set_xlim(-NEAR_S * 1e3, NEAR_S * 1e3)
    for panel in panels[-1]:
        panel.set_xlabel("time from the focus (ms)")
    figure.align_ylabels(panels[:, 0])


def _sliding_courses(figure: SubFigure, result: Result, drawn: list[str]) -> None:
    """Draw the courses of a sliding finger on its own time axis."""
    values = result.values
    panels = figure.subplots(len(drawn), 1, squeeze=False, sharex=True)[:, 0]
    for panel, name, colour in zip(panels, drawn, cycle(COLOURS[2:]), strict=False):
        draw_course(panel, values[SLIDING_TIME], values[name], name, colour)
        mark(panel, result, name)
    panels[-1].set_xlabel("time of sliding (ms)")
    figure.align_ylabels(panels)


FORMATS = (".gif", ".mp4")
FRAMES_PER_S = 20
SIZE_IN = (6.4, 4.6)
RESOLUTION_DPI = 100
GREYS = 31
"""Colours for text and lines."""


class MapWriter(animation.AbstractMovieWriter):
    """Writer of a GIF with the colours of a map and greys. A palette per frame would be slow and lose whites."""

    def setup(self, fig: Figure, outfile: Any, dpi: float | None = None) -> None:
        super().setup(fig, outfile, dpi)
        self._pictures: list[Image.Image] = []

    def grab_frame(self, **options: Any) -> None:
        drawn = BytesIO()
        self.fig.savefig(drawn, format="rgba", dpi=self.dpi, **options)
        picture = Image.frombytes("RGBA", self.frame_size, drawn.getvalue()).convert("RGB")
        self._pictures.append(picture.quantize(palette=_palette(), dither=Image.Dither.NONE))

    def finish(self) -> None:
        first, *others = self._pictures
        first.save(self.outfile, save_all=True, append_images=others, duration=round(1e3 / self.fps), loop=0)


@cache
def _palette() -> Image.Image:
    """Return a GIF palette of 255 colours plus one for unchanged pixels."""
    of_map = colormaps[DIVERGING](np.linspace(0, 1, 255 - GREYS))[:, :3]
    greys = np.repeat(np.linspace(0, 1, GREYS), 3).reshape(GREYS, 3)
    image = Image.new("P", (1, 1))
    image.putpalette(np.rint(255 * np.concatenate([of_map, greys])).astype(np.uint8).tobytes())
    return image


def write_film(result: Result, title: str, path: Path) -> None:
    """Write the frames of ``movie_m`` as GIF or MP4.

    Raises `InvalidParameter` for another suffix, or for an MP4 if ffmpeg is missing.
    """
    writer = _writer(path)
    values = result.values
    frames, times_s = values["movie_m"], values["frames_s"]
    figure = Figure(figsize=SIZE_IN, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    image = draw_map(axes, values["x_m"], values["y_m"], frames[0], float(np.abs(frames).max()) / 2)
    figure.colorbar(image, ax=axes, label="displacement (µm), cut at half of the peak", shrink=0.8)
    figure.suptitle(title, fontsize="medium")
    with rc_context({"animation.ffmpeg_path": _ffmpeg()}), writer.saving(figure, str(path), RESOLUTION_DPI):
        for time_s, frame in zip(times_s, frames, strict=True):
            image.set_data(frame.T * 1e6)
            axes.set_title(f"{time_s * 1e6:+.0f} µs from the focus", fontsize="small")
            writer.grab_frame()
            figure.set_layout_engine("none")  # all frames use the layout of the first


def _writer(path: Path) -> Any:
    expect(path.suffix in FORMATS, "--movie", repr(str(path)), f"a file name that ends in {' or '.join(FORMATS)}")
    if path.suffix == ".gif":
        return MapWriter(fps=FRAMES_PER_S)
    expected = "ffmpeg; install it or the package imageio-ffmpeg (the extra film), or write a .gif"
    expect(bool(_ffmpeg()), "--movie", "no ffmpeg, which MP4 needs", expected)
    return animation.FFMpegWriter(fps=FRAMES_PER_S)


def _ffmpeg() -> str:
    """Return the path of ffmpeg, of the system or imageio-ffmpeg, or ""."""
    program = shutil.which("ffmpeg")
    if program or not find_spec("imageio_ffmpeg"):
        return program or ""
    from imageio_ffmpeg import get_ffmpeg_exe

    return str(get_ffmpeg_exe())
