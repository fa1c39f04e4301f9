"""What a scene gives over time: a panel per output, numbers in the title."""

from collections.abc import Mapping
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tactometry.palette import BLUE, GOLD, GREEN, ORANGE, PINK, SKY

from ..lifting import FORCE, loads_n
from ..result import Result, unit_of

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
    """All outputs that are courses over ``t_s``, one above the other; single numbers in the title."""
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
    """The outputs that are courses over a time, one or a row for each contact."""
    n = len(values[time])
    return [name for name, value in values.items() if np.ndim(value) and np.shape(value)[-1] == n and name != time]


def draw_course(panel: Axes, t_s: Any, course: Any, name: str, colour: str) -> None:
    """One course with its unit; of several contacts each has a line style."""
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
    """What a course alone does not show: where a finger sticks and slips, or would lift off."""
    if name in RUBBED and "slip_events_s" in result.values:
        events_s = np.asarray(result.values["slip_events_s"])[:MOST_EVENTS]
        for event_s in events_s:
            panel.axvline(event_s * 1e3, color=FAINT, linewidth=0.5, zorder=0)
        if events_s.size:
            panel.set_title("lines: beginnings of slip and stick", fontsize="x-small", loc="right")
    if name == FORCE:
        factor, _ = prefix_of(float(np.abs(result.values[name]).max()))
        for load_n in loads_n(result.plan):
            panel.axhline(-load_n / factor, color="black", linewidth=0.6, linestyle=":")
        panel.set_title(BESIDE_LOAD, fontsize="x-small", loc="right")


def numbers(values: Mapping[str, Any]) -> list[str]:
    """Single numbers in words."""
    return [f"{label(name)}: {reading(name, value)}" for name, value in values.items() if np.ndim(value) == 0]


def reading(name: str, value: float) -> str:
    """A number with a unit and a prefix.

    >>> reading("peak_m", 1.5e-5), reading("sensation_db", 12.0)
    ('15 µm', '12 dB SL')
    """
    unit = unit_of(name)
    factor, prefix = (1.0, "") if unit.startswith("dB") else prefix_of(abs(value))
    return f"{value / factor:.4g} {prefix}{unit}".rstrip()


def label(name: str) -> str:
    """A quantity's name without its unit.

    >>> label("friction_force_n"), label("sensation_db")
    ('friction force', 'sensation')
    """
    from tactometry.config.quantity import unit_suffix

    suffix = unit_suffix(name) or ("db" if name.endswith("_db") else "dba" if name.endswith("_dba") else "")
    return name.removesuffix(f"_{suffix}").replace("_", " ")


def prefix_of(value: float) -> tuple[float, str]:
    """The prefix that leaves a number of at least 1.

    >>> prefix_of(0.02)
    (0.001, 'm')
    """
    return next((pair for pair in PREFIXES if value >= pair[0]), PREFIXES[0] if value == 0 else PREFIXES[-1])
