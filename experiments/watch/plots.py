"""Plots as data that a template draws as SVG, in view box units."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from tactometry.analysis.wording import condition_name, in_unit, plain_text, with_unit
from tactometry.errors import count_of
from tactometry.session.progress import Progress, TrackProgress
from tactometry.trials.tasks import TASKS, YES_OR_NO
from tactometry.trials.trial import Trial

LEFT, RIGHT, TOP, BOTTOM = 62.0, 626.0, 14.0, 252.0
MOST_TICKS = 6
STEPS = (1.0, 2.0, 2.5, 5.0, 10.0, 20.0)
Points = Iterable[tuple[float, float]]


@dataclass(frozen=True)
class Ruler:
    """Scale: values from `low` to `high` on an axis from `start` to `end`.

    >>> Ruler(0.0, 10.0, 100.0, 200.0).at(2.5), Ruler(0.0, 10.0, 100.0, 200.0).ticks
    (125.0, (0.0, 2.0, 4.0, 6.0, 8.0, 10.0))
    """

    low: float
    high: float
    start: float
    end: float

    def at(self, value: float) -> float:
        """Return the position of a value, limited to the ends of the axis."""
        share = (min(max(value, self.low), self.high) - self.low) / (self.high - self.low)
        return round(float(self.start + share * (self.end - self.start)), 2)

    @property
    def ticks(self) -> tuple[float, ...]:
        """Round tick values, at most `MOST_TICKS`."""
        size = 10.0 ** math.floor(math.log10((self.high - self.low) / MOST_TICKS))
        step = next(size * step for step in STEPS if (self.high - self.low) / (size * step) <= MOST_TICKS - 1)
        first, last = math.ceil(self.low / step - 1e-9), math.floor(self.high / step + 1e-9)
        return tuple(round(n * step, 12) for n in range(first, last + 1))


def ruler_over(values: Iterable[float], start: float, end: float, margin: float = 0.06) -> Ruler:
    """Return a scale for values, with a margin. A single value is centred."""
    known = list(values) or [0.0, 1.0]
    low, high = min(known), max(known)
    spread = high - low if high - low > 1e-9 * max(abs(low), abs(high)) else 2.0 * max(abs(high), 1.0)
    middle = (low + high) / 2
    half = (0.5 + margin) * spread
    return Ruler(middle - half, middle + half, start, end)


class Mark(NamedTuple):
    """Symbol of a `kind`: yes, no, neutral, invalid, reversal or rate."""

    x: float
    y: float
    kind: str
    size: float = 5.0


class Stroke(NamedTuple):
    """Line or area: SVG points, and its class in the style sheet."""

    points: str
    kind: str


@dataclass(frozen=True)
class Plot:
    """Plot, with a text of its content for screen readers."""

    name: str
    title: str
    words: str
    x_label: str
    y_label: str
    x: Ruler
    y: Ruler
    marks: list[Mark] = field(default_factory=list)
    strokes: list[Stroke] = field(default_factory=list)
    areas: list[Stroke] = field(default_factory=list)

    width, height = 640.0, 300.0

    def line(self, kind: str, points: Points) -> None:
        self.strokes.append(self._stroke(kind, points))

    def area(self, kind: str, corners: Points) -> None:
        self.areas.append(self._stroke(kind, corners))

    def box(self, kind: str, across: tuple[float, float], up: tuple[float, float]) -> None:
        (left, right), (low, high) = across, up
        self.area(kind, [(left, low), (right, low), (right, high), (left, high)])

    def _stroke(self, kind: str, points: Points) -> Stroke:
        return Stroke(" ".join(f"{self.x.at(a):g},{self.y.at(b):g}" for a, b in points), kind)


def last_presented(progress: Progress) -> Trial | None:
    """Return the last trial that is not an answer to a separate questionnaire."""
    last = progress.last
    if last is None or not last.is_form:
        return last
    ends = (track.presented[-1] for track in progress.tracks.values())
    return max(ends, key=lambda trial: trial.key, default=None)


def success(trial: Trial) -> bool | None:
    """Return True for an answer that the psychometric function counts.

    These are "yes", "more" or "different" in tasks with such answers, and correct answers in other tasks. Returns None
    without an answer.
    """
    if TASKS[trial.task].response is YES_OR_NO:
        return None if trial.response is None else trial.response == 1
    return trial.correct


def levels_plot(name: str, title: str, track: TrackProgress) -> Plot | None:
    """Plot the levels of a track by presentation, or return None without one."""
    shown = [(n, trial.level, trial) for n, trial in enumerate(track.presented, 1) if trial.level is not None]
    if not shown:
        return None
    n_presented, (_, last_level, last) = len(track.presented), shown[-1]
    x = ruler_over([0.5, max(n_presented, 10) + 0.5], LEFT, RIGHT, margin=0.0)
    y = ruler_over((each for _, each, _ in shown), BOTTOM, TOP)
    turned = f", {count_of(len(track.reversals), 'reversal')}" if track.reversals else ""
    level = in_unit(plain_text(last_level), last.level_unit)
    plot = Plot(
        name=name,
        title=title,
        words=f"{count_of(n_presented, 'presentation')}{turned}; the last level was {level}.",
        x_label="presentation",
        y_label=with_unit("level", last.level_unit),
        x=x,
        y=y,
    )
    at = [(x.at(n), y.at(each), trial) for n, each, trial in shown]
    plot.marks.extend(Mark(a, b, "reversal", 9.0) for a, b, trial in at if trial in track.reversals)
    plot.marks.extend(Mark(a, b, _kind(trial)) for a, b, trial in at)
    plot.line("path", [(n, each) for n, each, trial in shown if trial.valid])
    return plot


def _kind(trial: Trial) -> str:
    if not trial.valid:
        return "invalid"
    return {True: "yes", False: "no", None: "neutral"}[success(trial)]


def condition_words(factors: Mapping[str, float | str]) -> str:
    """Return the name of a condition, or an empty text without factors.

    >>> condition_words({"frequency_hz": 240.0, "force_n": ""})
    '240 Hz'
    """
    stated = {name: level for name, level in factors.items() if level != ""}
    return condition_name(tuple(stated), tuple(stated.values())) if stated else ""
