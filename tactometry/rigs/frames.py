"""The rhythm of the screen: its measured period, pacing where it has none, and what became of the frames."""

import time
from collections.abc import Sequence

import numpy as np

PERIOD_WITHOUT_BLANK_S = 1 / 60
SHORTEST_PERIOD_S = 1 / 250


class Pacer:
    """Waits for the next frame where no vertical blank does: `measured_s` below 4 ms is no screen's period.

    >>> Pacer(0.0007).in_software, Pacer(1 / 120).in_software
    (True, False)
    """

    def __init__(self, measured_s: float) -> None:
        self.in_software = measured_s < SHORTEST_PERIOD_S
        self.period_s = PERIOD_WITHOUT_BLANK_S if self.in_software else measured_s
        self._due_s = time.perf_counter()

    def wait(self) -> None:
        """Return when the next frame is due."""
        if self.in_software:
            now_s = time.perf_counter()
            time.sleep(max(0.0, self._due_s - now_s))
            self._due_s = max(self._due_s, now_s) + self.period_s


def timing_of(intervals_s: Sequence[float], period_s: float) -> dict[str, int | float | None]:
    """Number of frames, how many were dropped (whole periods that intervals were too long), and quantiles, s.

    >>> timing_of([0.016, 0.017, 0.050], 1 / 60)["n_dropped_frames"]
    2
    """
    n_dropped = sum(max(0, round(interval / period_s) - 1) for interval in intervals_s)
    facts: dict[str, int | float | None] = {"n_frames": len(intervals_s), "n_dropped_frames": n_dropped}
    quantiles = np.quantile(intervals_s, [0.5, 0.99, 1.0]).round(6).tolist() if intervals_s else [None] * 3
    names = ("frame_interval_median_s", "frame_interval_p99_s", "frame_interval_max_s")
    return facts | dict(zip(names, quantiles, strict=True))
