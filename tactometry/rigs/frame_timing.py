"""Frame period of the screen, pacing without vertical sync, frame statistics."""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

PERIOD_WITHOUT_BLANK_S: Final = 1 / 60
SHORTEST_PERIOD_S, LONGEST_PERIOD_S = 1 / 250, 1 / 24
"""Plausible frame periods of a screen whose mode states no rate (unverified defaults)."""
LIKE, STEADY_PART = 0.1, 0.8
"""Criteria for vertical sync (unverified defaults). At least `STEADY_PART` of the intervals are within `LIKE`
(relative) of their median, and the median within `LIKE` of the nominal period."""
FASTEST: Final = 0.75
"""Frames shorter than this fraction of the period did not wait for vertical sync (unverified default)."""
N_TOO_FAST: Final = 10


@dataclass(frozen=True)
class Rhythm:
    """Frame period of a screen.

    - `measured_s`: Median of the measured frame intervals, s.
    - `nominal_s`: Period stated by the screen's mode, s, or None.
    - `trusted`: True if the intervals are regular and close to the nominal period.
    - `in_software`: True if frames do not wait for vertical sync and must be paced in software.
    """

    measured_s: float
    nominal_s: float | None
    trusted: bool
    in_software: bool

    @property
    def period_s(self) -> float:
        """Return the measured period if trusted, else the nominal one, else 1/60 s."""
        return self.measured_s if self.trusted else self.nominal_s or PERIOD_WITHOUT_BLANK_S

    @property
    def caution(self) -> str | None:
        """Return a warning if the frame rate is implausible, else None."""
        if self.trusted or self.in_software:
            return None
        by = "the mode of the screen" if self.nominal_s else "assumption"
        return (
            f"screen: found frames of {1e3 * self.measured_s:.1f} ms, expected {1e3 * self.period_s:.1f} ms by {by}: "
            "drawing is slow; close other programs. Dropped frames are counted by the expected period"
        )


def rhythm_of(intervals_s: Sequence[float], nominal_hz: float | None) -> Rhythm:
    """Estimate the frame period from measured intervals and the nominal rate.

    >>> rhythm_of([0.0167] * 20, 60.0).trusted, rhythm_of([0.0044, 0.095, 0.02] * 7, 60.0).period_s
    (True, 0.016666666666666666)
    >>> rhythm_of([0.0007] * 20, None)
    Rhythm(measured_s=0.0007, nominal_s=None, trusted=False, in_software=True)
    """
    measured_s, nominal_s = float(np.median(intervals_s)), None if nominal_hz is None else 1 / nominal_hz
    steady = float(np.mean(np.abs(np.asarray(intervals_s) - measured_s) <= LIKE * measured_s)) >= STEADY_PART
    likely = (
        SHORTEST_PERIOD_S <= measured_s <= LONGEST_PERIOD_S
        if nominal_s is None
        else abs(measured_s - nominal_s) <= LIKE * nominal_s
    )
    trusted = steady and likely
    fastest_s = float(np.quantile(intervals_s, 0.1))
    in_software = not trusted and fastest_s < FASTEST * (nominal_s or PERIOD_WITHOUT_BLANK_S)
    return Rhythm(measured_s, nominal_s, trusted, in_software)


def nominal_rate_hz(mode: Any) -> float | None:
    """Return the frame rate of a pyglet screen mode, or None.

    X states the pixel clock (kHz) and the pixels per frame including blanks, Windows and macOS the rate.
    """
    line = getattr(mode, "info", None)
    if line is None:
        rate_hz = float(getattr(mode, "rate", None) or math.nan)
    else:
        n_pixels = float(line.htotal * line.vtotal)
        rate_hz = 1e3 * float(line.dotclock) / n_pixels if n_pixels else math.nan
    return rate_hz if 1 / LONGEST_PERIOD_S <= rate_hz <= 1000 else None


class Pacer:
    """Pacing of frames if the screen does not wait for vertical sync."""

    def __init__(self, rhythm: Rhythm) -> None:
        self.rhythm, self.in_software = rhythm, rhythm.in_software
        self._due_s = time.perf_counter()
        self._n_fast = 0

    def wait(self) -> None:
        """Wait until the next frame is due."""
        if self.in_software:
            now_s = time.perf_counter()
            time.sleep(max(0.0, self._due_s - now_s))
            self._due_s = max(self._due_s, now_s) + self.rhythm.period_s

    def after(self, interval_s: float) -> None:
        """Add a frame interval. Many short intervals imply missing vertical sync."""
        self._n_fast = self._n_fast + 1 if interval_s < FASTEST * self.rhythm.period_s else 0
        self.in_software = self.in_software or self._n_fast >= N_TOO_FAST


def timing_of(intervals_s: Sequence[float], period_s: float) -> dict[str, int | float | None]:
    """Return counts of frames and dropped frames, and quantiles of intervals, s.

    >>> timing_of([0.016, 0.017, 0.050], 1 / 60)["n_dropped_frames"]
    2
    """
    n_dropped = sum(max(0, round(interval / period_s) - 1) for interval in intervals_s)
    facts: dict[str, int | float | None] = {"n_frames": len(intervals_s), "n_dropped_frames": n_dropped}
    quantiles = np.quantile(intervals_s, [0.5, 0.99, 1.0]).round(6).tolist() if intervals_s else [None] * 3
    names = ("frame_interval_median_s", "frame_interval_p99_s", "frame_interval_max_s")
    return facts | dict(zip(names, quantiles, strict=True))
