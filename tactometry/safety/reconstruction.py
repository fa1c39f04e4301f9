"""Peaks of a voltage between samples, after a reconstruction filter.

The filter is assumed to be ideal. Each sample becomes a sinc function, tapered to zero at `REACH` samples. All
samples before and after the signal are zero. The course is computed in blocks by FFT at 2 points per sample, then at
4, and so on up to `N_PHASES`. A block is left out once no value between its points can exceed the bound.
"""

import functools
import math
from typing import Final, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..signal import FloatArray

REACH: Final = 512
"""Number of samples on either side that contribute to a point, half of them with full weight. Filters of converters
use about 30."""
BLOCK: Final = 4096
"""Number of samples of an FFT. A block shares `REACH` samples on either side with its neighbours."""
N_PHASES: Final = 32
"""Largest number of points per sample. A peak is at most 0.12 % (1/cos(pi/64)) above the nearest point."""
TOLERANCE: Final = 1e-3
"""Relative excess of a peak between samples that is accepted, about the error of `N_PHASES`. It allows for the
ringing of a smooth tone whose samples are at the limit (unverified default)."""
ROUNDING: Final = 1e-5
"""Largest error of single precision and of the taper, relative to the largest term of a course."""
AT_ONCE: Final = 16
"""Number of blocks computed together, so few that they fit into the processor cache."""

_INNER: Final = slice(REACH, BLOCK - REACH)
_HOP: Final = BLOCK - 2 * REACH - 1
"""Neighbouring blocks share a sample, so that the point next to a peak is in the peak's block."""
_Floats = NDArray[np.float32]


class _Kernel(NamedTuple):
    """Weights of samples around a point, at each phase between samples.

    - `most`: Largest sum of absolute weights. Times the largest sample, it bounds the course.
    - `curved`, `bent`: Bounds of the course's distance from straight lines between samples, and of its second
      derivative. The bound is the first number times the largest second difference, or the sum of the other two times
      the largest second and fourth differences.
    """

    spectra: NDArray[np.complex64]
    most: float
    curved: FloatArray
    bent: FloatArray


def course_peak(
    samples: FloatArray, bound: float, *, value: float = 1.0, slope: float = 0.0, added: FloatArray | None = None
) -> float:
    """Return the peak of abs(value * y + slope * y' + added) above `bound`.

    If there is none, return a number from 0 to `bound`. The exact peak is at most 0.13 % above the result or the bound.

    - `value`, `slope`: Weights of the filtered course y, and of its change y' per sample interval.
    - `added`: Values at the samples, with straight lines between them. 0 before the first sample and constant after the
      last one.

    >>> quarter_rate = np.sin(np.pi / 2 * np.arange(4000) + np.pi / 4) * np.hanning(4000)
    >>> round(float(np.max(np.abs(quarter_rate))), 3), round(course_peak(quarter_rate, bound=0.9), 3)
    (0.707, 1.0)
    """
    peak, added_peak = largest(samples), 0.0 if added is None else largest(added)
    scale = max(peak * max(abs(value), abs(slope)), added_peak)
    if scale == 0.0 or math.isinf(scale):
        return scale
    # relative to the largest term, for single precision
    weights = value * (peak / scale), slope * (peak / scale)
    most = _weighed([kernel.most for kernel in _kernels()], weights) + added_peak / scale
    if (most + ROUNDING) * scale <= bound:
        return 0.0
    courses = [_blocks(samples / (peak or 1.0), after="constant")]
    if added is not None:
        courses.append(_blocks(added / scale, after="edge"))
    return _search(courses, weights, bound / scale) * scale


def largest(values: FloatArray) -> float:
    return float(max(values.max(initial=0.0), -values.min(initial=0.0)))


def _blocks(course: FloatArray, after: Literal["constant", "edge"]) -> _Floats:
    """Return a view of overlapping blocks, (n_blocks, BLOCK)."""
    n_blocks = -(-(len(course) + 2 * REACH) // _HOP)
    begun = np.concatenate([np.zeros(2 * REACH, np.float32), course], dtype=np.float32)
    padded = np.pad(begun, (0, (n_blocks - 1) * _HOP + BLOCK - len(begun)), mode=after)
    return np.lib.stride_tricks.sliding_window_view(padded, BLOCK)[::_HOP]


def _search(courses: list[_Floats], weights: tuple[float, float], bound: float) -> float:
    """Return the peak of all blocks, or 0 if none can exceed the bound."""
    of_course, of_change = (np.float32(weight) * each.spectra for weight, each in zip(weights, _kernels(), strict=True))
    spectra, result = of_course + of_change, 0.0
    for first in range(0, len(courses[0]), AT_ONCE):
        samples, *added = (blocks[first : first + AT_ONCE] for blocks in courses)
        second = np.diff(samples, n=2, axis=1)
        differences = _peaks(second), _peaks(np.diff(second, n=2, axis=1))
        left = _upper_bounds(samples, weights, differences, *added) > max(bound, result)
        if left.any():
            bend = _by_differences([kernel.bent for kernel in _kernels()], weights, differences)[left]
            result = max(
                result, _peak(spectra, max(bound, result), samples[left], bend, *(each[left] for each in added))
            )
    return result


def _upper_bounds(
    samples: _Floats, weights: tuple[float, float], differences: tuple[_Floats, _Floats], added: _Floats | None = None
) -> FloatArray:
    """Return an upper bound of the peak of each block."""
    value, slope = weights
    lines = abs(value) * _peaks(samples[:, _INNER])
    if slope:
        lines = lines + abs(slope) * _peaks(np.diff(samples[:, _INNER]))
    by_lines = lines + _by_differences([kernel.curved for kernel in _kernels()], weights, differences)
    by_largest = _weighed([kernel.most for kernel in _kernels()], weights) * _peaks(samples)
    more = 0.0 if added is None else _peaks(added[:, _INNER])
    return np.asarray(np.minimum(by_lines, by_largest) + more + ROUNDING, dtype=np.float64)


def _by_differences(
    bounds: list[FloatArray], weights: tuple[float, float], differences: tuple[_Floats, _Floats]
) -> FloatArray:
    """Bound each block by its largest second and fourth differences."""
    rough, by_second, by_fourth = np.abs(weights) @ np.array(bounds)
    second, fourth = differences
    return np.asarray(np.minimum(rough * second, by_second * second + by_fourth * fourth), dtype=np.float64)


def _peak(
    kernels: NDArray[np.complex64], bound: float, samples: _Floats, bend: FloatArray, added: _Floats | None = None
) -> float:
    """Return the peak of blocks, doubling the points of the remaining blocks.

    `bend` bounds the second derivative of each block.
    """
    spectra, result, best, step = np.fft.rfft(samples), np.zeros(len(samples)), 0.0, N_PHASES
    while step > 1 and len(result):
        for phase in (0, step // 2) if step == N_PHASES else range(step // 2, N_PHASES, step):
            points: _Floats = np.fft.irfft(spectra * kernels[phase], BLOCK)[:, _INNER].astype(np.float32, copy=False)
            if added is not None:
                points += _between(added, phase / N_PHASES)
            result = np.maximum(result, _peaks(points))
        step //= 2
        best = max(best, float(np.max(result)))
        from_point = step / N_PHASES / 2
        # Duffin and Schaeffer: d samples from its peak M, a course is at least M cos(pi d)
        highest = np.minimum(result / math.cos(math.pi * from_point), result + bend * from_point**2 / 2)
        left = highest + ROUNDING > max(bound, best)
        spectra, result, bend = spectra[left], result[left], bend[left]
        added = None if added is None else added[left]
    return best


def _peaks(blocks: _Floats) -> _Floats:
    return np.asarray(np.maximum(blocks.max(axis=1), -blocks.min(axis=1)))


def _between(added: _Floats, part: float) -> _Floats:
    """Return the inner points of straight lines between two samples."""
    after = added[:, _INNER.start + 1 : _INNER.stop + 1]
    return added[:, _INNER] + np.float32(part) * (after - added[:, _INNER])


def _weighed(bounds: list[float], weights: tuple[float, float]) -> float:
    return sum(abs(weight) * bound for weight, bound in zip(weights, bounds, strict=True))


@functools.cache
def _kernels() -> tuple[_Kernel, _Kernel]:
    """Return the kernels of a course and of its change per sample."""
    lags, phases = np.arange(-REACH, REACH), np.arange(N_PHASES)[:, None] / N_PHASES
    at = lags + phases
    # a taper so smooth that the filter leaves smooth samples unchanged
    fall = np.sin(np.pi / 2 * np.clip(2 * np.abs(at) / REACH - 1, 0, 1)) ** 2
    taper = np.cos(np.pi / 2 * np.sin(np.pi / 2 * fall) ** 2) ** 2
    # sinc and its derivatives: n times derivative n - 1, plus u times derivative n, is known
    sinc = np.sinc(at)
    once = _over(np.cos(np.pi * at) - sinc, at, at_zero=0.0)
    twice = _over(-(np.pi**2) * at * sinc - 2 * once, at, at_zero=-(np.pi**2) / 3)
    thrice = _over(-(np.pi**2) * (sinc + at * once) - 3 * twice, at, at_zero=0.0)
    here, there = np.where(lags == 0, 1.0, 0.0), np.where(lags == -1, 1.0, 0.0)
    lines = (1 - phases) * here + phases * there
    return _kernel(sinc * taper, lines, twice * taper), _kernel(once * taper, there - here, thrice * taper)


def _over(numerators: FloatArray, at: FloatArray, at_zero: float) -> FloatArray:
    return np.divide(numerators, at, out=np.full_like(at, at_zero), where=at != 0)


def _kernel(weights: FloatArray, of_lines: FloatArray, second: FloatArray) -> _Kernel:
    """Return weights (n_phases, 2 * REACH) with their bounds.

    `of_lines` are the weights of straight lines, `second` the weights of the second derivative.
    """
    around_zero = np.zeros((len(weights), BLOCK), np.float32)
    around_zero[:, :REACH], around_zero[:, -REACH:] = weights[:, REACH:], weights[:, :REACH]
    most = float(np.max(np.sum(np.abs(weights), axis=1)))
    spectra = np.fft.rfft(around_zero).astype(np.complex64)
    return _Kernel(spectra, most, _difference_bounds(weights - of_lines), _difference_bounds(second))


def _difference_bounds(weights: FloatArray) -> FloatArray:
    """Return the three bounds of a `_Kernel` from its weights."""
    # weights that vanish for straight lines are sums of second differences, of which two suffice for any cubic; the
    # rest is a sum of fourth differences
    of_second = _summed_twice(weights - _two_like(weights))
    near = _two_like(of_second)
    of_fourth = _summed_twice(of_second - near)
    return np.array([np.max(np.sum(np.abs(each), axis=1)) for each in (of_second, near, of_fourth)])


def _two_like(weights: FloatArray) -> FloatArray:
    """Return two weights near the point with the same effect on straight lines."""
    total, moment = np.sum(weights, axis=1), np.sum(weights * np.arange(-REACH, REACH), axis=1)
    two = np.zeros_like(weights)
    two[:, REACH - 2], two[:, REACH - 1] = -total - moment, 2 * total + moment
    return two


def _summed_twice(weights: FloatArray) -> FloatArray:
    return np.asarray(np.cumsum(np.cumsum(weights, axis=1), axis=1))
