"""Plots of sensor samples during the last touch."""

from pathlib import Path

import numpy as np

from tactometry.analysis.wording import number_text, plain_text
from tactometry.errors import InvalidFile
from tactometry.records.traces import kind_of, read_part
from tactometry.session.progress import AnsweredTouch
from tactometry.signal import FloatArray

from .plots import BOTTOM, LEFT, RIGHT, TOP, Plot, ruler_over
from .watcher import TouchDrawn

MOST_BINS = 150
LABELS = {"force": ("Force", "force (N)"), "position": ("Position", "position (m)")}


def draw_touch(root: Path, touch: AnsweredTouch) -> TouchDrawn:
    """Plot the recorded samples of a touch, or return why they are unreadable."""
    kinds = [(kind_of(part), part) for part in touch.answer.trace]
    try:
        plots = [samples_plot(kind, read_part(root, part), touch) for kind, part in kinds if kind in LABELS]
    except InvalidFile as error:
        return TouchDrawn(problem=str(error))
    return TouchDrawn(tuple(plot for plot in plots if plot is not None))


def samples_plot(kind: str, rows: FloatArray, touch: AnsweredTouch) -> Plot | None:
    """Plot a sensor over time, with a line per axis. Returns None if empty.

    - `rows`: Time stamps (s from the start of the session) and values.
    - `touch`: Touch whose requested force and stimulus interval are drawn as areas.
    """
    times_s, values = rows[:, 0] - touch.answer.onset_s, rows[:, 1:]
    known, request = values[np.isfinite(values)], touch.request
    if not known.size:
        return None
    band = (request.target_n * (1 - request.tolerance), request.target_n * (1 + request.tolerance))
    target = band if kind == "force" else None
    low, high = float(known.min()), float(known.max())
    plot = Plot(
        name=kind,
        title=LABELS[kind][0],
        words=f"From {plain_text(round(low, 4))} to {plain_text(round(high, 4))}. {_health(times_s, values)}".strip(),
        x_label="time since the onset (s)",
        y_label=LABELS[kind][1],
        x=ruler_over(times_s.tolist(), LEFT, RIGHT, margin=0.0),
        y=ruler_over([low, high, *(target or ())], BOTTOM, TOP),
    )
    if touch.answer.played:
        plot.box("playing", (0.0, request.duration_s), (plot.y.low, plot.y.high))
    if target is not None:
        plot.box("wanted", (plot.x.low, plot.x.high), target)
    for n, along in enumerate(values.T, 1):
        plot.line(f"axis{n}", thinned(times_s, along))
    return plot


def _health(times_s: FloatArray, values: FloatArray) -> str:
    """Describe a sensor's sampling rate, lost samples and longest gap."""
    if len(times_s) < 2:
        return ""
    n_lost = int(np.isnan(values).any(axis=1).sum())
    rate_hz, longest_s = (len(times_s) - 1) / max(np.ptp(times_s), 1e-9), np.diff(times_s).max()
    lost = f", {n_lost} lost" if n_lost else ""
    return f"{number_text(rate_hz)} samples per second, {number_text(1e3 * longest_s)} ms apart at most{lost}."


def thinned(times_s: FloatArray, values: FloatArray, n_bins: int = MOST_BINS) -> list[tuple[float, float]]:
    """Return fewer points that draw the same line as all samples.

    Each bin keeps its lowest and highest sample. Missing samples are dropped.

    >>> thinned(np.arange(6.0), np.array([0.0, 5.0, 1.0, 1.0, -2.0, 1.0]), n_bins=2)
    [(0.0, 0.0), (1.0, 5.0), (3.0, 1.0), (4.0, -2.0)]
    """
    known = np.flatnonzero(np.isfinite(values))
    if len(known) > 2 * n_bins:
        bins = np.array_split(known, n_bins)
        known = np.unique([(each[values[each].argmin()], each[values[each].argmax()]) for each in bins])
    return list(zip(times_s[known].tolist(), values[known].tolist(), strict=True))
