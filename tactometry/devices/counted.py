"""Samples that carry a counter and their device's time: counted, unwrapped, and put on our clock."""

from collections.abc import Sequence

import numpy as np

from tactometry.devices.clock_map import ClockMap
from tactometry.devices.reader import Block


class CountedSamples:
    """Keeps the last counter and time, and how many samples were lost between."""

    def __init__(self, tick_s: float) -> None:
        self._tick_s = tick_s
        self._clocks = ClockMap()
        self._counter: int | None = None
        self._ticks = 0
        self.n_lost = 0

    @property
    def drift(self) -> float | None:
        return self._clocks.drift

    def block(self, samples: Sequence[tuple[int, int, tuple[int, ...]]], arrival_s: float) -> Block:
        """Samples (counter, ticks, values) that arrived together; counters and ticks are modulo 2**32."""
        devices_s = [self._device_s(counter, ticks) for counter, ticks, _ in samples]
        for device_s in devices_s:
            self._clocks = self._clocks.after(device_s, arrival_s)
        times_s = [self._clocks.ours_s(device_s) for device_s in devices_s]
        return Block(np.array(times_s), np.array([values for _, _, values in samples], dtype=np.float64))

    def _device_s(self, counter: int, ticks: int) -> float:
        """Unwrapped time; a counter that jumps back is a device that started again."""
        if self._counter is not None:
            n_missing = (counter - self._counter - 1) % 2**32
            if n_missing > 2**31:
                self._clocks, self._ticks = ClockMap(), ticks
            else:
                self.n_lost += n_missing
        self._counter = counter
        self._ticks += (ticks - self._ticks) % 2**32
        return self._ticks * self._tick_s
