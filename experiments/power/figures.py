"""Figure of power and false positives over the number of participants."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from tactometry.analysis.figures.style import Drawing, drawing_of, look, new_figure

from .design import PowerDesign
from .summary import PowerEstimate

GREY = "#666666"
APART = 0.12
"""Distance between curves of different numbers of trials, in participants."""


def power_curves(design: PowerDesign, points: Sequence[PowerEstimate]) -> Drawing:
    """Plot power with its target, and false positives with alpha below."""
    with new_figure(6.0, 5.2) as figure:
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2.6, 1))
        for place, n_trials in enumerate(dict.fromkeys(point.n_trials for point in points)):
            of_trials = [point for point in points if point.n_trials == n_trials]
            label = f"{n_trials} trials a track" if n_trials else "trials of the study"
            _curve(above, of_trials, "power", place, label)
            _curve(below, of_trials, "false_positives", place, label)
        above.axhline(design.target, color=GREY, linestyle="--", linewidth=0.8, label=f"target {design.target:g}")
        below.axhline(
            design.alpha, color=GREY, linestyle=":", linewidth=1.0, label=f"significance level {design.alpha:g}"
        )
        above.set(ylabel="Power", ylim=(0, 1.02), title=f"{design.effect.words()} ({design.dependent}, simulated)")
        highest = max(point.false_positives_high for point in points)
        below.set(ylabel="False positives", xlabel="Participants", ylim=(0, max(1.05 * highest, 2 * design.alpha)))
        below.set_xticks(sorted({point.n_participants for point in points}))
        handles = [*above.get_legend_handles_labels()[0], *below.get_legend_handles_labels()[0][:1]]
        figure.legend(handles=handles, loc="outside lower center", ncols=2)
        return drawing_of(figure)


def _curve(axes: Axes, points: Sequence[PowerEstimate], name: str, place: int, label: str) -> None:
    shares, low, high = ([getattr(point, f"{name}{end}") for point in points] for end in ("", "_low", "_high"))
    errors = np.maximum([np.subtract(shares, low), np.subtract(high, shares)], 0.0)
    x = [point.n_participants + APART * place for point in points]
    axes.errorbar(x, shares, errors, label=label, capsize=2.0, **look(place))
