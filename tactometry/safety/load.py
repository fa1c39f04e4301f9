"""What an output drives: the current, charge and displacement that a voltage makes there.

Between two samples the voltage is taken as a straight line, before the first and after the last as a line from and to
zero. `Load` is exact for that course.
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..arguments.require import expect, positive
from ..signal import FloatArray, Signal


@dataclass(frozen=True)
class Load:
    """A capacitance with a leak in parallel, the same on every channel.

    Parameters
    ----------
    kind : str
        ``electrode`` (electrovibration: a finger on an insulated electrode) or ``piezo``.
    capacitance_f : float
        Largest capacitance that may be connected to a channel, above 0.
    leak_resistance_ohm : float
        Parallel to it, above 0; ``inf`` is no leak.
    displacement_m_per_v : tuple of float, optional
        Of each channel (or one value for all): the largest displacement per peak volt, above 0. For an impulse
        response h (m per V) this is the sum of abs(h), reached by a one-bit drive.

    Examples
    --------
    >>> finger = Load("electrode", capacitance_f=1e-9, leak_resistance_ohm=1e6)
    >>> ramp = Signal(np.array([[0.0, 50.0, 100.0, 50.0, 0.0]]), rate_hz=1e4, unit="V")
    >>> round(finger.current_peak_a(ramp), 9), round(finger.charge_peak_c(ramp), 12)
    (0.0006, 1.1e-07)
    """

    kind: Literal["electrode", "piezo"]
    capacitance_f: float
    leak_resistance_ohm: float = math.inf
    displacement_m_per_v: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        positive("Load", capacitance_f=self.capacitance_f)
        leak_ohm, gains = self.leak_resistance_ohm, self.displacement_m_per_v
        expect(leak_ohm > 0, "Load.leak_resistance_ohm", leak_ohm, "above 0")
        sound = gains is None or all(0 < gain < math.inf for gain in gains)
        expect(sound, "Load.displacement_m_per_v", gains, "finite numbers above 0")

    def current_peak_a(self, signal: Signal, rise_s: float = math.inf) -> float:
        """Largest abs(C dv/dt + v/R) on any channel, A.

        Of a signal whose samples are weakened as it plays, by parts that change from 0 to 1 in `rise_s` at the fastest,
        a bound: (g v)' is g v' + g' v.
        """
        before, after, slope = _lines(signal)
        # along a straight line the current is one too: its largest value is at an end
        ends = [self.capacitance_f * slope + v / self.leak_resistance_ohm for v in (before, after)]
        return float(np.max(np.abs(ends), initial=0.0)) + self.capacitance_f * signal.peak / rise_s

    def charge_peak_c(self, signal: Signal, rise_s: float = math.inf) -> float:
        """Largest abs(C v + integral of v/R) on any channel, C: the charge that has passed since the start.

        With a finite `rise_s`, as for the current, a bound: that of all charge with one sign.
        """
        before, after, _ = _lines(signal)
        if math.isfinite(rise_s):
            return self.capacitance_f * signal.peak + self._passed_at_most_c(signal)
        passed = np.cumsum((before + after) / (2 * signal.rate_hz * self.leak_resistance_ohm), axis=1)
        at_samples = self.capacitance_f * after + passed
        return float(np.max(np.abs([at_samples, self._turning_c(signal, at_samples)]), initial=0.0))

    def _passed_at_most_c(self, signal: Signal) -> float:
        """The integral of abs(v)/R on the channel where it is largest, C."""
        sums_v = np.abs(signal.samples).sum(axis=1)
        return float(np.max(sums_v, initial=0.0)) / (signal.rate_hz * self.leak_resistance_ohm)

    def charge_net_c(self, signal: Signal, rise_s: float = math.inf) -> float:
        """Largest abs(integral of v/R) over the whole signal on any channel, C: what has passed through the leak.

        With a finite `rise_s`, as for the current, a bound.
        """
        if math.isfinite(rise_s):
            return self._passed_at_most_c(signal)
        before, after, _ = _lines(signal)
        passed = np.sum((before + after) / (2 * signal.rate_hz * self.leak_resistance_ohm), axis=1)
        return float(np.max(np.abs(passed), initial=0.0))

    def displacement_peak_m(self, signal: Signal) -> float:
        """A bound that no course of these channels passes: the sum of m per V times the peak of each, m.

        Raises
        ------
        InvalidParameter
            If the load does not say it for each channel.
        """
        peaks_v = np.max(np.abs(signal.samples), axis=1, initial=0.0)
        gains = self.displacement_m_per_v or ()
        sizes = f"{len(gains)} values for {len(peaks_v)} channels"
        expect(len(gains) in (1, len(peaks_v)), "Load.displacement_m_per_v", sizes, "one for each, or one for all")
        return float(np.sum(np.asarray(gains) * peaks_v))

    def _turning_c(self, signal: Signal, at_samples: FloatArray) -> FloatArray:
        """The charge where the current changes its sign between two samples; elsewhere that at the sample."""
        if math.isinf(self.leak_resistance_ohm):
            return at_samples
        before, after, slope = _lines(signal)
        # the current C dv/dt + v/R is 0 there
        turning_v = -self.capacitance_f * slope * self.leak_resistance_ohm
        inside = (slope != 0) & ((turning_v - before) * (turning_v - after) < 0)
        per_slope = np.divide(1.0, slope, out=np.zeros_like(slope), where=inside)
        # back from the sample: the integral of v/R along a straight line is that of v dv / (slope R)
        leaked = (after**2 - turning_v**2) * per_slope / (2 * self.leak_resistance_ohm)
        at_turning = at_samples - self.capacitance_f * (after - turning_v) - leaked
        return np.where(inside, at_turning, at_samples)


def _lines(signal: Signal) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Voltage (V) at both ends of each straight piece, and its slope (V/s): (n_channels, n_samples + 1)."""
    padded = np.pad(signal.samples, ((0, 0), (1, 1)))
    return padded[:, :-1], padded[:, 1:], np.diff(padded, axis=1) * signal.rate_hz
