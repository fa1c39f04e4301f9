"""Figures of semantic differentials."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ..attrakdiff.scoring import REGIONS
from .style import Drawing, drawing_of, look, means_with_intervals, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_STEPS = 10
"""A longer scale has ticks at every fifth of its range."""
SPREAD = 0.09
"""Distance between series at the same position, in steps of the axis."""
CENTRES = (-2.0, 0.0, 2.0)
FINE = {"capsize": 2, "elinewidth": 0.9}


def scores_figure(
    summary: pd.DataFrame, names: Sequence[str], order: Sequence[str], low: float, high: float
) -> Drawing:
    """Draw means and intervals by dimension, a series per condition."""
    with new_figure(6.6, 3.4) as figure:
        axes = figure.add_subplot()
        for n, name in enumerate(names):
            means = summary[summary["condition"] == name].set_index("dimension").reindex(list(order))
            x = np.arange(len(order)) + SPREAD * (n - (len(names) - 1) / 2)
            means_with_intervals(axes, x, means, label=name, linestyle="none", **FINE, **look(n))
        axes.set_xticks(range(len(order)), list(order))
        _scale(axes, low, high)
        axes.set_ylabel(_score_label(low))
        if len(names) > 1:
            figure.legend(loc="outside right center")
        return drawing_of(figure)


def _scale(axes: "Axes", low: float, high: float) -> None:
    axes.axhline((low + high) / 2, color="#888888", linewidth=0.8)
    axes.set_ylim(low - 0.1, high + 0.1)
    whole = high - low <= MOST_STEPS
    axes.set_yticks(np.arange(low, high + 1) if whole else np.linspace(low, high, MOST_STEPS // 2 + 1))


def _score_label(low: float) -> str:
    # The sign is meaningful only in semantic differentials.
    return "Score (positive: good)" if low < 0 else "Score"


def profile_figure(profile: pd.DataFrame, names: Sequence[str], low: float, high: float) -> Drawing:
    """Draw means of word pairs, with negative words on the left."""
    words = profile.drop_duplicates("item")
    y = np.arange(len(words))
    with new_figure(6.6, 0.21 * len(words) + 1.0) as figure:
        axes = figure.add_subplot()
        for n, name in enumerate(names):
            means = profile[profile["condition"] == name].set_index("item").reindex(words["item"])
            axes.plot(means["mean"], y, label=name, linewidth=1.0, **look(n))
        left = words["negative"].where(words["negative"] != "", words["item"])
        labels = [f"{d}  {word}" for d, word in zip(words["dimension"], left, strict=True)]
        axes.set_yticks(y, labels, fontsize=7)
        axes.set_ylim(len(words) - 0.5, -0.5)
        axes.set_xlim(low, high)
        axes.set_xlabel("Mean score")
        axes.axvline((low + high) / 2, color="#888888", linewidth=0.8)
        for edge in np.flatnonzero(words["dimension"].to_numpy()[1:] != words["dimension"].to_numpy()[:-1]):
            axes.axhline(edge + 0.5, color="#cccccc", linewidth=0.7)
        right = axes.secondary_yaxis("right")
        right.set_yticks(y, list(words["positive"]), fontsize=7)
        right.tick_params(length=0)
        if len(names) > 1:
            figure.legend(loc="outside upper center", ncols=min(7, len(names)))
        return drawing_of(figure)


def portfolio_figure(portfolio: pd.DataFrame) -> Drawing:
    """Draw pragmatic against hedonic quality, with confidence rectangles."""
    from matplotlib.patches import Rectangle

    with new_figure(5.4, 4.6) as figure:
        axes = figure.add_subplot()
        halo = {"facecolor": "white", "alpha": 0.65, "linewidth": 0, "pad": 0.8}
        for edge in (-1, 1):
            axes.axhline(edge, color="#bbbbbb", linewidth=0.8)
            axes.axvline(edge, color="#bbbbbb", linewidth=0.8)
        for along, x in enumerate(CENTRES):
            for up, y in enumerate(CENTRES):
                name = REGIONS[along][up].replace(" ", "\n").replace("-", "-\n")
                axes.text(x, y, name, color="#595959", fontsize=6.5, ha="center", va="center", zorder=1.9, bbox=halo)
        for n, row in enumerate(portfolio.to_dict("records")):
            style = look(n)
            if row["PQ_low"] is not None and row["HQ_low"] is not None and np.isfinite(row["PQ_low"] + row["HQ_low"]):
                corner = (row["PQ_low"], row["HQ_low"])
                size = (row["PQ_high"] - row["PQ_low"], row["HQ_high"] - row["HQ_low"])
                axes.add_patch(Rectangle(corner, *size, facecolor=style["color"], alpha=0.13))
                axes.add_patch(Rectangle(corner, *size, fill=False, edgecolor=style["color"], linewidth=0.9))
            axes.plot([row["PQ"]], [row["HQ"]], linestyle="none", label=row["condition"], **style)
        axes.set(xlim=(-3, 3), ylim=(-3, 3), xlabel="Pragmatic quality PQ", ylabel="Hedonic quality HQ")
        axes.set_aspect("equal")
        axes.set_anchor("W")  # a centred label would extend beyond the figure
        figure.legend(loc="outside right center")
        return drawing_of(figure)


def crossed_figure(
    summary: pd.DataFrame,
    design: Mapping[str, tuple[object, object]],
    order: Sequence[str],
    reference: str,
    limits: tuple[float, float],
) -> Drawing:
    """Draw means against envelope: a line per frequency.

    The reference is a horizontal line. `design` maps a condition to frequency and envelope.
    """
    envelopes = list(dict.fromkeys(envelope for _, envelope in design.values()))
    with new_figure(1.75 * len(order) + 0.9, 3.2) as figure:
        panels = figure.subplots(1, len(order), squeeze=False, sharey=True).ravel()
        for axes, dimension in zip(panels, order, strict=True):
            of_dimension = summary[summary["dimension"] == dimension].set_index("condition")
            _draw_reference(axes, of_dimension, reference)
            _draw_crossed(axes, of_dimension, design, envelopes)
            axes.set_title(dimension)
            axes.set_xticks(range(len(envelopes)), [str(e) for e in envelopes], rotation=40, ha="right", fontsize=7)
            axes.set_xlim(-0.4, len(envelopes) - 0.6)
            _scale(axes, *limits)
        panels[0].set_ylabel(_score_label(limits[0]))
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=3)
        return drawing_of(figure)


def _draw_reference(axes: "Axes", of_dimension: pd.DataFrame, reference: str) -> None:
    if reference not in of_dimension.index:
        return
    mean, low, high = (float(of_dimension[name].astype(float)[reference]) for name in ("mean", "mean_low", "mean_high"))
    axes.axhline(mean, color="#555555", linestyle="--", linewidth=1.0, label=f"{reference} (reference)")
    if np.isfinite(low):
        axes.axhspan(low, high, color="#555555", alpha=0.12, linewidth=0)


def _draw_crossed(
    axes: "Axes", of_dimension: pd.DataFrame, design: Mapping[str, tuple[object, object]], envelopes: Sequence[object]
) -> None:
    frequencies = list(dict.fromkeys(frequency for frequency, _ in design.values()))
    for n, frequency in enumerate(frequencies):
        codes = [code for code, (f, _) in design.items() if f == frequency and code in of_dimension.index]
        x = np.array([envelopes.index(design[code][1]) for code in codes]) + SPREAD * (n - 0.5)
        means_with_intervals(axes, x, of_dimension.loc[codes], label=f"{frequency} frequency", **FINE, **look(n))
