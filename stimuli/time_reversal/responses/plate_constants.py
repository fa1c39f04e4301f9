"""Attenuation constant of a plate from measured responses (thesis 3.4.2).

A decay above a noise floor is fitted to the log energy of blocks. Schroeder's backward integral bends down at the end
of a record and flattens in the noise, which biases its slope. The model E(t) = A (exp(-2 t / tau) + N) is valid for
truncated and noisy records.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from tactometry.arguments.annotations import Positive, Vector
from tactometry.arguments.checked import checked
from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray, IndexArray

N_BLOCKS: Final = 32
LEAST_FALL_DB: Final = 10.0
FAINTEST: Final = 1e-7
"""A record ends at its last sample above this part of its peak (-140 dB)."""
LOWEST_LOG_FLOOR: Final = -69.0
"""Logarithm of the lowest energy re the loudest block, -300 dB; lower energies count as this floor."""


@checked
def schroeder_db(response: FloatArray) -> FloatArray:
    """Return the remaining energy at each sample in dB (Schroeder)."""
    expect(np.any(response), "response", "zero everywhere", "an impulse response")
    to_come = np.cumsum(np.square(response)[..., ::-1], axis=-1)[..., ::-1]
    with np.errstate(divide="ignore"):
        return np.asarray(10 * np.log10(to_come / to_come[..., :1]))


@checked
@dataclass(frozen=True)
class Decay:
    """Fitted energy A (exp(-2 n_taus t) + floor), t from 0 to 1; `fall_db` is from the loudest block to the end."""

    n_taus: float
    floor: float
    fall_db: float


@checked
def tau_s(response: Vector, rate_hz: Positive) -> float:
    """Return the time constant of the amplitude of one response.

    Raises `InvalidParameter` if the response is silent, or falls by less than 10 dB before its end or noise floor.

    Parameters
    ----------
    response : (n_samples,) array

    >>> t = np.arange(10000) / 1e5
    >>> round(tau_s(np.exp(-t / 4e-3) * np.sin(1e4 * t), 1e5) * 1e3, 1)
    4.0
    """
    energy, length_s = _blocks(np.asarray(response, float)[None], rate_hz)
    return length_s / _clear_decay(energy[0]).n_taus


@checked
def decay_of(energy: Vector, kept: IndexArray | None = None) -> Decay:
    """Fit the log energy (`N_BLOCKS`,) of equal blocks."""
    if len(energy) != N_BLOCKS or energy.min() < 0 or not energy.any():
        raise InvalidParameter(f"energy: found {len(energy)} blocks, expected {N_BLOCKS} of at least 0, not all zero")
    first = _first(energy)
    kept = np.arange(first, N_BLOCKS) if kept is None else kept
    time = (kept + 0.5) / N_BLOCKS
    level = np.log(np.maximum(energy[kept], energy.max() * math.exp(LOWEST_LOG_FLOOR)))
    # start from a very low, a middle and a high floor, and keep the closest fit
    fits = [_fit(time, level, log_floor) for log_floor in (-60.0, -25.0, -3.0)]
    _, n_taus, log_floor = min(fits)[1]
    ends = np.exp(-2 * n_taus * np.array([first / N_BLOCKS, 1.0])) + math.exp(log_floor)
    return Decay(n_taus, math.exp(log_floor), float(10 * np.log10(ends[0] / ends[1])))


def _fit(time: FloatArray, level: FloatArray, log_floor: float) -> tuple[float, tuple[float, ...]]:
    """Return cost and (ln A, n_taus, ln floor) of a fit, given a first floor."""
    from scipy.optimize import least_squares

    def misfit(x: FloatArray) -> FloatArray:
        return np.asarray(x[0] + np.logaddexp(-2 * x[1] * time, x[2]) - level)

    def slopes(x: FloatArray) -> FloatArray:
        # share of the decay in the energy; the floor is the rest
        share = np.exp(-2 * x[1] * time - np.logaddexp(-2 * x[1] * time, x[2]))
        return np.stack([np.ones_like(time), -2 * time * share, 1 - share], axis=1)

    middle = len(time) // 2
    start = float(np.clip((level[0] - level[middle]) / (2 * (time[middle] - time[0])), 0.1, 400.0))
    limits = ([-np.inf, 1e-3, LOWEST_LOG_FLOOR], [np.inf, 500.0, 5.0])
    solution = least_squares(misfit, [level[0], start, log_floor], slopes, bounds=limits)
    return float(solution.cost), tuple(map(float, solution.x))


def _blocks(responses: FloatArray, rate_hz: float) -> tuple[FloatArray, float]:
    """Return the mean energy (n, `N_BLOCKS`) of blocks, and their length."""
    loudest = np.abs(responses).max(axis=0)
    sounding = np.flatnonzero(loudest > FAINTEST * loudest.max(initial=0.0))
    expect(len(sounding) > 0, "response", "zero everywhere", "an impulse response")
    size = (int(sounding[-1]) + 1) // N_BLOCKS
    expect(size >= 1, "response", f"{sounding[-1] + 1} samples", f"at least {N_BLOCKS}")
    cut = responses[:, : size * N_BLOCKS].reshape(-1, N_BLOCKS, size)
    return np.asarray(np.square(cut).mean(axis=2)), size * N_BLOCKS / rate_hz


def _first(energy: FloatArray) -> int:
    return max(1, int(np.argmax(energy)))


def _clear_decay(energy: FloatArray) -> Decay:
    expect(_first(energy) <= N_BLOCKS // 2, "response", "its loudest part in the second half", "a decay; learn longer")
    decay = decay_of(energy)
    found = f"a fall by {decay.fall_db:.1f} dB before its end or noise floor"
    expected = f"at least {LEAST_FALL_DB:.0f} dB; learn longer responses, or average more of them"
    expect(decay.fall_db >= LEAST_FALL_DB, "response", found, expected)
    return decay
