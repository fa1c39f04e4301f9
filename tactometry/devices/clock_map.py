"""Relation of device clocks to the local clock, and time since boot."""

import functools
import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Final

from ..errors import DeviceFailed, InvalidParameter

BIN_S = 0.5
N_BINS = 8
"""Bins in which the smallest delay is searched, four seconds in all. A drift of 100 ppm adds 0.4 ms (unverified
defaults)."""
RATE_TOLERANCE, SLOWEST = 0.02, 0.5
"""Tolerated rate error of a device's clock. Crystals are within 1e-4, ceramic resonators within 5e-3 (unverified
defaults)."""
DRIFT = 5e-3
"""Largest growth of the smallest delay per second, s/s (unverified default)."""
GAINED_S = 0.05
"""Lead over its earlier offset by which a clock counts as fast, s. Late samples that catch up only return to the
earlier offset (unverified default)."""


@dataclass(frozen=True)
class ClockMap:
    """Map from device time to local time, estimated from arrival times.

    A sample never arrives before it was taken. So arrival time minus device time is the clock difference plus a delay,
    and its smallest recent value estimates the difference. The smallest delay of the transfer remains unknown.

    - `smallest_s`: Smallest difference in each of the last bins of `BIN_S`.
    - `floor_s`: Smallest difference in earlier bins, increased by `DRIFT` since then.

    >>> clocks = ClockMap()
    >>> for device_s, arrival_s in [(0.0, 10.25), (0.25, 10.375), (0.5, 10.75)]:
    ...     clocks = clocks.after(device_s, arrival_s)
    >>> clocks.ours_s(0.5)
    10.625
    """

    smallest_s: tuple[tuple[int, float], ...] = ()
    floor_s: float = math.inf

    def after(self, device_s: float, arrival_s: float) -> "ClockMap":
        """Add a sample that was taken at `device_s` and arrived at `arrival_s`.

        Raises `InvalidParameter` if a time is not finite.
        """
        if not (math.isfinite(device_s) and math.isfinite(arrival_s)):
            raise InvalidParameter(f"ClockMap: found times {device_s} and {arrival_s}, expected finite numbers")
        now = math.floor(arrival_s / BIN_S)
        difference_s = arrival_s - device_s
        if self.smallest_s and self.smallest_s[-1][0] == now and self.smallest_s[-1][1] <= difference_s:
            return self  # most samples contain no new information
        kept = tuple(pair for pair in self.smallest_s if now - N_BINS < pair[0] <= now)
        if kept and kept[-1][0] == now:
            smallest_s = min(kept[-1][1], difference_s)
            return ClockMap((*kept[:-1], (now, smallest_s)), self.floor_s)
        # new bin: bins that leave the window enter the floor, which rises by `DRIFT`
        leaving_s = (smallest_s for n, smallest_s in self.smallest_s if n <= now - N_BINS)
        floor_s = min(self.floor_s + DRIFT * BIN_S, *leaving_s, math.inf)
        return ClockMap((*kept, (now, difference_s)), floor_s)

    def ours_s(self, device_s: float) -> float:
        """Convert a device time to local time, after the first sample."""
        if self.offset_s is None:
            raise InvalidParameter("ClockMap: found no sample yet, expected at least one sample")
        return device_s + self.offset_s

    def check(self, name: str) -> None:
        """Raise `DeviceFailed` if the device's clock has another rate.

        The difference then falls from bin to bin, or rises by more than half of the elapsed time. One bin may deviate.
        A slower rise means late samples. A fall to an earlier value means that late samples have caught up.

        >>> clocks = ClockMap()
        >>> for n in range(50):
        ...     clocks = clocks.after(device_s=0.13 * n, arrival_s=0.1 * n)
        >>> clocks.check("board")
        Traceback (most recent call last):
        tactometry.errors.DeviceFailed: board: found a clock that runs 1.3 times as fast as this computer's, expected \
within 2%; check the device and the rate in the bench file
        """
        if self._wrong_rate is not None:
            raise DeviceFailed(
                f"{name}: found a clock that runs {self._wrong_rate:.3g} times as fast as this computer's, expected "
                f"within {RATE_TOLERANCE:.0%}; check the device and the rate in the bench file"
            )

    @cached_property
    def _wrong_rate(self) -> float | None:
        # seconds gained per second between bins; there may be empty bins between them
        slopes = sorted(
            (late_s - early_s) / (BIN_S * (n - m)) for (m, early_s), (n, late_s) in pairwise(self.smallest_s)
        )
        if len(slopes) < N_BINS - 1:
            return None
        gained_s = min(self.floor_s, self.smallest_s[0][1]) - self.smallest_s[-1][1]
        # second smallest and second largest slope, as one bin may deviate
        runs_fast = slopes[-2] < -RATE_TOLERANCE and gained_s > GAINED_S
        runs_slow = slopes[1] > SLOWEST
        return 1 - median(slopes) if runs_fast or runs_slow else None

    @cached_property
    def offset_s(self) -> float | None:
        """Local minus device time, or None before the first sample."""
        return min((difference_s for _, difference_s in self.smallest_s), default=None)


def clock_offset_s(theirs_s: Callable[[], float], n_readings: int = 5) -> float:
    """Return local minus other clock, s, from the fastest of several readings.

    >>> abs(clock_offset_s(time.perf_counter)) < 1e-3
    True
    """
    readings = []
    for _ in range(n_readings):
        before_s, read_s, after_s = time.perf_counter(), float(theirs_s()), time.perf_counter()
        readings.append((after_s - before_s, (before_s + after_s) / 2 - read_s))
    return min(readings)[1]


_BOOT_ID: Final = Path("/proc/sys/kernel/random/boot_id")


def boot_clock_s() -> float:
    """Return the time since boot, s, including sleep if available."""
    return time.clock_gettime(time.CLOCK_BOOTTIME) if hasattr(time, "CLOCK_BOOTTIME") else time.perf_counter()


@functools.cache
def boot_id() -> str:
    """Return the identifier of this boot, or an empty text if unavailable."""
    return _BOOT_ID.read_text("ascii").strip() if _BOOT_ID.exists() else ""


BEGIN_WITHIN_S: Final = 5.0
"""Time limit for an output to begin. A sound card waits 2 s for the end of a signal and 2 s for its start
(unverified default)."""
CLOSE_WITHIN_S: Final = 2.0
"""Time limit for a driver to close (unverified default)."""


def within(longest_s: float, what: str, call: Callable[[], None], cure: str = "switch its amplifier off") -> None:
    """Run `call` in a thread, and wait for it at most `longest_s`.

    Raises `DeviceFailed` if the call takes longer, with a message that begins with `what`. Other errors of `call` are
    raised too.

    >>> import time
    >>> within(1.0, "output 'x'", lambda: None)
    >>> within(0.01, "output 'x'", lambda: time.sleep(1))
    Traceback (most recent call last):
    tactometry.errors.DeviceFailed: output 'x': it hangs and did not end within 0.01 s: switch its amplifier off
    """
    raised: list[BaseException] = []

    def work() -> None:
        try:
            call()
        except BaseException as error:  # raised in the waiting thread
            raised.append(error)

    thread = threading.Thread(target=work, name=what, daemon=True)
    thread.start()
    thread.join(longest_s)
    if thread.is_alive():
        raise DeviceFailed(f"{what}: it hangs and did not end within {longest_s:g} s: {cure}")
    if raised:
        raise raised[0]
