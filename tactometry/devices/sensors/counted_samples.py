"""Samples with a counter and device time, mapped to the local clock."""

from collections.abc import Sequence

import numpy as np

from ..clock_map import ClockMap
from .reader import SampleBlock

SETTLING_S = 0.5
"""Duration of the first period, in which samples only relate the clocks and are dropped."""
STANDS_S = 5e-3
"""Decrease of the clock difference within the period above which it is not yet stable (unverified default)."""
SLEW = 1e-3
"""Largest relative difference between intervals of time stamps and of device time. A hold is lengthened at most by
this fraction (unverified default)."""
STEP_S = 0.02
"""Stamps with a larger error are corrected at once. A gate restarts at such a step, because it is a gap of the
longest allowed duration or a decreasing time stamp."""
REPEATED_AMONG = 1000
"""A counter that decreases by less indicates a repeated sample, by more a restarted device (unverified default)."""


class CountedSamples:
    """State of a device's counter and clock, with counts of lost samples."""

    def __init__(self, tick_s: float, settling_s: float = SETTLING_S, name: str = "sensor") -> None:
        self._tick_s, self._settling_s, self._name = tick_s, settling_s, name
        self._counter: int | None = None
        self._may_begin_anew = False
        self.n_lost = self.n_duplicates = 0
        self._begin(0)

    def may_begin_anew(self) -> None:
        """Accept any next counter, because the device was opened or restarted."""
        self._may_begin_anew = True

    def _begin(self, ticks: int) -> None:
        self._clocks, self._ticks = ClockMap(), ticks
        self._best: tuple[float, float] | None = None
        self._is_settled = False
        self._last: tuple[float, float] | None = None

    def facts(self) -> dict[str, str | int | float | None]:
        counts = {"n_lost": self.n_lost, "n_duplicates": self.n_duplicates}
        return {**counts, "clock_offset_s": self._clocks.offset_s}

    def block(self, samples: Sequence[tuple[int, int, tuple[int, ...]]], arrival_s: float) -> SampleBlock:
        """Return the time stamps of samples that arrived together.

        A sample consists of counter, ticks and values. Counters and ticks are modulo 2**32. A time stamp is at most
        `STEP_S` later than the arrival. It decreases only after larger errors or a restart of the device. Repeated and
        out-of-order samples are counted and dropped.

        Raises `DeviceFailed` if the rate of the device's clock differs from ours.
        """
        new = []
        for counter, ticks, values in samples:
            if self._is_new(counter, ticks):
                self._ticks += (ticks - self._ticks) % 2**32
                new.append((self._ticks * self._tick_s, values))
        # add the whole block first, so that its least delayed sample determines all stamps
        for device_s, _ in new:
            self._clocks = self._clocks.after(device_s, arrival_s)
        self._clocks.check(self._name)
        settled = [(device_s, values) for device_s, values in new if self._settle(device_s, new[-1][0])]
        times_s = [self._stamp_s(device_s) for device_s, _ in settled]
        return SampleBlock(np.array(times_s), np.array([values for _, values in settled], dtype=np.float64))

    def _settle(self, device_s: float, newest_s: float) -> bool:
        """Return True once the difference of the clocks is stable."""
        if self._is_settled:
            return True
        offset_s = self._clocks.offset_s or 0.0
        if self._best is None:
            self._best = offset_s, device_s
        elif offset_s < self._best[0] - STANDS_S:
            # the difference fell during the block: stability begins after its newest sample
            self._best = offset_s, newest_s
        self._is_settled = device_s - self._best[1] >= self._settling_s
        return self._is_settled

    def _stamp_s(self, device_s: float) -> float:
        stamp_s = self._clocks.ours_s(device_s)
        if self._last is not None:
            last_device_s, last_stamp_s = self._last
            elapsed_s = device_s - last_device_s
            expected_s = last_stamp_s + elapsed_s
            if abs(stamp_s - expected_s) <= STEP_S:
                bend_s = SLEW * elapsed_s
                stamp_s = min(max(stamp_s, expected_s - bend_s), expected_s + bend_s)
            elif stamp_s < expected_s and stamp_s - last_stamp_s <= STEP_S:
                # a gate would miss a step back within a gap: stamp before the last one, so that it restarts
                stamp_s = min(stamp_s, last_stamp_s - self._tick_s)
        self._last = (device_s, stamp_s)
        return stamp_s

    def _is_new(self, counter: int, ticks: int) -> bool:
        """Return True for a later sample, or after a restart of the device."""
        anew, self._may_begin_anew = self._may_begin_anew, False
        if self._counter is not None:
            n_behind = (self._counter - counter) % 2**32
            n_missing = (counter - self._counter - 1) % 2**32
            if n_behind < REPEATED_AMONG and not anew:
                self.n_duplicates += 1
                return False
            if n_missing > 2**31:  # more than half of the counter's range: it went back
                self._begin(ticks)
            else:
                self.n_lost += n_missing
        self._counter = counter
        return True
