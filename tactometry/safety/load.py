"""Current, charge and displacement of a load for a given voltage.

The voltage is a straight line between two samples, and from and to zero at the ends. `Load` is exact for this
voltage. Filtered quantities are those after a reconstruction filter (`reconstruction`). Functions with a bound
return a number up to the bound if the peak is below it.
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..arguments.constraints import Positive, constrained
from ..arguments.require import expect
from ..signal import FloatArray, Signal
from .reconstruction import course_peak, largest


@dataclass(frozen=True, eq=False)
class PassedCharge:
    """Charge through the leak of a load during one signal.

    - `passed_c`, `absolute_c`: Integrals of v/R and of abs(v)/R, C, from the beginning to each sample, and to the final
      return to zero.
    - `rise_s`: As in `Limits.check_load`. If it is finite, only `absolute_c` bounds the charge.

    >>> balanced = Signal(np.array([[100.0] * 50 + [-100.0] * 50]), rate_hz=100.0, unit="V")
    >>> charge = Load("electrode", 1e-9, leak_resistance_ohm=1e6).passed_c(balanced)
    >>> [round(1e6 * c, 2) + 0.0 for c in (charge.largest_c, charge.net_c, charge.stopped_c(0.25, late_s=0.1))]
    [49.75, 0.0, 35.5]
    """

    passed_c: FloatArray
    absolute_c: FloatArray
    rate_hz: float
    rise_s: float = math.inf

    @property
    def net_c(self) -> float:
        """Charge of the complete signal, C: the largest of any channel."""
        return largest(self.absolute_c[:, -1] if math.isfinite(self.rise_s) else self.passed_c[:, -1])

    @property
    def largest_c(self) -> float:
        """Upper bound of the charge when the signal is stopped at any time, C.

        Between two samples of opposite signs, the extremum exceeds both ends by at most the smaller of the two
        triangles. It is bounded by half of the charge that passes in both directions.
        """
        if math.isfinite(self.rise_s):
            return self.net_c
        signed, absolute = (np.diff(course, axis=1, prepend=0.0) for course in (self.passed_c, self.absolute_c))
        before = self.passed_c - signed
        within = np.maximum(np.abs(before), np.abs(self.passed_c)) + (absolute - np.abs(signed)) / 2
        return largest(within)

    def stopped_c(self, after_s: float, late_s: float) -> float:
        """Return an upper bound of the charge of a stopped signal, C.

        - `after_s`: Time from the first sample to the stop, s.
        - `late_s`: Longest time from the stop to zero output, s.
        """
        last = self.passed_c.shape[1] - 1
        begin = min(max(math.floor(after_s * self.rate_hz), 0), last)
        end = min(max(math.ceil((after_s + late_s) * self.rate_hz), begin), last)
        following = self.absolute_c[:, end] - self.absolute_c[:, begin]
        course = self.absolute_c if math.isfinite(self.rise_s) else self.passed_c
        return largest(np.abs(course[:, begin]) + following)


@dataclass(frozen=True)
@constrained
class Load:
    """Capacitance with a leak in parallel, the same on every channel.

    - `kind`: ``electrode`` (electrovibration: a finger on an insulated electrode) or ``piezo``.
    - `capacitance_f`: Largest capacitance that may be connected to a channel, above 0.
    - `leak_resistance_ohm`: Resistance parallel to the capacitance, above 0. ``inf`` means no leak.
    - `displacement_m_per_v`: Largest displacement per peak volt, above 0, for each channel, or one value for all. For
      an impulse response h (m per V) it is the sum of abs(h), which a one-bit drive reaches.

    >>> finger = Load("electrode", capacitance_f=1e-9, leak_resistance_ohm=1e6)
    >>> ramp = Signal(np.array([[0.0, 50.0, 100.0, 50.0, 0.0]]), rate_hz=1e4, unit="V")
    >>> round(finger.current_peak_a(ramp), 9), round(finger.charge_peak_c(ramp), 12)
    (0.0006, 1.1e-07)
    """

    kind: Literal["electrode", "piezo"]
    capacitance_f: Positive
    leak_resistance_ohm: float = math.inf
    displacement_m_per_v: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        leak_ohm, gains = self.leak_resistance_ohm, self.displacement_m_per_v
        expect(leak_ohm > 0, "Load.leak_resistance_ohm", leak_ohm, "above 0")
        sound = gains is None or all(0 < gain < math.inf for gain in gains)
        expect(sound, "Load.displacement_m_per_v", gains, "finite numbers above 0")

    def current_peak_a(self, signal: Signal, rise_s: float = math.inf) -> float:
        """Return the largest abs(C dv/dt + v/R) on any channel, A.

        If the samples are multiplied by a factor g that changes from 0 to 1 in `rise_s` at the fastest, it is an
        upper bound: (g v)' is g v' + g' v.
        """
        peaks_a = []
        for channel in signal.samples:
            before, after, slope = _lines(channel, signal.rate_hz)
            slope *= self.capacitance_f
            # the current is linear along a straight line, so its largest value is at an end
            peaks_a += [largest(slope + v / self.leak_resistance_ohm) for v in (before, after)]
        return max(peaks_a) + self.capacitance_f * signal.peak / rise_s

    def charge_peak_c(self, signal: Signal, rise_s: float = math.inf) -> float:
        """Return the largest abs(C v + integral of v/R) on any channel, C.

        With a finite `rise_s` it is an upper bound, which adds the charge of all samples with the same sign.
        """
        if math.isfinite(rise_s):
            return self.capacitance_f * signal.peak + self.passed_c(signal, rise_s).net_c
        return max(self._channel_charge_c(channel, signal.rate_hz) for channel in signal.samples)

    def _channel_charge_c(self, samples_v: FloatArray, rate_hz: float) -> float:
        before, after, slope = _lines(samples_v, rate_hz)
        at_samples = np.cumsum((before + after) / (2 * rate_hz * self.leak_resistance_ohm))
        at_samples += self.capacitance_f * after
        return max(largest(at_samples), largest(self._turning_c(before, after, slope, at_samples)))

    def passed_c(self, signal: Signal, rise_s: float = math.inf) -> "PassedCharge":
        """Return the charge through the leak during a signal.

        With a finite `rise_s` it is an upper bound: the charge if all samples had the same sign.
        """
        return PassedCharge(self._passed(signal), self._passed(signal, absolute=True), signal.rate_hz, rise_s)

    def _passed(self, signal: Signal, *, absolute: bool = False) -> FloatArray:
        """Integrate v/R, or abs(v)/R, C: (n_channels, n_samples + 1)."""
        areas_of = _absolute_areas_v if absolute else _areas_v
        passed = np.array([np.cumsum(areas_of(*_lines(channel, signal.rate_hz)[:2])) for channel in signal.samples])
        passed /= signal.rate_hz * self.leak_resistance_ohm
        return passed

    def displacement_peak_m(self, signal: Signal) -> float:
        """Return an upper bound of the displacement at any time, m."""
        return float(np.sum(self._gains(signal) * _channel_peaks(signal)))

    def _gains(self, signal: Signal) -> FloatArray:
        gains, n_channels = self.displacement_m_per_v or (), len(signal.samples)
        sizes = f"{len(gains)} values for {n_channels} channels"
        expect(len(gains) in (1, n_channels), "Load.displacement_m_per_v", sizes, "one per channel, or one for all")
        return np.asarray(gains)

    def filtered_current_a(self, signal: Signal, bound_a: float, rise_s: float = math.inf) -> float:
        """Return the peak filtered current, A, if above `bound_a`."""
        weakened_a = 0.0
        if math.isfinite(rise_s):
            weakened_a = self.capacitance_f * max(signal.peak, filtered_peak_v(signal, signal.peak)) / rise_s
        per_volt, per_change = 1 / self.leak_resistance_ohm, self.capacitance_f * signal.rate_hz
        rest_a = bound_a - weakened_a
        return weakened_a + max(
            course_peak(channel, rest_a, value=per_volt, slope=per_change) for channel in signal.samples
        )

    def filtered_charge_c(self, signal: Signal, bound_c: float, rise_s: float = math.inf) -> float:
        """Return the peak filtered charge, C, if above `bound_c`.

        The charge through the leak is that of straight lines between the samples.
        """
        if math.isfinite(rise_s):
            leaked_c = self.passed_c(signal, rise_s).net_c
            return leaked_c + self.capacitance_f * filtered_peak_v(signal, (bound_c - leaked_c) / self.capacitance_f)
        to_zero = np.pad(signal.samples, ((0, 0), (0, 1)))
        return max(
            course_peak(channel, bound_c, value=self.capacitance_f, added=passed_c)
            for channel, passed_c in zip(to_zero, self._passed(signal), strict=True)
        )

    def filtered_displacement_m(self, signal: Signal, bound_m: float) -> float:
        """Return the peak filtered displacement, m, if above `bound_m`."""
        gains, peaks_v, of_samples_m = self._gains(signal), _channel_peaks(signal), self.displacement_peak_m(signal)
        if of_samples_m == 0.0:
            return 0.0
        # the sum is below the bound if no channel grows by more than this ratio
        bounds_v = peaks_v * (bound_m / of_samples_m)
        pairs = zip(signal.samples, bounds_v.tolist(), strict=True)
        if all(course_peak(channel, bound_v) <= bound_v for channel, bound_v in pairs):
            return of_samples_m
        filtered_v = [course_peak(channel, 0.0) for channel in signal.samples]
        return float(np.sum(gains * np.maximum(peaks_v, filtered_v)))

    def _turning_c(
        self, before: FloatArray, after: FloatArray, slope: FloatArray, at_samples: FloatArray
    ) -> FloatArray:
        """Return the charge where the current changes sign between samples."""
        if math.isinf(self.leak_resistance_ohm):
            return np.empty(0)
        # the current C dv/dt + v/R is 0 there
        turning_v = slope * (-self.capacitance_f * self.leak_resistance_ohm)
        inside = np.flatnonzero((slope != 0) & ((turning_v - before) * (turning_v - after) < 0))
        turning_v, end_v = turning_v[inside], after[inside]
        # from there to the sample: the integral of v/R along the line is that of v dv / (slope R)
        leaked = (end_v**2 - turning_v**2) / slope[inside] / (2 * self.leak_resistance_ohm)
        return np.asarray(at_samples[inside] - self.capacitance_f * (end_v - turning_v) - leaked)


def filtered_peak_v(signal: Signal, bound_v: float) -> float:
    """Return the peak filtered voltage, V, if above `bound_v`."""
    return max(course_peak(channel, bound_v) for channel in signal.samples)


def _channel_peaks(signal: Signal) -> FloatArray:
    return np.asarray(np.max(np.abs(signal.samples), axis=1, initial=0.0))


def _areas_v(before: FloatArray, after: FloatArray) -> FloatArray:
    return (before + after) / 2


def _absolute_areas_v(before: FloatArray, after: FloatArray) -> FloatArray:
    areas_v = _areas_v(np.abs(before), np.abs(after))
    across = np.flatnonzero(before * after < 0)
    # a line that crosses zero has two triangles
    areas_v[across] = (before[across] ** 2 + after[across] ** 2) / (4 * areas_v[across])
    return areas_v


def _lines(samples_v: FloatArray, rate_hz: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return voltages at both ends of each line (V), and slopes (V/s)."""
    padded = np.pad(samples_v, 1)
    slope = np.diff(padded)
    slope *= rate_hz
    return padded[:-1], padded[1:], slope
