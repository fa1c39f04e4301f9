"""Constants of a plate from what was measured on it (thesis 3.4.2), each with a 95 % interval.

The attenuation constant comes from impulse responses: a decay above a floor, fitted to the log energy of blocks.
The backward integral of Schroeder bends down at the end of a record and flattens on its noise, which biases a slope
read from it; the model E(t) = A (exp(-2 t / tau) + N) holds in a cut record and above a floor.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.annotations import Positive, Unbounded, Vector
from tactometry.arguments.checked import checked
from tactometry.arguments.require import between, expect, positive_array
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray, IndexArray
from ..plate.plate import Plate

N_BLOCKS: Final = 32
LEAST_FALL_DB: Final = 10.0
FAINTEST: Final = 1e-7
"""A record ends with its last sample above this part of its peak (140 dB below)."""
LOWEST_LOG_FLOOR: Final = -69.0
"""Energies below this part (its logarithm) of the loudest block are taken as a floor: 300 dB."""
CONFIDENCE: Final = 0.95


@checked
@dataclass(frozen=True)
class MeasuredConstant:
    """A constant with the ends of its 95 % interval."""

    value: float
    low: Unbounded
    high: Unbounded


@checked
def schroeder_db(response: FloatArray) -> FloatArray:
    """Energy still to come at each sample, in dB of the whole; minus infinity after the last."""
    expect(np.any(response), "response", "zero everywhere", "an impulse response")
    to_come = np.cumsum(np.square(response)[..., ::-1], axis=-1)[..., ::-1]
    with np.errstate(divide="ignore"):
        return np.asarray(10 * np.log10(to_come / to_come[..., :1]))


@checked
@dataclass(frozen=True)
class Decay:
    """Energy over a record as A (exp(-2 n_taus t) + floor), t from 0 to 1; `fall_db` from the loudest to the end."""

    n_taus: float
    floor: float
    fall_db: float


@checked
def tau_s(response: Vector, rate_hz: Positive) -> float:
    """Time constant of the amplitude of one response.

    Raises `InvalidParameter` if the response is silent, or falls by less than 10 dB until it ends or drowns in its
    floor.

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
    """Fit of the log energy (`N_BLOCKS`,) of equal blocks, from the loudest on; `kept` of them if given."""
    if len(energy) != N_BLOCKS or energy.min() < 0 or not energy.any():
        raise InvalidParameter(f"energy: found {len(energy)} blocks, expected {N_BLOCKS} of at least 0, not all zero")
    first = _first(energy)
    kept = np.arange(first, N_BLOCKS) if kept is None else kept
    time = (kept + 0.5) / N_BLOCKS
    level = np.log(np.maximum(energy[kept], energy.max() * math.exp(LOWEST_LOG_FLOOR)))
    # from a floor far below the record, in it, and near its beginning: the closest fit counts
    fits = [_fit(time, level, log_floor) for log_floor in (-60.0, -25.0, -3.0)]
    _, n_taus, log_floor = min(fits)[1]
    ends = np.exp(-2 * n_taus * np.array([first / N_BLOCKS, 1.0])) + math.exp(log_floor)
    return Decay(n_taus, math.exp(log_floor), float(10 * np.log10(ends[0] / ends[1])))


def _fit(time: FloatArray, level: FloatArray, log_floor: float) -> tuple[float, tuple[float, ...]]:
    """Cost and (ln A, n_taus, ln floor) of the least squares that starts at a floor."""
    from scipy.optimize import least_squares

    def misfit(x: FloatArray) -> FloatArray:
        return np.asarray(x[0] + np.logaddexp(-2 * x[1] * time, x[2]) - level)

    def slopes(x: FloatArray) -> FloatArray:
        # of the decay in the energy; the floor has the rest
        share = np.exp(-2 * x[1] * time - np.logaddexp(-2 * x[1] * time, x[2]))
        return np.stack([np.ones_like(time), -2 * time * share, 1 - share], axis=1)

    middle = len(time) // 2
    start = float(np.clip((level[0] - level[middle]) / (2 * (time[middle] - time[0])), 0.1, 400.0))
    limits = ([-np.inf, 1e-3, LOWEST_LOG_FLOOR], [np.inf, 500.0, 5.0])
    solution = least_squares(misfit, [level[0], start, log_floor], slopes, bounds=limits)
    return float(solution.cost), tuple(map(float, solution.x))


def _blocks(responses: FloatArray, rate_hz: float) -> tuple[FloatArray, float]:
    """(n, `N_BLOCKS`) mean energy of equal blocks up to the last sound, and their whole length in s."""
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
    if decay.fall_db < LEAST_FALL_DB:
        raise InvalidParameter(
            f"response: found a fall by {decay.fall_db:.1f} dB until it ends or drowns in its floor, expected at least "
            f"{LEAST_FALL_DB:.0f} dB; learn longer responses, or average more of them"
        )
    return decay


@checked
def mean_estimate(values: Vector, confidence: float = CONFIDENCE) -> MeasuredConstant:
    """The mean with its interval from Student's t; infinite with fewer than two values."""
    from scipy.stats import t

    between("mean_estimate", 0, 1, confidence=confidence)
    mean = float(np.mean(values))
    if len(values) < 2:
        return MeasuredConstant(mean, -np.inf, np.inf)
    half = float(t.ppf((1 + confidence) / 2, len(values) - 1) * np.std(values, ddof=1) / np.sqrt(len(values)))
    return MeasuredConstant(mean, mean - half, mean + half)


@checked
def rigidity_ratio_from_modes(measured_hz: ArrayLike, guess: Plate) -> MeasuredConstant:
    """D / rho_s from measured modal frequencies, assigned to the modes of a plate that is known but for its glass.

    Each measured frequency, in ascending order, goes to the nearest mode of `guess` on a logarithmic scale, times
    the common factor of those before it; the first goes to the first mode. Frequencies depend on D / rho_s by
    its square root, and through the edges weakly on Poisson's ratio, which is taken from `guess`.

    Parameters
    ----------
    measured_hz : sequence of float
        Ascending, above 0, from the first elastic mode on; later modes may be missing.
    guess : Plate
        Size, edges and Poisson's ratio as measured; modulus and density of the right order.
    """
    measured = np.asarray(measured_hz, float)
    positive_array("rigidity_ratio_from_modes.measured_hz", measured)
    if measured.ndim != 1 or len(measured) == 0 or not (np.diff(measured) >= 0).all():
        raise InvalidParameter(f"measured_hz: found {measured.tolist()}, expected ascending frequencies above 0")
    factor = measured[0] / _elastic(guess, 4.0)[0]
    model = _elastic(guess, 1.2 * measured[-1] / factor)
    if len(model) < len(measured):
        raise InvalidParameter(
            f"measured_hz: found {len(measured)} modes up to {measured[-1]} Hz, the plate has {len(model)} there"
        )
    return _geometric(2 * np.log(guess.wave_constant_m2_per_s * measured / _nearest(measured, model)))


@checked
def youngs_modulus_pa(rigidity_ratio: MeasuredConstant, plate: Plate) -> MeasuredConstant:
    """Y = 12 (1 - nu^2) rho_s (D / rho_s) / h^3 with the density, thickness and Poisson's ratio of `plate`."""
    factor = 12 * (1 - plate.poisson_ratio**2) * plate.area_density_kg_per_m2 / plate.thickness_m**3
    ratios = rigidity_ratio.value, rigidity_ratio.low, rigidity_ratio.high
    return MeasuredConstant(*(factor * ratio for ratio in ratios))


def _elastic(plate: Plate, f_max_hz: float) -> FloatArray:
    """Frequencies above 0, at least one: the range doubles until it holds a mode."""
    frequencies = plate.frequencies_hz(f_max_hz)
    elastic = frequencies[frequencies > 0]
    return elastic if len(elastic) else _elastic(plate, 2 * f_max_hz)


def _nearest(measured: FloatArray, model: FloatArray) -> FloatArray:
    """(n_measured,): the mode that each belongs to, by the mean factor of those before it."""
    # in logarithms a wrong rigidity shifts all modes alike
    heard, modes = np.log(measured), np.log(model)
    paired = modes[:1]
    for i in range(1, len(heard)):
        expected = modes + np.mean(heard[:i] - paired)
        paired = np.append(paired, modes[np.argmin(np.abs(heard[i] - expected))])
    return np.asarray(np.exp(paired))


def _geometric(logarithms: FloatArray) -> MeasuredConstant:
    inside = mean_estimate(logarithms)
    return MeasuredConstant(*(float(np.exp(logarithm)) for logarithm in (inside.value, inside.low, inside.high)))
