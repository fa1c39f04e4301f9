"""Functions that meet only what an edge forces on them: two edges held, two free, against Levy's solution."""

import math
from collections.abc import Iterator
from functools import partial

import numpy as np

from tactometry.stimuli.time_reversal.plate.plate import Plate, degrees, ritz_frequencies_hz
from tactometry.stimuli.time_reversal.plate.ritz import solve

from ..cost.problem import Problem, Real, Reference, Rung
from .plate_modes import largest

F_MAX_HZ = 4e3
PLATE = Plate(0.2, 0.14, 1e-3, 70e9, 0.3, 2500.0, "SFSF")
FEWER, FINEST = (19, 17, 15, 13, 11, 9), 4
N_SCANNED = 400


def problem() -> Problem:
    """Edges S at x = 0 and x = length, edges F at y = 0 and y = width: free edges are met by convergence alone."""
    p_x, p_y = degrees(PLATE, F_MAX_HZ)
    return Problem(
        f"largest error of the frequencies below {F_MAX_HZ / 1e3:g} kHz, 0.2 x 0.14 m, two edges S, two F",
        reference=Reference("Levy's solution", levy_hz, 1e-11),
        independent=Reference("4 degrees more than the rule", lambda: _ritz_hz(p_x + FINEST, p_y + FINEST), 1e-9),
        error=largest,
        rungs=tuple(
            Rung(f"{p_x - k} x {p_y - k}{'' if k else ' (rule)'}", partial(_ritz_hz, p_x - k, p_y - k)) for k in FEWER
        ),
    )


def _ritz_hz(p_x: int, p_y: int) -> Real:
    solve.cache_clear()  # the last solutions are kept; a price is that of solving
    return ritz_frequencies_hz(PLATE, F_MAX_HZ, (p_x, p_y))


def levy_hz() -> Real:
    """Frequencies of a plate between two simply supported edges: sines along x, four functions along y.

    Leissa, Vibration of Plates, NASA SP-160 (1969), section 4.2; hyperbolic functions are divided by their growth.
    """
    k_max = math.sqrt(2 * math.pi * F_MAX_HZ / PLATE.wave_constant_m2_per_s)
    n_max = math.ceil(PLATE.length_m * k_max / math.pi) + 1
    wavenumbers = [k for m in range(1, n_max) for k in _wavenumbers(m * math.pi / PLATE.length_m, k_max)]
    return np.sort(PLATE.wave_constant_m2_per_s * np.square(wavenumbers) / (2 * np.pi))


def _wavenumbers(along_rad_per_m: float, k_max_rad_per_m: float) -> Iterator[float]:
    """Roots k of the even and the odd condition of free edges; the lowest lie a little below the wavenumber along x."""
    from scipy.optimize import brentq

    scan = np.linspace(0.5 * along_rad_per_m, max(k_max_rad_per_m, along_rad_per_m), N_SCANNED)
    for parity in (0, 1):
        values = [_condition(k, along_rad_per_m, parity) for k in scan]
        for low, high, here, there in zip(scan, scan[1:], values, values[1:], strict=False):
            if here * there < 0:
                root = float(brentq(_condition, low, high, args=(along_rad_per_m, parity), xtol=1e-13))
                if root <= k_max_rad_per_m:
                    yield root


def _condition(k: float, a: float, parity: int) -> float:
    """No moment and no force at y = +-width / 2, for w = cosh(p y) and cos(q y), or their odd partners."""
    half, bent = PLATE.width_m / 2, (1 - PLATE.poisson_ratio) * a * a
    p, moment, force = math.sqrt(k * k + a * a), k * k + bent, k * k - bent
    q2 = k * k - a * a
    q = math.sqrt(abs(q2))
    at = q * half
    cos, sinc = (math.cos(at), float(np.sinc(at / np.pi))) if q2 > 0 else (1.0, math.tanh(at) / max(at, 1e-300))
    if parity:
        return p * force**2 * sinc * half - moment**2 * math.tanh(p * half) * cos
    return q2 * moment**2 * sinc * half + p * force**2 * math.tanh(p * half) * cos
