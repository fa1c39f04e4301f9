"""The response of damped oscillators to an impulse, exact at every sample.

g'' + (2 / tau) g' + omega^2 g = delta(t). Under-damped modes use e^{-t/tau} sin(w t) / w. The phase of each block of
samples is computed in double-double precision, so that errors do not grow with time. Over-damped modes use the slow
rate omega^2 / (1/tau + w), which avoids cancellation. Critical and rigid-body modes are limits of the same formula.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactometry.arguments.require import expect, one_of, positive

from ...arrays import ComplexArray, FloatArray, IndexArray

BLOCK: Final = 64
STILL_RAD_PER_S: Final = 1e-150
PER_TURN: Final = 0.15915494309189535
PER_TURN_LOW: Final = -9.839338337591243e-18
"""1 / (2 pi) as a pair of doubles."""

QUANTITIES: Final = ("displacement", "velocity", "acceleration")


@dataclass(frozen=True, eq=False)
class Oscillators:
    """Damped oscillators of unit mass.

    Parameters
    ----------
    omega_rad_per_s, decay_per_s : (n,) arrays
        Undamped angular frequency and 1 / tau, each at least 0.
    """

    omega_rad_per_s: FloatArray
    decay_per_s: FloatArray

    @property
    def n(self) -> int:
        return len(self.omega_rad_per_s)

    @property
    def oscillates(self) -> NDArray[np.bool_]:
        return np.asarray(self.omega_rad_per_s > np.maximum(self.decay_per_s, STILL_RAD_PER_S))

    @property
    def split_rad_per_s(self) -> FloatArray:
        """Damped frequency, or half the distance between the two rates: |omega^2 - 1/tau^2|^(1/2)."""
        omega, decay = self.omega_rad_per_s, self.decay_per_s
        # divided by the larger one: the square of a rate may overflow
        larger = np.maximum(np.maximum(omega, decay), np.finfo(float).tiny)
        apart, together = np.abs(omega - decay) / larger, (omega + decay) / larger
        return np.asarray(larger * np.sqrt(apart * together))

    def impulse(self, rate_hz: float, start: int, stop: int, quantity: str = "displacement") -> FloatArray:
        """Return the impulse response at samples start to stop - 1.

        The acceleration does not include the impulse itself.
        """
        one_of("Oscillators.impulse.quantity", quantity, QUANTITIES)
        out = np.empty((self.n, stop - start))
        swings = self.oscillates
        if swings.any():
            out[swings] = self.of(swings)._swinging(rate_hz, start, stop, quantity)
        if not swings.all():
            time_s = np.arange(start, stop) / rate_hz
            out[~swings] = _creeping(self.of(~swings), time_s, quantity)
        return out

    def impulse_at(self, time_s: ArrayLike, quantity: str = "displacement") -> FloatArray:
        """Return the response (n, n_times) at any times, at least 0."""
        one_of("Oscillators.impulse_at.quantity", quantity, QUANTITIES)
        time = np.atleast_1d(np.asarray(time_s, float))
        out = np.empty((self.n, len(time)))
        swings = self.oscillates
        swinging = self.of(swings)
        out[swings] = (swinging._phasor(time, 1.0) * swinging._weight(quantity)[:, None]).imag
        out[~swings] = _creeping(self.of(~swings), time, quantity)
        return out

    def step(self, step_s: float) -> tuple[FloatArray, FloatArray]:
        """Return displacement and velocity (n,) at one time after the impulse."""
        if not self.oscillates.all():
            return self.impulse_at(step_s)[:, 0], self.impulse_at(step_s, "velocity")[:, 0]
        turned = self._phasor(np.array([step_s]), 1.0)[:, 0]
        moved, moving = (turned * self._weight(quantity) for quantity in QUANTITIES[:2])
        return np.asarray(moved.imag), np.asarray(moving.imag)

    def analytic(self, rate_hz: float, sample: int, quantity: str = "displacement") -> ComplexArray:
        """Return the analytic signal (n,) of all modes, which must oscillate, at one sample."""
        return self._phasor(np.array([float(sample)]), rate_hz)[:, 0] * self._weight(quantity)

    def compliance(self, mass_kg: float, s: ComplexArray) -> ComplexArray:
        """Return 1 / (M (s^2 + 2 a s + w^2)) at complex s (rad/s)."""
        decay_per_s = self.decay_per_s
        if (decay_per_s == decay_per_s[:1]).all():
            decay_per_s = decay_per_s[:1]  # one row for all modes
        stiffness = s * (s + 2 * decay_per_s[:, None]) + self.omega_rad_per_s[:, None] ** 2
        stiffness *= mass_kg
        return np.divide(1, stiffness, out=stiffness)

    def of(self, which: NDArray[np.bool_] | IndexArray) -> "Oscillators":
        """Return the oscillators selected by a mask or by indices."""
        return Oscillators(self.omega_rad_per_s[which], self.decay_per_s[which])

    def _swinging(self, rate_hz: float, start: int, stop: int, quantity: str) -> FloatArray:
        """Return Im of w e^{(-1/tau + i w_d) t} by blocks of phases."""
        first, last = start // BLOCK, (stop - 1) // BLOCK + 1
        anchors = self._phasor(np.arange(first, last) * float(BLOCK), rate_hz) * self._weight(quantity)[:, None]
        inner = self._phasor(np.arange(float(BLOCK)), rate_hz)
        # Im(a b) = Re a Im b + Im a Re b, for all blocks of a mode as one real product
        left = np.stack([anchors.real, anchors.imag], axis=2)
        right = np.stack([inner.imag, inner.real], axis=1)
        out = np.matmul(left, right).reshape(self.n, -1)
        return np.asarray(out[:, start - first * BLOCK : stop - first * BLOCK])

    def _weight(self, quantity: str) -> ComplexArray:
        pole = -self.decay_per_s + 1j * self.split_rad_per_s
        return np.asarray(pole ** QUANTITIES.index(quantity) / self.split_rad_per_s)

    def _phasor(self, sample: NDArray[np.floating], rate_hz: float) -> ComplexArray:
        turning = unit_phasor(self.split_rad_per_s[:, None], sample, rate_hz)
        return np.asarray(turning * np.exp(-self.decay_per_s[:, None] * (sample / rate_hz)))


def unit_phasor(omega_rad_per_s: FloatArray, sample: NDArray[np.floating], rate_hz: float) -> ComplexArray:
    """Return exp(i omega sample / rate), accurate at any phase.

    Product and quotient are pairs of doubles; the sine reduces the first exactly.
    """
    product, product_low = _two_product(omega_rad_per_s, sample)
    phase = product / rate_hz
    # rounding error of the quotient, from multiplying it back
    back, back_low = _two_product(phase, np.float64(rate_hz))
    phase_low = ((product - back) - back_low + product_low) / rate_hz
    return np.asarray(np.exp(1j * phase) * (1 + 1j * phase_low - phase_low**2 / 2))


def turns(omega_rad_per_s: FloatArray, sample: float, rate_hz: float) -> tuple[FloatArray, FloatArray]:
    """Return omega sample / (2 pi rate) as a pair of doubles."""
    product, product_low = _two_product(omega_rad_per_s, np.float64(sample))
    turned, turned_low = _two_product(product, np.float64(PER_TURN))
    high = turned / rate_hz
    back, back_low = _two_product(high, np.float64(rate_hz))
    rest = (turned - back) - back_low + turned_low + product * PER_TURN_LOW + product_low * PER_TURN
    return np.asarray(high), np.asarray(rest / rate_hz)


def _two_product(a: FloatArray, b: NDArray[np.floating] | np.float64) -> tuple[FloatArray, FloatArray]:
    """Return Dekker's exact product: a b = high + low."""
    high = np.asarray(a * b)
    a_high, b_high = _upper_half(np.asarray(a)), _upper_half(np.asarray(b))
    a_low, b_low = a - a_high, b - b_high
    low = ((a_high * b_high - high) + a_high * b_low + a_low * b_high) + a_low * b_low
    return high, np.asarray(low)


def _upper_half(a: NDArray[np.floating]) -> FloatArray:
    shifted = 134217729.0 * a  # 2^27 + 1: Veltkamp's splitting of 53 bits into halves
    return np.asarray(shifted - (shifted - a))


def _creeping(modes: Oscillators, time_s: FloatArray, quantity: str) -> FloatArray:
    """Return the response (n, n_times) of modes that do not oscillate."""
    # the slow rate, and its distance to the fast one
    split = modes.split_rad_per_s
    fast = modes.decay_per_s + split
    slow = np.divide(modes.omega_rad_per_s**2, fast, out=np.zeros_like(fast), where=fast > 0)[:, None]
    distance = 2 * split[:, None]

    x = distance * time_s
    ratio = np.divide(-np.expm1(-x), x, out=np.ones_like(x), where=x > 0)
    decayed, ramp = np.exp(-slow * time_s), np.asarray(time_s * ratio)
    displacement = decayed * ramp
    velocity = decayed * (np.exp(-distance * time_s) - slow * ramp)
    if quantity == "acceleration":
        stiffness = modes.omega_rad_per_s[:, None] ** 2
        return np.asarray(-2 * modes.decay_per_s[:, None] * velocity - stiffness * displacement)
    return np.asarray(displacement if quantity == "displacement" else velocity)


def check_sampling(rate_hz: float, n_samples: int) -> None:
    """Raise an error unless the rate is above 0 and the length at least 0."""
    positive("sampling", rate_hz=rate_hz)
    expect(n_samples >= 0, "n_samples", n_samples, "at least 0")
