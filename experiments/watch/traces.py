"""Plots of sensor samples during the last touch, from its request to its end."""

from pathlib import Path

import numpy as np

from tactometry.analysis.wording import number_text
from tactometry.errors import InvalidFile
from tactometry.records.traces import kind_of, read_part
from tactometry.session.progress import AnsweredTouch
from tactometry.session.request import Press, Slide
from tactometry.signal import FloatArray

from .plots import Plot, samples_plot
from .sight import TouchDrawn

MOST_BINS = 150
LABELS = {"force": ("Force", "force (N)"), "position": ("Position", "position (m)")}


def draw_touch(root: Path, touch: AnsweredTouch) -> TouchDrawn:
    """Plot the recorded samples of a touch, or state why they are unreadable."""
    plots: list[Plot] = []
    try:
        for part in touch.answer.trace:
            kind = kind_of(part)
            if kind in LABELS:
                plot = _plot(kind, read_part(root, part), touch)
                plots += [] if plot is None else [plot]
    except InvalidFile as error:
        return TouchDrawn(problem=str(error))
    return TouchDrawn(tuple(plots))


def _plot(kind: str, rows: FloatArray, touch: AnsweredTouch) -> Plot | None:
    """Plot time stamps (s of the session) and values against onset time."""
    title, label = LABELS[kind]
    times_s, values = rows[:, 0] - touch.answer.onset_s, rows[:, 1:]
    played_s = (0.0, touch.request.duration_s) if touch.answer.played else None
    return samples_plot(
        kind,
        title,
        label,
        [thinned(times_s, along) for along in values.T],
        wanted=_band(touch.request) if kind == "force" else None,
        playing_s=played_s,
        further=_health(times_s, values),
    )


def _band(request: Press | Slide) -> tuple[float, float]:
    return request.target_n * (1 - request.tolerance), request.target_n * (1 + request.tolerance)


def _health(times_s: FloatArray, values: FloatArray) -> str:
    """Describe the sampling rate, lost samples and longest gap of a sensor."""
    if len(times_s) < 2:
        return ""
    n_lost = int(np.isnan(values).any(axis=1).sum())
    rate_hz, longest_s = (len(times_s) - 1) / max(np.ptp(times_s), 1e-9), np.diff(times_s).max()
    lost = f", {n_lost} lost" if n_lost else ""
    return f"{number_text(rate_hz)} samples per second, {number_text(1e3 * longest_s)} ms apart at most{lost}."


def thinned(times_s: FloatArray, values: FloatArray, n_bins: int = MOST_BINS) -> list[tuple[float, float]]:
    """Return fewer points that draw the same line as all samples.

    Each bin keeps its lowest and its highest sample.

    >>> thinned(np.arange(6.0), np.array([0.0, 5.0, 1.0, 1.0, -2.0, 1.0]), n_bins=2)
    [(0.0, 0.0), (1.0, 5.0), (3.0, 1.0), (4.0, -2.0)]
    """
    known = np.flatnonzero(np.isfinite(values))
    if len(known) > 2 * n_bins:
        bins = np.array_split(known, n_bins)
        ends = [(bin_[values[bin_].argmin()], bin_[values[bin_].argmax()]) for bin_ in bins]
        known = np.unique(ends)
    return list(zip(times_s[known].tolist(), values[known].tolist(), strict=True))
