"""Fast sums over modes for many pairs at once.

A sum of damped sinusoids at n equal steps of time is a non-uniform discrete Fourier transform (type 1). Each mode is
spread over a few bins around its frequency by a Kaiser-Bessel kernel; one inverse FFT per pair yields the time signal;
the kernel's own transform, known in closed form, is divided out (Fessler and Sutton, IEEE Trans. Signal Process. 51,
560, 2003). With a kernel of 16 bins on a grid twice as long as the signal the error is 1e-14 of the largest value at
any frequency. It costs a transform and 32 products per mode and pair, while a matrix product costs n per mode and pair.

The matrix product sums few modes, short signals, and modes that do not oscillate or decay unlike the rest.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ...arrays import ComplexArray, FloatArray, IndexArray, IntArray, fast_length
from .oscillators import Oscillators, turns

WIDTH: Final = 16
"""Width of the kernel in bins."""

LONGER: Final = 2.0
"""Length of the grid divided by that of the signal."""

LARGEST_SPREAD: Final = 0.5
"""Largest deviation of decay rate times duration; beyond it, the kernel at complex frequencies loses digits."""

FEWEST_MODES: Final = 64
SHORTEST: Final = 128
TILE: Final = 32
"""Number of pairs transformed together; their grids fit into the cache."""
BLOCK: Final = 64
"""Number of bins filled by one matrix product."""
BESSEL: Final = 1 / np.cumprod(np.r_[1.0, np.arange(1.0, 57.0)]) ** 2
"""1 / k!^2: ``I_0(2 w^(1/2)) = sum_k w^k / k!^2`` (Abramowitz and Stegun, 9.6.10), to the last digit up to w = 400."""


def modal_sums(
    oscillators: Oscillators,
    weights: FloatArray,
    rate_hz: float,
    start: int,
    stop: int,
    quantity: str = "displacement",
    out: FloatArray | None = None,
) -> FloatArray:
    """Return weights (n_rows, n_modes) times the modes' impulse responses.

    The result (n_rows, stop - start) contains samples start to stop - 1 and is written to `out` if given.

    Examples
    --------
    >>> modes = Oscillators(np.linspace(1e3, 1e5, 200), np.full(200, 300.0))
    >>> weights = np.ones((2, 200))
    >>> fast = modal_sums(modes, weights, 50e3, 0, 500)
    >>> slow = weights @ modes.impulse(50e3, 0, 500)
    >>> bool(np.abs(fast - slow).max() < 1e-12 * np.abs(slow).max())
    True
    """
    total = np.empty((len(weights), stop - start)) if out is None else out
    fast = _alike(oscillators, (stop - start) / rate_hz)
    if stop - start < SHORTEST or np.count_nonzero(fast) < FEWEST_MODES:
        return np.matmul(weights, oscillators.impulse(rate_hz, start, stop, quantity), out=total)
    ascending = np.flatnonzero(fast)[np.argsort(oscillators.split_rad_per_s[fast], kind="stable")]
    _transform(oscillators.of(ascending), weights[:, ascending], rate_hz, start, quantity, total)
    if not fast.all():
        total += weights[:, ~fast] @ oscillators.of(~fast).impulse(rate_hz, start, stop, quantity)
    return total


@dataclass(frozen=True)
class _Grid:
    """A grid of `n_fft` bins for `n` samples around the sample `middle`."""

    n: int
    n_fft: int

    @classmethod
    def of(cls, n: int) -> "_Grid":
        return cls(n, 2 * fast_length(math.ceil(LONGER * n / 2)))

    @property
    def middle(self) -> int:
        return self.n // 2

    @property
    def n_bins(self) -> int:
        return self.n_fft // 2 + 1

    @property
    def beta(self) -> float:
        """Return the kernel's parameter (Beatty et al., IEEE TMI 2005)."""
        ratio = self.n_fft / self.n
        return math.pi * math.sqrt((WIDTH * (ratio - 0.5) / ratio) ** 2 - 0.8)

    def kernel(self, bins: ComplexArray) -> ComplexArray:
        """Return I_0(beta (1 - (2 x / width)^2)^(1/2)) at distances in bins."""
        return np.asarray(
            np.polynomial.polynomial.polyval((self.beta / 2) ** 2 * (1 - (2 * bins / WIDTH) ** 2), BESSEL)
        )

    def transform(self) -> FloatArray:
        """Return the kernel's Fourier transform (n,), width sinh(r) / r."""
        time = np.arange(self.n) - self.middle
        r = np.sqrt(self.beta**2 - (math.pi * WIDTH * time / self.n_fft) ** 2)
        return np.asarray(WIDTH * np.sinh(r) / r)


def _alike(oscillators: Oscillators, duration_s: float) -> NDArray[np.bool_]:
    """Return a mask of oscillating modes that decay nearly as the median."""
    swings = oscillators.oscillates
    if not swings.any():
        return swings
    apart = np.abs(oscillators.decay_per_s - _common_decay(oscillators.of(swings)))
    return np.asarray(swings & (apart * duration_s <= LARGEST_SPREAD))


def _common_decay(oscillators: Oscillators) -> float:
    return float(np.median(oscillators.decay_per_s))


def _transform(
    oscillators: Oscillators, weights: FloatArray, rate_hz: float, start: int, quantity: str, out: FloatArray
) -> None:
    """Write the sums over modes in ascending order to `out`."""
    grid = _Grid.of(out.shape[1])
    kernels, modes = _in_blocks(grid, *_spread_kernel(oscillators, grid, rate_hz, start, quantity))
    # the shared decay is applied after the transform, relative to the middle
    decay = np.exp(-_common_decay(oscillators) / rate_hz * (np.arange(grid.n) - grid.middle))
    scale = decay * (grid.n_fft / 2) / grid.transform()
    # times before the middle are at the end of the periodic signal
    late, early = slice(grid.middle, None), slice(None, grid.middle)
    for row in range(0, len(weights), TILE):
        rows = out[row : row + TILE]
        signal = _tile(weights[row : row + TILE], kernels, modes, grid)
        np.multiply(signal[:, : grid.n - grid.middle], scale[late], out=rows[:, late])
        np.multiply(signal[:, grid.n_fft - grid.middle :], scale[early], out=rows[:, early])
    if start == 0 and quantity == "displacement":
        out[:, 0] = 0.0  # modes start at rest; set rounding errors to 0, as one-bit drives emit their sign


def _spread_kernel(
    oscillators: Oscillators, grid: _Grid, rate_hz: float, start: int, quantity: str
) -> tuple[IntArray, ComplexArray]:
    """Return first bins (n,) and kernel values (n, width) of each mode, with its phase at the middle of the signal."""
    apart = oscillators.decay_per_s - _common_decay(oscillators)
    bins, rounded = turns(oscillators.split_rad_per_s, grid.n_fft, rate_hz)
    first = np.ceil(bins - WIDTH / 2).astype(np.int64)
    # a mode that decays unlike the rest has a complex frequency
    away = (bins - first) + rounded + 1j * (apart * (grid.n_fft / (2 * math.pi * rate_hz)))
    values = grid.kernel(np.arange(WIDTH).astype(complex) - away[:, None])
    return first, -1j * oscillators.analytic(rate_hz, start + grid.middle, quantity)[:, None] * values


def _in_blocks(grid: _Grid, first: IntArray, kernel: ComplexArray) -> tuple[FloatArray, IndexArray]:
    """Return kernels within the bins of their block as real pairs, (n, 2 (BLOCK + width)).

    The second result (n_blocks + 1,) delimits the modes of each block. The first bins ascend from -width.
    """
    blocks, place = np.divmod(first + WIDTH, BLOCK)
    kernels = np.zeros((len(first), BLOCK + WIDTH), complex)
    np.put_along_axis(kernels, place[:, None] + np.arange(WIDTH), kernel, axis=1)
    n_blocks = (grid.n_bins + 2 * WIDTH) // BLOCK + 1
    return kernels.view(float), np.searchsorted(blocks, np.arange(n_blocks + 1))


def _tile(weights: FloatArray, kernels: FloatArray, modes: IndexArray, grid: _Grid) -> FloatArray:
    """Return time signals of the bins, folded at 0 and the Nyquist frequency."""
    bins = np.zeros((len(weights), (len(modes) - 1) * BLOCK + WIDTH), complex)
    wide = bins.view(float)
    for block in np.flatnonzero(np.diff(modes)).tolist():
        inside = slice(modes[block], modes[block + 1])
        wide[:, 2 * BLOCK * block :][:, : kernels.shape[1]] += weights[:, inside] @ kernels[inside]
    spectrum = bins[:, WIDTH : WIDTH + grid.n_bins]
    spectrum[:, :WIDTH] += np.conj(bins[:, WIDTH:0:-1])
    last = WIDTH + grid.n_bins - 1
    spectrum[:, -WIDTH:] += np.conj(bins[:, last : last + WIDTH][:, ::-1])
    return np.fft.irfft(spectrum, grid.n_fft)
