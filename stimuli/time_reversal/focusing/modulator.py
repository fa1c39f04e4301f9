"""Sigma-delta modulators of first and second order, all channels at once.

Error feedback with two levels: y = u - e1 (first), y = u - 2 e1 + e2 (second), v = sign(y), e = v - y, so that V = U +
(1 - z^-1)^L E. Time is the outer loop and channels are the inner one, so that the compiler can vectorise over channels.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tactometry.arguments.require import expect, finite_array

from ...arrays import FloatArray

STATE_LIMIT: Final = {1: 2.0, 2: 10.0}
"""Largest |y| of a stable modulator of each order. For the first, 2 is exact for |u| <= 1. For the second, |y| stays
below 6 at |u| = 0.7 and exceeds 10 at 0.9 (simulation, no theorem)."""
FEEDBACK: Final = {1: (1.0, 0.0), 2: (2.0, -1.0)}


@dataclass(frozen=True, eq=False)
class BitStream:
    """The bits of a modulator and its largest state.

    `bits` (n_channels, n_samples) are -1 or +1, one byte each; `peak_state` is the largest |y|, and `limit` the largest
    |y| of a stable modulator: 2 for the first order with |u| <= 1, 10 by simulation for the second.
    """

    bits: NDArray[np.int8]
    peak_state: float
    limit: float

    @property
    def overloaded(self) -> bool:
        return self.peak_state > self.limit * (1 + 1e-12)


def modulate(signal: FloatArray, order: int) -> BitStream:
    """Return the bit stream of each channel.

    Parameters
    ----------
    signal : (n_channels, n_samples) array
        Finite values; the modulator is stable for |u| <= 1 (first order) or about 0.7 (second). The transpose of a
        contiguous (n_samples, n_channels) array saves a copy.
    order : int
        1 or 2.

    >>> modulate(np.full((1, 8), 0.5), 1).bits[0].mean()
    np.float64(0.5)
    """
    expect(order in (1, 2), "order", order, "1 or 2")
    by_time = np.ascontiguousarray(signal.T)
    bits = np.empty(by_time.shape, np.int8)
    peak, error = _modulate(by_time, bits, *FEEDBACK[order])
    if not np.isfinite(error).all():  # a value that is not finite never leaves the feedback
        finite_array("modulate.signal", signal)
    return BitStream(bits.T, float(peak.max(initial=0.0)), STATE_LIMIT[order])


@njit(cache=True, error_model="numpy")  # type: ignore[untyped-decorator]
def _modulate(signal: FloatArray, bits: NDArray[np.int8], b1: float, b2: float) -> tuple[FloatArray, FloatArray]:
    """Run y = u - b1 e1 - b2 e2; return the largest |y| and each last e1."""
    n_samples, n_channels = signal.shape
    e1, e2, peak = np.zeros(n_channels), np.zeros(n_channels), np.zeros(n_channels)
    for t in range(n_samples):
        now, emitted = signal[t], bits[t]
        for c in range(n_channels):
            y = now[c] - b1 * e1[c] - b2 * e2[c]
            e2[c] = e1[c]
            e1[c] = (1.0 if y >= 0 else -1.0) - y
            peak[c] = abs(y) if abs(y) > peak[c] else peak[c]
            emitted[c] = 1 if y >= 0 else -1
    return peak, e1
