"""Frequencies of a plate by Ritz, against the number of functions: simply supported edges, and free ones."""

from functools import partial

import numpy as np

from tactometry.stimuli.time_reversal.plate.plate import Plate, degrees, ritz_frequencies_hz
from tactometry.stimuli.time_reversal.plate.ritz import solve

from ..cost.problem import Problem, Real, Reference, Rung

F_MAX_HZ = 5e3
SIDE_M = 0.2
DEGREES = (13, 16, 19, 22)
FINEST = 38
ROUNDING = 1e-10
PUBLISHED = (13.46820, 19.59614, 24.27020, 34.80089, 34.80089, 61.09323)
"""``omega a^2 (rho h/D)^(1/2)`` of a free square plate, Poisson's ratio 0.3, to seven digits."""


def simply_supported() -> Problem:
    """Against Navier's closed form."""
    plate = _square("SSSS")
    return Problem(
        f"largest error of the frequencies below {F_MAX_HZ / 1e3:g} kHz, 0.2 m square, edges S",
        reference=Reference("Navier's closed form", lambda: plate.frequencies_hz(F_MAX_HZ), ROUNDING),
        independent=Reference("Navier's formula, written anew", lambda: _navier_hz(plate), ROUNDING),
        error=largest,
        rungs=_rungs(plate),
    )


def free() -> Problem:
    """Against far more functions; the lowest six against values that are published."""
    plate = _square("FFFF")
    constant = plate.wave_constant_m2_per_s / SIDE_M**2 / (2 * np.pi)
    return Problem(
        f"largest error of the frequencies below {F_MAX_HZ / 1e3:g} kHz, 0.2 m square, edges F",
        reference=Reference("38 degrees", lambda: _frequencies_hz(plate, FINEST), ROUNDING),
        independent=Reference("published values of the square plate", lambda: constant * np.array(PUBLISHED), 4e-7),
        error=largest,
        rungs=_rungs(plate),
    )


def largest(found: Real, reference: Real) -> float:
    """Largest relative error of the frequencies, as far as both lists go."""
    n = min(len(found), len(reference))
    return float(np.abs(found[:n] / reference[:n] - 1).max())


def _square(boundary: str) -> Plate:
    return Plate(SIDE_M, SIDE_M, 1e-3, 70e9, 0.3, 2500.0, boundary)


def _rungs(plate: Plate) -> tuple[Rung, ...]:
    rule = degrees(plate, F_MAX_HZ)[0]
    names = {degree: f"{degree} degrees{' (rule)' if degree == rule else ''}" for degree in sorted({*DEGREES, rule})}
    return tuple(Rung(name, partial(_frequencies_hz, plate, degree)) for degree, name in names.items())


def _frequencies_hz(plate: Plate, degree: int) -> Real:
    solve.cache_clear()  # the last solutions are kept; a price is that of solving
    return ritz_frequencies_hz(plate, F_MAX_HZ, (degree, degree))[plate.rectangle.n_rigid :]


def _navier_hz(plate: Plate) -> Real:
    order = np.arange(1, 100) ** 2
    all_hz = plate.wave_constant_m2_per_s * np.pi / 2 / SIDE_M**2 * np.add.outer(order, order)
    return np.sort(all_hz[all_hz <= F_MAX_HZ])
