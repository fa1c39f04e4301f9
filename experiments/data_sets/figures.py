"""Figures of a touch: force, position, speed and emitted signal."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from tactometry.analysis.figures.style import Drawing, drawing_of, new_figure
from tactometry.gates import speeds_m_per_s
from tactometry.palette import BLUE, GOLD, GREEN, ORANGE, PINK
from tactometry.rigs.texts import reason_words
from tactometry.session.answer import Touched
from tactometry.session.request import Adjust, Press, Slide
from tactometry.signal import FloatArray, Signal

from .traces import Samples, TouchTrace

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BEFORE_S: Final = 1.0
"""Time drawn before the hold that opened the gate."""
MARGIN_S: Final = 0.02
N_BINS: Final = 500
"""Largest number of points in an envelope."""
ROOM: Final = 1.1
COLUMN_IN, ROW_IN = 4.6, 1.5


class DrawnQuantity(NamedTuple):
    """Row of the figure, drawn if its quantity is `known` for a touch."""

    label: str
    known: Callable[[TouchTrace], bool]
    draw: Callable[["Axes", TouchTrace], None]
    from_zero: bool = True

    def fill(self, row: Sequence["Axes"], touches: Sequence[TouchTrace]) -> None:
        for axes, touch in zip(row, touches, strict=True):
            self.draw(axes, touch)
            if touch.played:
                axes.axvspan(0.0, _lasts_s(touch), color=GOLD, alpha=0.15, linewidth=0, label="stimulus", zorder=0)
                axes.axvline(0.0, color=ORANGE, linewidth=0.9, label="onset")
            gate_s = _gate_s(touch)
            if gate_s is not None:
                # The mark is above the axes, as the onset line follows within milliseconds and would hide it.
                at_top = axes.get_xaxis_transform()
                axes.plot(
                    gate_s, 1.02, "v", color=GREEN, transform=at_top, clip_on=False, linestyle="", label="gate opens"
                )
        row[0].set_ylabel(self.label)
        highest = max(axes.dataLim.y1 for axes in row)
        if self.from_zero and highest > 0:  # the columns share the axis, with room above
            row[0].set_ylim(min(0.0, *(axes.dataLim.y0 for axes in row)), ROOM * highest)


def touch_figure(touches: Sequence[TouchTrace]) -> Drawing:
    """Plot a column for each touch and a row for each known quantity.

    Times are relative to the onset.
    """
    rows = [row for row in _ROWS if any(map(row.known, touches))] or [_NOTHING]
    with new_figure(COLUMN_IN * len(touches) + 2.0, ROW_IN * len(rows) + 0.9) as figure:
        grid = figure.subplots(len(rows), len(touches), squeeze=False, sharex="col", sharey="row")
        for axes_of_row, row in zip(grid, rows, strict=True):
            row.fill(axes_of_row, touches)
        for touch, column in zip(touches, grid.T, strict=True):
            column[0].set_title(heading(touch))
            onset_s, request, gate_s = touch.answer.onset_s, touch.request, _gate_s(touch)
            stamps_s = [samples.times_s - onset_s for samples in (touch.force, touch.position) if samples is not None]
            first_s = min((float(times_s[0]) for times_s in stamps_s), default=0.0)
            last_s = max((float(times_s[-1]) for times_s in stamps_s), default=0.0)
            if gate_s is not None and isinstance(request, Press | Slide):
                first_s = max(first_s, gate_s - request.hold_s - BEFORE_S)
            column[0].set_xlim(min(first_s, 0.0) - MARGIN_S, max(last_s, _lasts_s(touch)) + MARGIN_S)
            column[-1].set_xlabel("Time from the onset (s)")
        named = [pair for axes in grid.flat for pair in zip(*axes.get_legend_handles_labels(), strict=True)]
        lines = {text: line for line, text in named}  # one legend entry for each name
        figure.legend(lines.values(), lines.keys(), loc="outside right upper")
        return drawing_of(figure, whose(touches))


def whose(touches: Sequence[TouchTrace]) -> str:
    """Name the participant, session and trial of touches.

    The figure's file contains this text, so that an erasure can find it.
    """
    head, trial = touches[0].head, touches[0].trial
    return f"participant {head.participant}, session {head.session}, trial {trial.trial}"


def heading(touch: TouchTrace) -> str:
    """Return the title of a touch, at most two lines."""
    answer, trial = touch.answer, touch.trial
    reason = answer.invalid_reason if isinstance(answer, Touched) else None
    if (
        reason is None and trial.invalid_reason == "experimenter"
    ):  # the touch was valid, but the experimenter cancelled the trial
        reason = "experimenter"
    interval = None if isinstance(touch.request, Adjust) else touch.request.interval
    named = {"attempt": trial.attempt if trial.attempt > 1 else None, "interval": interval}
    words = [_asked(touch), *(f"{name} {number}" for name, number in named.items() if number is not None)]
    return "\n".join([", ".join(words), *([f"not valid: {reason_words(reason)}"] if reason else [])])


def _asked(touch: TouchTrace) -> str:
    request, unit = touch.request, touch.trial.level_unit
    if isinstance(request, Adjust):
        return f"{request.stimulus}, to be set"
    return f"{request.stimulus}: blank" if request.level is None else f"{request.stimulus}: {request.level:g} {unit}"


def envelope(signal: Signal, n_bins: int = N_BINS) -> tuple[FloatArray, FloatArray]:
    """Return times (s) and the largest absolute value in each part.

    >>> envelope(Signal(np.array([[0.0, -2.0, 1.0, 0.5]]), 4.0, "V"), n_bins=2)[1].tolist()
    [2.0, 1.0]
    """
    strongest = np.abs(signal.samples).max(axis=0)
    edges = np.unique(np.linspace(0, strongest.size, n_bins + 1).astype(int)[:-1])
    return edges / signal.rate_hz, np.maximum.reduceat(strongest, edges)


def _gate_s(touch: TouchTrace) -> float | None:
    gate_s = touch.answer.gate_s if isinstance(touch.answer, Touched) else None
    return None if gate_s is None else gate_s - touch.answer.onset_s


def _lasts_s(touch: TouchTrace) -> float:
    """Return the planned duration; 0 if the onset was not planned."""
    request = touch.request
    return 0.0 if isinstance(request, Adjust) or not touch.played else request.duration_s


def _since_onset(touch: TouchTrace, samples: Samples) -> FloatArray:
    return samples.times_s - touch.answer.onset_s


def _draw_force(axes: "Axes", touch: TouchTrace) -> None:
    request = touch.request
    if isinstance(request, Press | Slide):
        half_n = request.tolerance * request.target_n
        low_n, high_n = request.target_n - half_n, request.target_n + half_n
        axes.axhspan(low_n, high_n, color=BLUE, alpha=0.12, linewidth=0, label="force to hold")
    if touch.force is not None:
        axes.plot(_since_onset(touch, touch.force), touch.force.values, color=BLUE, linewidth=1.0, label="force")


def _draw_place(axes: "Axes", touch: TouchTrace) -> None:
    if touch.position is None:
        return
    for name, along, style in zip("xyz", touch.position.values.T, ("-", "--", ":"), strict=False):
        times_s = _since_onset(touch, touch.position)
        axes.plot(times_s, 1e3 * along, style, color=PINK, linewidth=1.0, label=f"place along {name}")


def _draw_speed(axes: "Axes", touch: TouchTrace) -> None:
    request = touch.request
    if isinstance(request, Slide) and request.speed_tolerance is not None:
        half, target = 1e3 * request.speed_tolerance * request.speed_m_per_s, 1e3 * request.speed_m_per_s
        axes.axhspan(target - half, target + half, color=GREEN, alpha=0.12, linewidth=0, label="speed to keep")
    if touch.position is not None:
        times_s, speeds = speed_of(touch.position)
        axes.plot(times_s - touch.answer.onset_s, 1e3 * speeds, color=GREEN, linewidth=1.0, label="speed along x")


def speed_of(position: Samples) -> tuple[FloatArray, FloatArray]:
    """Return time stamps and the speed (m/s) along the first axis.

    Fewer than two positions have no speed.

    >>> speed_of(Samples(np.array([0.0, 0.1]), np.array([[0.0], [0.01]])))[1].round(9).tolist()
    [0.1, 0.1]
    """
    known = np.isfinite(position.values[:, 0]) & (np.diff(position.times_s, prepend=-np.inf) > 0)
    times_s, along_m = position.times_s[known], position.values[known, 0]
    return (times_s, speeds_m_per_s(times_s, along_m)) if times_s.size > 1 else (times_s[:0], along_m[:0])


def _draw_emitted(axes: "Axes", touch: TouchTrace) -> None:
    if touch.emitted is not None and touch.emitted.samples.size:
        times_s, peaks = envelope(touch.emitted)
        axes.fill_between(times_s, peaks, step="post", color=ORANGE, alpha=0.6, linewidth=0, label="emitted (envelope)")


def _draw_nothing(axes: "Axes", touch: TouchTrace) -> None:
    del touch
    axes.yaxis.set_visible(False)
    axes.text(0.5, 0.5, "no sensor data and no emitted signal", ha="center", transform=axes.transAxes)


def _moves(touch: TouchTrace) -> bool:
    return touch.position is not None


_ROWS: Final = (
    DrawnQuantity("Force (N)", lambda touch: touch.force is not None, _draw_force),
    DrawnQuantity("Place (mm)", _moves, _draw_place, from_zero=False),
    DrawnQuantity("Speed (mm/s)", _moves, _draw_speed),
    DrawnQuantity("Emitted (V)", lambda touch: touch.emitted is not None, _draw_emitted),
)
_NOTHING: Final = DrawnQuantity("", lambda touch: True, _draw_nothing)
