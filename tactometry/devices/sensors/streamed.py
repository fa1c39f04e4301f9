"""Force (N) and position (m) from the channels of a stream."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from datetime import date

import numpy as np

from ...arguments.constraints import constrained
from ...arguments.require import expect, finite, not_zero, without_none
from ...errors import InvalidParameter
from ...signal import FloatArray
from ..measured import MaxAge, Measured
from .reader import Reader, SampleBlock

OnSamples = Callable[[FloatArray, FloatArray], None]
"""Callback for samples: times (n_samples,) in s on `time.perf_counter`, and values."""
MEAN_S = 0.02
"""Duration over which positions are averaged, against noise, before distances are summed (unverified default)."""


class StreamedSensor:
    """Sensor of some channels of a reader, whose counts `convert` maps.

    Forces are in N, (n_samples,), positions on the surface in m, (n_samples, n_axes). Time stamps are seconds on
    `time.perf_counter`. A sample that the device reports as lost is NaN.
    """

    def __init__(self, reader: Reader, convert: Callable[[FloatArray], FloatArray]) -> None:
        self.reader, self._convert = reader, convert
        self._listener = reader.listen()
        self._is_open = False
        self._converted: tuple[SampleBlock | None, FloatArray] = None, np.empty(0)

    @property
    def name(self) -> str:
        return self.reader.source.name

    def open(self) -> None:
        """Begin to collect samples. Raises `DeviceFailed`."""
        if not self._is_open:
            self.reader.open()
            self._is_open = True
            self.read()  # drop samples that a shared reader received before this opening

    def read(self) -> tuple[FloatArray, FloatArray]:
        block = self._listener.read()
        return block.times_s, self._convert(block.values)

    def subscribe(self, on_samples: OnSamples) -> Callable[[], None]:
        """Call `on_samples` in the reader's thread until the returned call.

        A silent device causes a call with empty arrays every `POLL_S`.
        """
        return self.reader.subscribe(lambda block: on_samples(block.times_s, self._values(block)))

    def _values(self, block: SampleBlock) -> FloatArray:
        """Convert a block once for all subscribers."""
        converted, values = self._converted
        if converted is not block:
            values = self._convert(block.values)
            self._converted = block, values
        return values

    def close(self) -> None:
        """Release the device. May be called more than once."""
        if self._is_open:
            self._is_open = False
            self.reader.close()


LARGEST_FORCE_N = 100.0
LARGEST_PLACE_M = 1e6
"""Values above which a reading cannot come from a finger. Instruments send such values at overload (unverified
defaults)."""


@dataclass(frozen=True)
@constrained
class ForceCalibration(Measured):
    """Force calibration in one of three forms.

    Counts outside a known range become NaN, a lost sample. So do forces above `LARGEST_FORCE_N`, which instruments send
    at overload.

    - `newtons_per_count`: Force per count for use with `zero_count`, N, not 0. Negative if pressing lowers the counts.
    - `zero_count`: Count of the sensor without a force.
    - `polynomial`: Coefficients in ascending order, N, N per count and so on. The polynomial must be monotonic from
      `count_low` to `count_high`.
    - `table_counts`: Increasing counts of a piecewise linear calibration curve.
    - `table_forces_n`: Force at each of the `table_counts`, increasing or decreasing throughout.
    - `count_low`: Count at which the sensor saturates at the low end.
    - `count_high`: Count at which the sensor saturates at the high end.
    - `measured_on`: Date of the calibration.
    - `measured_by`: Name of the person who calibrated it.
    - `max_age_days`: Age above which the calibration is refused.

    >>> ForceCalibration(newtons_per_count=0.01, zero_count=100.0).force_n(np.array([100.0, 350.0])).tolist()
    [0.0, 2.5]
    >>> ForceCalibration(table_counts=(0.0, 10.0), table_forces_n=(0.0, 1.0)).force_n(np.array([5.0, 11.0])).tolist()
    [0.5, nan]
    """

    newtons_per_count: float | None = None
    zero_count: float = 0.0
    polynomial: tuple[float, ...] | None = None
    table_counts: tuple[float, ...] | None = None
    table_forces_n: tuple[float, ...] | None = None
    count_low: float = -math.inf
    count_high: float = math.inf
    measured_on: date | None = None
    measured_by: str | None = None
    max_age_days: MaxAge | None = None

    def __post_init__(self) -> None:
        forms = without_none(
            {name: getattr(self, name) for name in ("newtons_per_count", "polynomial", "table_counts")}
        )
        several = "none, or more than one, of newtons_per_count, polynomial and table_counts"
        expect(len(forms) == 1, "ForceCalibration", several, "exactly one")

        if self.newtons_per_count is not None:
            not_zero("ForceCalibration", newtons_per_count=self.newtons_per_count)
            finite("ForceCalibration", zero_count=self.zero_count)
        if self.polynomial is not None:
            enough = len(self.polynomial) >= 2 and np.isfinite(self.polynomial).all()
            expect(enough, "ForceCalibration.polynomial", self.polynomial, "at least two finite numbers")
            _check_turns(self.polynomial, self.count_low, self.count_high)
        if self.table_counts is not None:
            counts, forces_n = self.table_counts, self.table_forces_n or ()
            where = "ForceCalibration.table_counts"
            paired = len(counts) == len(forces_n) >= 2 and np.isfinite([counts, forces_n]).all()
            sizes = f"{len(counts)} counts and {len(forces_n)} table_forces_n"
            expect(paired, where, sizes, "equal numbers of both, at least two, all finite")
            expect(np.all(np.diff(counts) > 0), where, "counts that do not increase", "rising ones")
            steps_n = np.diff(forces_n)
            follows = np.all(steps_n > 0) or np.all(steps_n < 0)
            turns = "forces that neither increase nor decrease throughout"
            expect(follows, "ForceCalibration.table_forces_n", turns, "that; measure them again")

        rises = self.count_low < self.count_high
        expect(rises, "ForceCalibration.count_low", self.count_low, f"below count_high, {self.count_high}")

    def force_n(self, counts: FloatArray) -> FloatArray:
        """Convert counts (n_samples,) to N, or NaN outside the known range."""
        known = (counts >= self.count_low) & (counts <= self.count_high)
        return _within(np.where(known, self._force_n(counts), np.nan), LARGEST_FORCE_N)

    def _force_n(self, counts: FloatArray) -> FloatArray:
        if self.table_counts is not None and self.table_forces_n is not None:
            return np.interp(counts, self.table_counts, self.table_forces_n, left=np.nan, right=np.nan)
        if self.polynomial is not None:
            return np.asarray(np.polynomial.polynomial.polyval(counts, self.polynomial))
        return (counts - self.zero_count) * (self.newtons_per_count or math.nan)


def _check_turns(polynomial: tuple[float, ...], low: float, high: float) -> None:
    slope = np.polynomial.Polynomial(polynomial).deriv().trim()
    roots = np.asarray(slope.roots(), complex)
    turns = (roots.imag == 0) & (roots.real > low) & (roots.real < high)
    is_flat = not np.any(slope.coef)  # a constant has no slope, and so no root to check
    if np.any(turns) or is_flat:
        raise InvalidParameter(
            f"ForceCalibration.polynomial: found {polynomial}, which yields the same force for several counts from "
            f"{low:g} to {high:g}, expected a monotonic polynomial; correct count_low and count_high"
        )


def streamed_force(reader: Reader, channel: int, calibration: ForceCalibration) -> StreamedSensor:
    return StreamedSensor(reader, lambda counts: calibration.force_n(counts[:, channel]))


def streamed_position(
    reader: Reader,
    channels: tuple[int, ...],
    metres_per_count: float,
    zero_counts: tuple[float, ...] = (),
    known: tuple[float, float] = (-math.inf, math.inf),
) -> StreamedSensor:
    """Return a position sensor with one channel per axis.

    The position is 0 at `zero_counts` (default 0). Counts outside `known`, such as overload values, become NaN.
    """
    columns, zero = np.array(channels), np.array(zero_counts or (0.0,) * len(channels))

    def place_m(counts: FloatArray) -> FloatArray:
        taken = counts.take(columns, axis=1)
        is_known = (taken >= known[0]) & (taken <= known[1])
        return _within(np.where(is_known, (taken - zero) * metres_per_count, np.nan), LARGEST_PLACE_M)

    return StreamedSensor(reader, place_m)


def _within(values: FloatArray, largest: float) -> FloatArray:
    return np.where(np.abs(values) <= largest, values, np.nan)


def mean_speed_m_per_s(times_s: FloatArray, positions_m: FloatArray) -> float | None:
    """Return the mean speed of a finger, from positions averaged in time.

    Positions are averaged over periods of `MEAN_S` before distances are summed.

    - `times_s`: Increasing time stamps, s.
    - `positions_m`: Finite positions, m, (n_samples, n_axes).

    Returns None if the samples fill less than two periods. Raises `InvalidParameter` if the shapes differ or a time
    stamp decreases.

    >>> times_s = np.arange(1000) / 1000
    >>> round(mean_speed_m_per_s(times_s, np.column_stack([0.03 * times_s, 0.04 * times_s])), 9)
    0.05
    """
    paired = times_s.ndim == 1 and positions_m.ndim == 2 and len(times_s) == len(positions_m)
    sizes = f"{times_s.shape} stamps and {positions_m.shape} positions"
    expected = "increasing stamps (n_samples,) and positions (n_samples, n_axes)"
    expect(paired and not np.any(np.diff(times_s) < 0), "mean_speed_m_per_s", sizes, expected)
    if len(times_s) == 0:
        return None
    bins = np.floor((times_s - times_s[0]) / MEAN_S).astype(int)
    kept, first = np.unique(bins, return_index=True)
    if len(kept) < 2:
        return None
    n_each = np.diff([*first, len(times_s)])
    mean_times_s = np.add.reduceat(times_s, first) / n_each
    means_m = np.add.reduceat(positions_m, first, axis=0) / n_each[:, None]
    way_m = np.linalg.norm(np.diff(means_m, axis=0), axis=1).sum()
    return float(way_m / (mean_times_s[-1] - mean_times_s[0]))
