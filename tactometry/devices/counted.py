"""Samples that carry a counter and their device's time: counted, unwrapped, and put on our clock."""

from collections.abc import Sequence

import numpy as np

from tactometry.devices.clock_map import ClockMap
from tactometry.devices.reader import Block

SETTLING_S = 0.5
"""Samples of the first while only tell how the clocks are related, and are dropped."""
STANDS_S = 5e-3
"""A difference that falls by more within that while still falls (unverified default)."""
SLEW = 1e-3
"""Stamps advance as the device's time, but for this part: no hold is stretched by more (unverified default)."""
STEP_S = 0.02
"""Stamps that are further off than this are put right at once. A gate begins anew at such a step: it is a gap as long
as its longest, or a stamp that goes back."""


class CountedSamples:
    """Keeps the last counter and time, how many samples were lost between, and how the clocks are related."""

    def __init__(self, tick_s: float, settling_s: float = SETTLING_S) -> None:
        self._tick_s, self._settling_s = tick_s, settling_s
        self._counter: int | None = None
        self.n_lost = 0
        self._begin(0)

    def _begin(self, ticks: int) -> None:
        self._clocks, self._ticks = ClockMap(), ticks
        self._best: tuple[float, float] | None = None
        self._is_settled = False
        self._last: tuple[float, float] | None = None

    @property
    def offset_s(self) -> float | None:
        return self._clocks.offset_s

    def block(self, samples: Sequence[tuple[int, int, tuple[int, ...]]], arrival_s: float) -> Block:
        """Samples (counter, ticks, values) that arrived together; counters and ticks are modulo 2**32.

        A stamp is at most `STEP_S` later than the arrival. It goes back only where those before were further off than
        that, or the device started again.
        """
        devices_s = [self._device_s(counter, ticks) for counter, ticks, _ in samples]
        for device_s in devices_s:
            self._clocks = self._clocks.after(device_s, arrival_s)
        settled = [n for n, device_s in enumerate(devices_s) if self._settled(device_s, devices_s[-1])]
        times_s = [self._stamp_s(devices_s[n]) for n in settled]
        return Block(np.array(times_s), np.array([samples[n][2] for n in settled], dtype=np.float64))

    def _settled(self, device_s: float, newest_s: float) -> bool:
        """Whether the difference of the clocks has stood for a while: what had waited to be read is through."""
        if self._is_settled:
            return True
        offset_s = self._clocks.offset_s or 0.0
        if self._best is None:
            self._best = offset_s, device_s
        elif offset_s < self._best[0] - STANDS_S:
            self._best = offset_s, newest_s
        self._is_settled = device_s - self._best[1] >= self._settling_s
        return self._is_settled

    def _stamp_s(self, device_s: float) -> float:
        stamp_s = self._clocks.ours_s(device_s)
        if self._last is not None:
            elapsed_s = device_s - self._last[0]
            expected_s = self._last[1] + elapsed_s
            if abs(stamp_s - expected_s) <= STEP_S:
                stamp_s = min(max(stamp_s, expected_s - SLEW * elapsed_s), expected_s + SLEW * elapsed_s)
            elif stamp_s < expected_s:
                stamp_s = min(stamp_s, self._last[1] - self._tick_s)
        self._last = (device_s, stamp_s)
        return stamp_s

    def _device_s(self, counter: int, ticks: int) -> float:
        """Unwrapped time; a counter that jumps back is a device that started again."""
        if self._counter is not None:
            n_missing = (counter - self._counter - 1) % 2**32
            if n_missing > 2**31:
                self._begin(ticks)
            else:
                self.n_lost += n_missing
        self._counter = counter
        self._ticks += (ticks - self._ticks) % 2**32
        return self._ticks * self._tick_s
