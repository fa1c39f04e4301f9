"""Plots as values: what a template draws as SVG, in the units of its view box. Nothing here knows a colour."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from tactometry.analysis.wording import condition_name, in_unit, plain_text, with_unit
from tactometry.errors import count_of
from tactometry.session.progress import Progress, TrackProgress
from tactometry.trials.tasks import TASKS, YES_OR_NO
from tactometry.trials.trial import Trial

WIDTH, HEIGHT = 640.0, 300.0
LEFT, RIGHT, TOP, BOTTOM = 62.0, 626.0, 14.0, 252.0
MOST_TICKS = 6
STEPS = (1.0, 2.0, 2.5, 5.0, 10.0, 20.0)


@dataclass(frozen=True)
class Ruler:
    """Values from `low` to `high` along an axis from `start` to `end`.

    >>> Ruler(0.0, 10.0, 100.0, 200.0).at(2.5), Ruler(0.0, 10.0, 100.0, 200.0).ticks
    (125.0, (0.0, 2.0, 4.0, 6.0, 8.0, 10.0))
    """

    low: float
    high: float
    start: float
    end: float

    def at(self, value: float) -> float:
        """Return the position of a value, clipped to the ends of the axis."""
        share = (min(max(value, self.low), self.high) - self.low) / (self.high - self.low)
        return round(self.start + share * (self.end - self.start), 2)

    @property
    def ticks(self) -> tuple[float, ...]:
        """Round values, at most `MOST_TICKS`."""
        size = 10.0 ** math.floor(math.log10((self.high - self.low) / MOST_TICKS))
        step = next(size * step for step in STEPS if (self.high - self.low) / (size * step) <= MOST_TICKS - 1)
        first, last = math.ceil(self.low / step - 1e-9), math.floor(self.high / step + 1e-9)
        return tuple(round(n * step, 12) for n in range(first, last + 1))


def ruler_over(values: Iterable[float], start: float, end: float, margin: float = 0.06) -> Ruler:
    """Return an axis over all values with a margin.

    A single value is centered.
    """
    known = list(values) or [0.0, 1.0]
    low, high = min(known), max(known)
    spread = high - low if high - low > 1e-9 * max(abs(low), abs(high)) else 2.0 * max(abs(high), 1.0)
    middle = (low + high) / 2
    half = (0.5 + margin) * spread
    return Ruler(middle - half, middle + half, start, end)


@dataclass(frozen=True)
class Mark:
    """A symbol at its place; `kind` names its shape: yes, no, neutral, invalid, reversal, rate."""

    x: float
    y: float
    kind: str
    size: float = 5.0


@dataclass(frozen=True)
class Stroke:
    """A line, or an area, by the points of its polyline; `kind` names its look."""

    points: str
    kind: str


@dataclass(frozen=True)
class Plot:
    """A plot with its name and what it shows in words, for who does not see it."""

    name: str
    title: str
    words: str
    x_label: str
    y_label: str
    x: Ruler
    y: Ruler
    marks: tuple[Mark, ...] = ()
    strokes: tuple[Stroke, ...] = ()
    areas: tuple[Stroke, ...] = ()

    width, height = WIDTH, HEIGHT


def polyline(x: Ruler, y: Ruler, points: Iterable[tuple[float, float]]) -> str:
    """The points of a line as SVG writes them."""
    return " ".join(f"{x.at(a):g},{y.at(b):g}" for a, b in points)


def last_presented(progress: Progress) -> Trial | None:
    """The row that was recorded last, answers to a questionnaire on its own left out."""
    last = progress.last
    if last is None or not last.is_form:
        return last
    ends = (track.presented[-1] for track in progress.tracks.values())
    return max(ends, key=lambda trial: trial.key, default=None)


def success(trial: Trial) -> bool | None:
    """Return True for an answer that the psychometric function counts.

    That is "yes", "more" or "different" where the task asks for it, else a correct answer; None without an answer.
    """
    if TASKS[trial.task].response is YES_OR_NO:
        return None if trial.response is None else trial.response == 1
    return trial.correct


def _kind(trial: Trial) -> str:
    if not trial.valid:
        return "invalid"
    return {True: "yes", False: "no", None: "neutral"}[success(trial)]


def levels_plot(name: str, title: str, track: TrackProgress) -> Plot | None:
    """The levels of a track against the number of the presentation; None without one."""
    shown = [(n, trial) for n, trial in enumerate(track.presented, 1) if trial.level is not None]
    if not shown:
        return None
    unit, turning = shown[-1][1].level_unit, track.reversals
    x = ruler_over([0.5, max(len(track.presented), 10) + 0.5], LEFT, RIGHT, margin=0.0)
    y = ruler_over((float(trial.level or 0.0) for _, trial in shown), BOTTOM, TOP)
    at = [(x.at(n), y.at(float(trial.level or 0.0)), trial) for n, trial in shown]
    rings = [Mark(a, b, "reversal", 9.0) for a, b, trial in at if trial in turning]
    answered = [(float(n), float(trial.level or 0.0)) for n, trial in shown if trial.valid]
    return Plot(
        name=name,
        title=title,
        words=_levels_words(shown[-1][1], len(track.presented), len(turning), unit),
        x_label="presentation",
        y_label=with_unit("level", unit),
        x=x,
        y=y,
        marks=(*rings, *(Mark(a, b, _kind(trial)) for a, b, trial in at)),
        strokes=(Stroke(polyline(x, y, answered), "path"),),
    )


def _levels_words(last: Trial, n_presented: int, n_reversals: int, unit: str) -> str:
    turned = f", {count_of(n_reversals, 'reversal')}" if n_reversals else ""
    level = "" if last.level is None else f"; the last level was {in_unit(plain_text(last.level), unit)}"
    return f"{count_of(n_presented, 'presentation')}{turned}{level}."


def samples_plot(
    name: str,
    title: str,
    label: str,
    lines: Sequence[Sequence[tuple[float, float]]],
    wanted: tuple[float, float] | None = None,
    playing_s: tuple[float, float] | None = None,
    further: str = "",
) -> Plot | None:
    """Plot a sensor over time with a line per axis, or return None if empty.

    It marks the `wanted` band and the time of the stimulus, and adds `further` text.
    """
    values = [value for line in lines for _, value in line if math.isfinite(value)]
    times_s = [time_s for line in lines for time_s, _ in line]
    if not values:
        return None
    x = ruler_over(times_s, LEFT, RIGHT, margin=0.0)
    y = ruler_over([*values, *(wanted or ())], BOTTOM, TOP)
    band = () if wanted is None else (_box(x, y, (x.low, x.high), wanted, "wanted"),)
    played = () if playing_s is None else (_box(x, y, playing_s, (y.low, y.high), "playing"),)
    known = ([(a, b) for a, b in line if math.isfinite(b)] for line in lines)
    return Plot(
        name=name,
        title=title,
        words=f"From {plain_text(round(min(values), 4))} to {plain_text(round(max(values), 4))}. {further}".strip(),
        x_label="time since the onset (s)",
        y_label=label,
        x=x,
        y=y,
        strokes=tuple(Stroke(polyline(x, y, line), f"axis{n}") for n, line in enumerate(known, 1)),
        areas=(*played, *band),
    )


def _box(x: Ruler, y: Ruler, across: tuple[float, float], up: tuple[float, float], kind: str) -> Stroke:
    corners = [(across[0], up[0]), (across[1], up[0]), (across[1], up[1]), (across[0], up[1])]
    return Stroke(polyline(x, y, corners), kind)


def condition_words(factors: Mapping[str, float | str]) -> str:
    """A condition in words; empty without factors.

    >>> condition_words({"frequency_hz": 240.0, "force_n": ""})
    '240 Hz'
    """
    stated = {name: level for name, level in factors.items() if level != ""}
    return condition_name(tuple(stated), tuple(stated.values())) if stated else ""
