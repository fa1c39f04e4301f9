"""Exact one-step recurrences of the modal oscillators.

State (q, q') after a step h: [[g' + 2 a g, g], [-omega^2 g, g']] with g the impulse response at h
(`Oscillators.impulse_at`) and a = 1/tau; forces either as impulses at the samples or linear between them (first-order
hold).
"""

from typing import Final

import numpy as np
from numba import njit

from ...arrays import ComplexArray, FloatArray, IntArray
from .oscillators import Oscillators

SERIES_BELOW: Final = 0.5
NEAR_CRITICAL: Final = 0.05


def transition(oscillators: Oscillators, step_s: float) -> FloatArray:
    """Return the map (n, 2, 2) of the free motion over one step."""
    g, slope = oscillators.step(step_s)
    omega2, a = oscillators.omega_rad_per_s**2, oscillators.decay_per_s
    return np.stack([np.stack([slope + 2 * a * g, g], -1), np.stack([-omega2 * g, slope], -1)], -2)


def linear_input(oscillators: Oscillators, step_s: float) -> FloatArray:
    """Return weights (n, 2, 2) of the forces at start and end of a step.

    phi_1 = (e^z - 1)/z, phi_2 = (phi_1 - 1)/z at the poles; near critical damping and for slow modes, where the poles
    coincide, a matrix exponential is used.
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
    """Return displacements (n, n_kept) after impulses (n, n_samples).

    `keep` are ascending samples; impulses are per unit mass.
    """
    return np.asarray(_impulses(transition(oscillators, 1 / rate_hz), np.ascontiguousarray(impulses.T), keep)).T


def run_linear(oscillators: Oscillators, forces: FloatArray, rate_hz: float) -> FloatArray:
    """Return displacements (n, n_samples) from rest under forces per unit mass.

    Forces (n, n_samples) are linear between samples.
    """
    step_s = 1 / rate_hz
    weights = linear_input(oscillators, step_s)
    return np.asarray(_linear(transition(oscillators, step_s), weights, np.ascontiguousarray(forces.T))).T


def _phi(z: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    small = np.abs(z) < SERIES_BELOW
    safe = np.where(small, 1.0, z)
    one = np.expm1(safe) / safe
    two = (one - 1) / safe  # near 0 a series avoids cancellation; `one` follows from it
    series = np.ones(np.count_nonzero(small), np.complex128)  # 1/2! + z/3! + z^2/4! + ...
    for k in range(17, 2, -1):
        series = 1.0 + z[small] / k * series
    two[small] = series / 2
    one[small] = 1 + z[small] * two[small]
    return one, two


def _pole_weights(pole: ComplexArray, step_s: float) -> ComplexArray:
    """Return weights (n, 2) of start and end force in y' = pole y + f."""
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
    """Return a step's force weights from an augmented matrix exponential."""
    from scipy.linalg import expm

    w, d = omega * step_s, a * step_s
    whole = expm(np.array([[0, 1, 0, 0], [-w * w, -2 * d, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0]], float))
    constant, ramp = whole[:2, 2], whole[:2, 3]
    return np.asarray(np.stack([constant - ramp, ramp], axis=1) * np.array([[step_s**2], [step_s]]))


@njit(cache=True, error_model="numpy")  # type: ignore[untyped-decorator]
def _impulses(step: FloatArray, impulses: FloatArray, keep: IntArray) -> FloatArray:
    """Run the impulses with time as the outer and modes as the inner loop."""
    n_samples, n = impulses.shape
    out = np.zeros((len(keep), n))
    q, v = np.zeros(n), np.zeros(n)
    # copies, so that the inner loop reads memory in order
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
