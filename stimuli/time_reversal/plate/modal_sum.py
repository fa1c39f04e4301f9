"""Exact one-step recurrences of the modal oscillators, for any damping and any step.

State (q, q') after a step h: [[g' + 2 a g, g], [-omega^2 g, g']] with g the impulse response at h
(`Oscillators.impulse_at`) and a = 1/tau; forces either as impulses at the samples or linear between them (first-order
hold).
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ...arrays import ComplexArray, FloatArray, IndexArray, IntArray, fast_length
from .oscillators import Oscillators, turns

SERIES_BELOW: Final = 0.5
NEAR_CRITICAL: Final = 0.05


def transition(oscillators: Oscillators, step_s: float) -> FloatArray:
    """(n, 2, 2): the free motion over one step."""
    g, slope = oscillators.step(step_s)
    omega2, a = oscillators.omega_rad_per_s**2, oscillators.decay_per_s
    return np.stack([np.stack([slope + 2 * a * g, g], -1), np.stack([-omega2 * g, slope], -1)], -2)


def linear_input(oscillators: Oscillators, step_s: float) -> FloatArray:
    """(n, 2, 2): weights of the force at both ends of a step on (q, q'), the force linear between.

    phi_1 = (e^z - 1)/z, phi_2 = (phi_1 - 1)/z at the poles; near the critical damping and for slow modes,
    where the poles meet, the matrix exponential.
    """
    omega, a = oscillators.omega_rad_per_s, oscillators.decay_per_s
    split = oscillators.split_rad_per_s
    out = np.empty((oscillators.n, 2, 2))
    close = (split <= NEAR_CRITICAL * np.maximum(omega, a)) | (split * step_s < 1e-3)
    swings = oscillators.oscillates & ~close
    creeps = ~oscillators.oscillates & ~close
    out[swings] = _swinging_input(-a[swings] + 1j * split[swings], step_s)
    out[creeps] = _creeping_input(omega[creeps], a[creeps], split[creeps], step_s)
    for mode in np.flatnonzero(close):
        out[mode] = _exponential_input(omega[mode], a[mode], step_s)
    return out


def run_impulses(oscillators: Oscillators, impulses: FloatArray, rate_hz: float, keep: IntArray) -> FloatArray:
    """(n, n_kept): displacements at samples `keep` (ascending) under impulses (n, n_samples) per unit mass."""
    return np.asarray(_impulses(transition(oscillators, 1 / rate_hz), np.ascontiguousarray(impulses.T), keep)).T


def run_linear(oscillators: Oscillators, forces: FloatArray, rate_hz: float) -> FloatArray:
    """(n, n_samples): displacements from rest under forces (n, n_samples) per unit mass, linear between samples."""
    step_s = 1 / rate_hz
    weights = linear_input(oscillators, step_s)
    return np.asarray(_linear(transition(oscillators, step_s), weights, np.ascontiguousarray(forces.T))).T


def _phi(z: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    small = np.abs(z) < SERIES_BELOW
    safe = np.where(small, 1.0, z)
    one = np.expm1(safe) / safe
    two = (one - 1) / safe  # near 0 a difference of near equals: there the series, from which `one` follows
    two[small] = _phi_2(z[small])
    one[small] = 1 + z[small] * two[small]
    return one, two


def _phi_2(z: ComplexArray) -> ComplexArray:
    """1/2! + z/3! + z^2/4! + ..."""
    total = np.ones(z.shape, np.complex128)
    for k in range(17, 2, -1):
        total = 1.0 + z / k * total
    return np.divide(total, 2)


def _pole_weights(pole: ComplexArray, step_s: float) -> ComplexArray:
    """(n, 2): weights of start and end on y' = pole y + f."""
    one, two = _phi(pole * step_s)
    weights: ComplexArray = np.stack([one - two, two], -1)
    return np.multiply(step_s, weights)


def _swinging_input(pole: ComplexArray, step_s: float) -> FloatArray:
    weights = _pole_weights(pole, step_s)
    both = np.stack([weights, pole[:, None] * weights], axis=1)
    return np.asarray(both.imag / pole.imag[:, None, None])


def _creeping_input(omega: FloatArray, a: FloatArray, split: FloatArray, step_s: float) -> FloatArray:
    fast = a + split
    slow = omega**2 / fast
    slow_weights = _pole_weights((-slow).astype(complex), step_s).real
    fast_weights = _pole_weights((-fast).astype(complex), step_s).real
    position = slow_weights - fast_weights
    speed = fast[:, None] * fast_weights - slow[:, None] * slow_weights
    return np.asarray(np.stack([position, speed], axis=1) / (2 * split)[:, None, None])


def _exponential_input(omega: float, a: float, step_s: float) -> FloatArray:
    from scipy.linalg import expm

    w, d = omega * step_s, a * step_s
    whole = expm(np.array([[0, 1, 0, 0], [-w * w, -2 * d, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0]], float))
    constant, ramp = whole[:2, 2], whole[:2, 3]
    return np.asarray(np.stack([constant - ramp, ramp], axis=1) * np.array([[step_s**2], [step_s]]))


@njit(cache=True, error_model="numpy")  # type: ignore[untyped-decorator]
def _impulses(step: FloatArray, impulses: FloatArray, keep: IntArray) -> FloatArray:
    """Time outside, modes inside: no mode waits for another."""
    n_samples, n = impulses.shape
    out = np.zeros((len(keep), n))
    q, v = np.zeros(n), np.zeros(n)
    # copies, so that the inner loop goes through memory in order
    a, b, c, d = step[:, 0, 0].copy(), step[:, 0, 1].copy(), step[:, 1, 0].copy(), step[:, 1, 1].copy()
    kept = 0
    for k in range(n_samples):
        for i in range(n):
            moved = a[i] * q[i] + b[i] * v[i]
            v[i] = c[i] * q[i] + d[i] * v[i] + impulses[k, i]
            q[i] = moved
        if kept < len(keep) and keep[kept] == k:
            out[kept] = q
            kept += 1
    return out


@njit(cache=True, error_model="numpy", fastmath={"contract"})  # type: ignore[untyped-decorator]
def _linear(step: FloatArray, weights: FloatArray, forces: FloatArray) -> FloatArray:
    n_samples, n = forces.shape
    out = np.empty((n_samples, n))
    out[:1] = 0.0
    q, v = np.zeros(n), np.zeros(n)
    a, b, c, d = step[:, 0, 0].copy(), step[:, 0, 1].copy(), step[:, 1, 0].copy(), step[:, 1, 1].copy()
    q0, q1, v0, v1 = (
        weights[:, 0, 0].copy(),
        weights[:, 0, 1].copy(),
        weights[:, 1, 0].copy(),
        weights[:, 1, 1].copy(),
    )
    for k in range(1, n_samples):
        start, end, now = forces[k - 1], forces[k], out[k]
        for i in range(n):
            moved = a[i] * q[i] + b[i] * v[i] + q0[i] * start[i] + q1[i] * end[i]
            v[i] = c[i] * q[i] + d[i] * v[i] + v0[i] * start[i] + v1[i] * end[i]
            q[i] = moved
            now[i] = moved
    return out


WIDTH: Final = 16
"""Bins of the kernel."""

LONGER: Final = 2.0
"""The grid over the signal."""

LARGEST_SPREAD: Final = 0.5
"""Of the decay rates times the duration: beyond, the kernel's continuation to complex frequencies costs digits."""

FEWEST_MODES: Final = 64
SHORTEST: Final = 128
TILE: Final = 32
"""Pairs that are transformed together: their grids stay in cache."""
BLOCK: Final = 64
"""Bins that are filled by one matrix product."""
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
    """(n_rows, stop - start): weights (n_rows, n_modes) times the impulse responses of the modes at samples
    start..stop-1; written to `out` if that is given.

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
        """The kernel's parameter for this ratio of grid and signal (Beatty et al., IEEE Trans. Med. Imaging 2005)."""
        ratio = self.n_fft / self.n
        return math.pi * math.sqrt((WIDTH * (ratio - 0.5) / ratio) ** 2 - 0.8)

    def kernel(self, bins: ComplexArray) -> ComplexArray:
        """I_0(beta (1 - (2 x / width)^2)^(1/2)) at distances x in bins, complex for a decay."""
        return np.asarray(
            np.polynomial.polynomial.polyval((self.beta / 2) ** 2 * (1 - (2 * bins / WIDTH) ** 2), BESSEL)
        )

    def transform(self) -> FloatArray:
        """(n,): the kernel's Fourier transform at the samples, width sinh(r) / r."""
        time = np.arange(self.n) - self.middle
        r = np.sqrt(self.beta**2 - (math.pi * WIDTH * time / self.n_fft) ** 2)
        return np.asarray(WIDTH * np.sinh(r) / r)


def _alike(oscillators: Oscillators, duration_s: float) -> NDArray[np.bool_]:
    """Modes that swing, and decay nearly as the median does."""
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
    """The sums over modes in ascending order, written to `out`."""
    grid = _Grid.of(out.shape[1])
    kernels, modes = _in_blocks(grid, *_spread_kernel(oscillators, grid, rate_hz, start, quantity))
    # the decay that the modes share is no part of the transform: from the middle, where their phases are taken
    decay = np.exp(-_common_decay(oscillators) / rate_hz * (np.arange(grid.n) - grid.middle))
    scale = decay * (grid.n_fft / 2) / grid.transform()
    # time before the middle lies at the end of a periodic signal
    late, early = slice(grid.middle, None), slice(None, grid.middle)
    for row in range(0, len(weights), TILE):
        rows = out[row : row + TILE]
        signal = _tile(weights[row : row + TILE], kernels, modes, grid)
        np.multiply(signal[:, : grid.n - grid.middle], scale[late], out=rows[:, late])
        np.multiply(signal[:, grid.n_fft - grid.middle :], scale[early], out=rows[:, early])
    if start == 0 and quantity == "displacement":
        out[:, 0] = 0.0  # every mode starts at rest; what rounding leaves has a sign, which one bit would emit


def _spread_kernel(
    oscillators: Oscillators, grid: _Grid, rate_hz: float, start: int, quantity: str
) -> tuple[IntArray, ComplexArray]:
    """(n,) first bins and (n, width) values of each mode, its phase at the middle of the signal included."""
    apart = oscillators.decay_per_s - _common_decay(oscillators)
    bins, rounded = turns(oscillators.split_rad_per_s, grid.n_fft, rate_hz)
    first = np.ceil(bins - WIDTH / 2).astype(np.int64)
    # a mode that decays otherwise than the rest lies beside the real axis of frequencies
    away = (bins - first) + rounded + 1j * (apart * (grid.n_fft / (2 * math.pi * rate_hz)))
    values = grid.kernel(np.arange(WIDTH).astype(complex) - away[:, None])
    return first, -1j * oscillators.analytic(rate_hz, start + grid.middle, quantity)[:, None] * values


def _in_blocks(grid: _Grid, first: IntArray, kernel: ComplexArray) -> tuple[FloatArray, IndexArray]:
    """(n, 2 (BLOCK + width)): kernels among the bins of the block in which they begin, as pairs of real numbers.

    And (n_blocks + 1,): the modes of each block, in order. The first bins are ascending, from -width.
    """
    blocks, place = np.divmod(first + WIDTH, BLOCK)
    kernels = np.zeros((len(first), BLOCK + WIDTH), complex)
    np.put_along_axis(kernels, place[:, None] + np.arange(WIDTH), kernel, axis=1)
    n_blocks = (grid.n_bins + 2 * WIDTH) // BLOCK + 1
    return kernels.view(float), np.searchsorted(blocks, np.arange(n_blocks + 1))


def _tile(weights: FloatArray, kernels: FloatArray, modes: IndexArray, grid: _Grid) -> FloatArray:
    """(n_rows, n_fft): what the spread bins become in time; bins beyond 0 and Nyquist fold back, conjugate."""
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
