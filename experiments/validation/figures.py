"""Figures of the page: coverage of intervals, shares of significant tests, ranks of truths."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import binom

from tactometry.analysis.figures.style import Drawing, drawing_of, look, new_figure
from tactometry.files.durable import make_folder, write_atomically

from .check import Check
from .checks import check_of
from .kinds import ALPHA, N_BINS
from .run import Validated

FOLDER = "validated"
GREY = "#666666"
ROW_IN, TOP_IN, WIDTH_IN = 0.2, 0.9, 7.0
COLUMNS = 3


def write_figures(found: Validated, folder: Path, *, as_pixels: bool) -> None:
    """An SVG of each check that has a figure, and a PNG where pixels are wanted.

    Raises
    ------
    DeviceFailed
        If a file cannot be written.
    """
    make_folder(folder)
    for name, table in found.tables.items():
        check = check_of(name)
        if check.figure:
            drawing = drawn(check, table)
            write_atomically(folder / f"{check.figure}.svg", drawing.svg.encode())
            if as_pixels:
                write_atomically(folder / f"{check.figure}.png", drawing.png())


def drawn(check: Check, table: pd.DataFrame) -> Drawing:
    """Ranks as histograms, all else as shares."""
    return rank_histograms(check, table) if check.kind.name == "ranks" else shares(check, table)


def shares(check: Check, table: pd.DataFrame) -> Drawing:
    """Each row's share with its 95 % interval beside what is stated, in a panel for each method."""
    told = table[table["n"] > 0]
    methods = _distinct(told, check.reason_key)
    others = [key for key in check.keys if key != check.reason_key]
    labels = list(dict.fromkeys(_label(row, others) for row in told.to_dict("records")))
    with new_figure(WIDTH_IN, TOP_IN + ROW_IN * max(len(labels), 4) + 0.12 * len(methods)) as figure:
        axes = figure.add_subplot()
        apart = 0.8 / len(methods)
        for place, method in enumerate(methods):
            rows = told[told[check.reason_key] == method]
            y = [
                labels.index(_label(row, others)) + apart * (place - (len(methods) - 1) / 2)
                for row in rows.to_dict("records")
            ]
            x = 100 * rows["share"]
            reach = [x - 100 * rows["low"], 100 * rows["high"] - x]
            style = look(place) | {"linestyle": "", "markersize": 3.0, "elinewidth": 0.8}
            axes.errorbar(x, y, xerr=np.maximum(reach, 0.0), label=str(method), **style)
        for stated in sorted(set(told["stated"].dropna())):
            axes.axvline(100 * stated, color=GREY, linewidth=0.8, linestyle="--")
        axes.set_yticks(range(len(labels)), labels)
        axes.set_ylim(len(labels) - 0.4, -0.6)
        what = check.kind.heads["share"].replace(" / %", " (%)")
        axes.set_xlabel(f"{what}, dashed: as stated;\nof equal methods the first is drawn")
        axes.grid(axis="y", linewidth=0.3)
        figure.legend(loc="outside upper center", ncols=COLUMNS)
        return drawing_of(figure)


def _distinct(table: pd.DataFrame, key: str) -> list[Any]:
    """Methods whose shares are not those of one before: three estimates of one posterior share their interval."""
    seen: dict[Any, tuple[float, ...]] = {}
    for method in dict.fromkeys(table[key]):
        its_shares = tuple(table.loc[table[key] == method, "share"])
        if its_shares not in seen.values():
            seen[method] = its_shares
    return list(seen)


def _label(row: Mapping[Any, Any], keys: list[str]) -> str:
    return ", ".join(_worded(key, row[key]) for key in keys) or "all"


def _worded(key: str, value: object) -> str:
    """Texts stand alone, numbers with their names."""
    return value if isinstance(value, str) else f"{key.replace('_', ' ')} {value:g}"


def rank_histograms(check: Check, table: pd.DataFrame) -> Drawing:
    """Of each posterior how many truths rank in each twentieth, with the band that chance leaves once in 1e4 bins."""
    n_rows = -(-len(table) // COLUMNS)
    with new_figure(WIDTH_IN, 0.4 + 1.7 * n_rows) as figure:
        panels = figure.subplots(n_rows, COLUMNS, sharex=True, squeeze=False).ravel()
        for axes, row in zip(panels, table.to_dict("records"), strict=False):
            n = row["sets"]
            counts = [row[f"bin_{place:02d}"] for place in range(1, N_BINS + 1)]
            edges = np.arange(N_BINS + 1) / N_BINS
            axes.stairs(counts, edges, fill=True, color=look(0)["color"])
            axes.axhspan(
                binom.ppf(ALPHA / 2, n, 1 / N_BINS), binom.isf(ALPHA / 2, n, 1 / N_BINS), color=GREY, alpha=0.25
            )
            axes.set_ylim(0, None)
            axes.set_title(", ".join(str(row[key]) for key in check.keys), fontsize=7.0)
        for place, axes in enumerate(panels):
            axes.set_visible(place < len(table))
            axes.tick_params(labelbottom=place + COLUMNS >= len(table))
        figure.supxlabel("Rank of the truth in its posterior")
        figure.supylabel("Simulated sets")
        return drawing_of(figure)
