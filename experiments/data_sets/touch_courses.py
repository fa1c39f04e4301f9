"""Force and speed around stimulus onset, per participant, for reports."""

from collections import Counter
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
import pandas as pd

from tactometry.errors import TactometryError
from tactometry.gates import speeds_m_per_s
from tactometry.records.data_set import sessions
from tactometry.records.journal import read
from tactometry.records.traces import FOLDER, kind_of, read_part
from tactometry.session.answer import Touched
from tactometry.session.request import Press, Slide
from tactometry.signal import FloatArray

from .traces import RecordedTouch, touches

BEFORE_S: Final = 0.5
STEP_S: Final = 0.01
SHARES: Final = (5, 50, 95)
"""Reported percentiles over touches."""
COLUMNS: Final = (
    *("participant", "quantity", "target", "band_low", "band_high"),
    *("time_s", "low", "median", "high", "n_touches", "n_unread"),
)


class Wanted(NamedTuple):
    """Participant, quantity, target and relative tolerance (None: unlimited)."""

    participant: str
    quantity: str
    target: float
    tolerance: float | None


class MeasuredCourse(NamedTuple):
    """Samples of one quantity of a touch around onset.

    Time stamps (n_samples,) increase and are in s from the onset. `duration_s` is that of the stimulus.
    """

    wanted: Wanted
    times_s: FloatArray
    values: FloatArray
    duration_s: float


def touch_courses(path: Path) -> pd.DataFrame:
    """Compute percentiles of force and speed around onset over valid touches.

    Practice trials are excluded. `path` must be a data set's folder, as a single file has no traces.

    Returns
    -------
    DataFrame
        `COLUMNS`: 5th, 50th and 95th percentile over `n_touches` at each time (s), by participant, quantity (`force_n`,
        `speed_m_per_s`) and target. `n_unread` samples of the participant are damaged or missing.
    """
    read_or_not = [(touch, _courses(path, touch)) for touch in _valid_touches(path)]
    courses = [course for _, result in read_or_not for course in result or ()]
    unread = Counter(touch.head.participant for touch, result in read_or_not if result is None)
    by_wanted = groupby(sorted(courses, key=lambda course: course.wanted[:3]), key=lambda course: course.wanted)
    tables = [_table(key, list(group), unread[key.participant]) for key, group in by_wanted]
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=list(COLUMNS))


def _valid_touches(root: Path) -> Iterator[RecordedTouch]:
    for journal in sessions(root) if (root / FOLDER).is_dir() else ():
        for touch in touches(read(journal)):
            is_valid = isinstance(touch.answer, Touched) and touch.answer.valid
            if is_valid and touch.trial.valid and not touch.trial.practice:
                yield touch


def _courses(root: Path, touch: RecordedTouch) -> list[MeasuredCourse] | None:
    try:
        tables = {kind_of(part): read_part(root, part) for part in touch.answer.trace}
    except TactometryError:
        return None
    made = {"force": _force, "position": _speed}
    result = (make(touch, tables[kind]) for kind, make in made.items() if kind in tables)
    return [course for course in result if course.times_s.size > 1]


def _force(touch: RecordedTouch, table: FloatArray) -> MeasuredCourse:
    request = touch.request
    assert isinstance(request, Press | Slide)
    times_s, values = _rising(touch, table)
    return MeasuredCourse(
        _wanted(touch, "force_n", request.target_n, request.tolerance), times_s, values, request.duration_s
    )


def _speed(touch: RecordedTouch, table: FloatArray) -> MeasuredCourse:
    request = touch.request
    assert isinstance(request, Press | Slide)
    speed = (request.speed_m_per_s, request.speed_tolerance) if isinstance(request, Slide) else (0.0, None)
    times_s, along_m = _rising(touch, table)
    speeds = speeds_m_per_s(times_s, along_m) if times_s.size > 1 else along_m
    return MeasuredCourse(_wanted(touch, "speed_m_per_s", *speed), times_s, speeds, request.duration_s)


def _wanted(touch: RecordedTouch, quantity: str, target: float, tolerance: float | None) -> Wanted:
    return Wanted(touch.head.participant, quantity, target, tolerance)


def _rising(touch: RecordedTouch, table: FloatArray) -> tuple[FloatArray, FloatArray]:
    known = np.isfinite(table[:, 1]) & (np.diff(np.maximum.accumulate(table[:, 0]), prepend=-np.inf) > 0)
    return table[known, 0] - touch.answer.onset_s, table[known, 1]


def _table(wanted: Wanted, courses: list[MeasuredCourse], n_unread: int) -> pd.DataFrame:
    """Return the percentiles at times that the samples of a touch cover."""
    longest_s = max(course.duration_s for course in courses)
    times_s = STEP_S * np.arange(-round(BEFORE_S / STEP_S), round(longest_s / STEP_S) + 1)
    at = np.array([np.interp(times_s, *course[1:3], left=np.nan, right=np.nan) for course in courses])
    n_touches = np.isfinite(at).sum(axis=0)
    some = n_touches > 0
    low, median, high = np.nanpercentile(at[:, some], SHARES, axis=0)
    half = np.nan if wanted.tolerance is None else wanted.tolerance * wanted.target
    band = {"band_low": wanted.target - half, "band_high": wanted.target + half}
    numbers = {"time_s": times_s[some].round(6), "low": low, "median": median, "high": high}
    whose = dict(zip(COLUMNS, wanted[:3], strict=False))
    return pd.DataFrame({**whose, **band, **numbers, "n_touches": n_touches[some], "n_unread": n_unread})
