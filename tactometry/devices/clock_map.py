"""A device's clock on ours: the least delayed of the recent samples tells the difference."""

import math
from dataclasses import dataclass

from tactometry.errors import InvalidParameter

BIN_S = 0.5
N_BINS = 8
"""The smallest delay of the last four seconds: at 100 ppm of drift, 0.4 ms (unverified defaults)."""


@dataclass(frozen=True)
class ClockMap:
    """From device seconds to our seconds, given when samples arrived.

    A sample arrives later than it was taken, never earlier, so arrival minus device time is the difference of the
    clocks plus a delay; its smallest recent value is taken for the difference. What is left is the smallest delay of
    the way, which only a second clock could tell.

    Parameters
    ----------
    smallest_s : tuple of (bin, difference)
        The smallest difference in each of the last bins of `BIN_S`.

    Examples
    --------
    >>> clocks = ClockMap()
    >>> for device_s, arrival_s in [(0.0, 10.25), (0.25, 10.375), (0.5, 10.75)]:
    ...     clocks = clocks.after(device_s, arrival_s)
    >>> clocks.ours_s(0.5)
    10.625
    """

    smallest_s: tuple[tuple[int, float], ...] = ()

    def after(self, device_s: float, arrival_s: float) -> "ClockMap":
        """With a sample that was taken at `device_s` and arrived at `arrival_s`.

        Raises
        ------
        InvalidParameter
            If a time is not finite.
        """
        if not (math.isfinite(device_s) and math.isfinite(arrival_s)):
            raise InvalidParameter(f"ClockMap: found times {device_s} and {arrival_s}, expected finite numbers")
        now, difference_s = math.floor(device_s / BIN_S), arrival_s - device_s
        older = tuple(pair for pair in self.smallest_s if now - N_BINS < pair[0] <= now)
        if older and older[-1][0] == now:
            return ClockMap((*older[:-1], (now, min(older[-1][1], difference_s))))
        return ClockMap((*older, (now, difference_s)))

    def ours_s(self, device_s: float) -> float:
        """A device time on our clock.

        Raises
        ------
        InvalidParameter
            Before the first sample.
        """
        if self.offset_s is None:
            raise InvalidParameter("ClockMap: found no sample yet, expected one to relate the clocks")
        return device_s + self.offset_s

    @property
    def offset_s(self) -> float | None:
        """Our time minus the device's; None before the first sample."""
        return min((difference_s for _, difference_s in self.smallest_s), default=None)
