"""Figures of validation: shares with intervals, and histograms of ranks."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import binom

from tactometry.analysis.figures.style import Drawing, drawing_of, look, new_figure
from tactometry.files.durable import make_folder, write_atomically

from .check import ALPHA, N_BINS, Check
from .checks import check_of
from .run import Validated

FOLDER = "validated"
GREY = "#666666"
ROW_IN, TOP_IN, WIDTH_IN = 0.2, 0.9, 7.0
COLUMNS = 3


def write_figures(found: Validated, folder: Path, *, as_pixels: bool) -> None:
    """Write SVG figures of the checks. With `as_pixels`, write PNGs too."""
    make_folder(folder)
    for name, table in found.tables.items():
        check = check_of(name)
        if check.figure:
            drawing = rank_histograms(check, table) if check.kind.name == "ranks" else shares(check, table)
            write_atomically(folder / f"{check.figure}.svg", drawing.svg.encode())
            if as_pixels:
                write_atomically(folder / f"{check.figure}.png", drawing.png())


def shares(check: Check, table: pd.DataFrame) -> Drawing:
    """Plot the share in each row with its 95 % interval."""
    result = table[table["n"] > 0]
    methods = _distinct(result, check.reason_key)
    others = [key for key in check.keys if key != check.reason_key]
    row_labels = pd.Series([_label(row, others) for row in result.to_dict("records")], index=result.index)
    labels = list(dict.fromkeys(row_labels))
    with new_figure(WIDTH_IN, TOP_IN + ROW_IN * max(len(labels), 4) + 0.12 * len(methods)) as figure:
        axes = figure.add_subplot()
        apart = 0.8 / len(methods)
        for place, method in enumerate(methods):
            rows = result[result[check.reason_key] == method]
            y = row_labels[rows.index].map(labels.index) + apart * (place - (len(methods) - 1) / 2)
            x = 100 * rows["share"]
            reach = [x - 100 * rows["low"], 100 * rows["high"] - x]
            style = look(place) | {"linestyle": "", "markersize": 3.0, "elinewidth": 0.8}
            axes.errorbar(x, y, xerr=np.maximum(reach, 0.0), label=str(method), **style)
        for stated in sorted(set(result["stated"].dropna())):
            axes.axvline(100 * stated, color=GREY, linewidth=0.8, linestyle="--")
        axes.set_yticks(range(len(labels)), labels)
        axes.set_ylim(len(labels) - 0.4, -0.6)
        quantity = check.kind.heads["share"].replace(" / %", " (%)")
        axes.set_xlabel(f"{quantity}, dashed: as stated;\nof equal methods the first is drawn")
        axes.grid(axis="y", linewidth=0.3)
        figure.legend(loc="outside upper center", ncols=COLUMNS)
        return drawing_of(figure)


def _distinct(table: pd.DataFrame, key: str) -> list[Any]:
    """Return the methods, but only the first of those with equal shares."""
    seen: dict[tuple[float, ...], Any] = {}
    for method in dict.fromkeys(table[key]):
        seen.setdefault(tuple(table.loc[table[key] == method, "share"]), method)
    return list(seen.values())


def _label(row: Mapping[Any, Any], keys: list[str]) -> str:
    names = (row[key] if isinstance(row[key], str) else f"{key.replace('_', ' ')} {row[key]:g}" for key in keys)
    return ", ".join(names) or "all"


def rank_histograms(check: Check, table: pd.DataFrame) -> Drawing:
    """Plot histograms of ranks, with the 99.99 % band of a bin's count."""
    n_rows = -(-len(table) // COLUMNS)
    with new_figure(WIDTH_IN, 0.4 + 1.7 * n_rows) as figure:
        panels = figure.subplots(n_rows, COLUMNS, sharex=True, squeeze=False).ravel()
        for axes, row in zip(panels, table.to_dict("records"), strict=False):
            counts = [row[f"bin_{place:02d}"] for place in range(1, N_BINS + 1)]
            axes.stairs(counts, np.arange(N_BINS + 1) / N_BINS, fill=True, color=look(0)["color"])
            expected = binom(row["sets"], 1 / N_BINS)
            axes.axhspan(expected.ppf(ALPHA / 2), expected.isf(ALPHA / 2), color=GREY, alpha=0.25)
            axes.set_ylim(0, None)
            axes.set_title(", ".join(str(row[key]) for key in check.keys), fontsize=7.0)
        for place, axes in enumerate(panels):
            axes.set_visible(place < len(table))
            axes.tick_params(labelbottom=place + COLUMNS >= len(table))
        figure.supxlabel("Rank of the truth in its posterior")
        figure.supylabel("Simulated sets")
        return drawing_of(figure)
