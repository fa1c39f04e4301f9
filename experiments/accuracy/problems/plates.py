"""Accuracy problems of plates and their load: natural frequencies, fields, and the impedance of a pulp."""

import math
from collections.abc import Iterator
from functools import partial

import numpy as np

from tactometry.stimuli.arrays import ComplexArray
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
from tactometry.stimuli.time_reversal.plate.modes import Modes, modes_of
from tactometry.stimuli.time_reversal.plate.plate import Plate, degrees, ritz_frequencies_hz
from tactometry.stimuli.time_reversal.plate.ritz import solve
from tactometry.stimuli.time_reversal.pulp import N_PRESSURES, PulpLoad, Tissue, disc_stiffness

from ..measure import Problem, Real, Reference, Setting

F_MAX_HZ, SIDE_M = 5e3, 0.2
DEGREES, FINEST_DEGREE = (13, 16, 19, 22), 38
ROUNDING = 1e-10
PUBLISHED = (13.46820, 19.59614, 24.27020, 34.80089, 34.80089, 61.09323)
"""``omega a^2 (rho h/D)^(1/2)`` of a free square plate with a Poisson's ratio of 0.3, to seven digits."""
MIXED, MIXED_TO_HZ = Plate(0.2, 0.14, 1e-3, 70e9, 0.3, 2500.0, "SFSF"), 4e3
"""Edges: simply supported (S) at x = 0 and x = length, free (F) at y = 0 and y = width."""
FEWER = (19, 17, 15, 13, 11, 9)
N_SCANNED = 400
FIELD_TO_HZ, POINTS_PER_M, N_POINTS = 20e3, (200, 400, 800, 1600, 3200), 4000
GOLDEN = 0.6180339887498949
PULP, PULP_S = PulpLoad(0.1, 0.1, 6e-3, Tissue()), np.asarray(2j * np.pi * np.geomspace(1e3, 6e4, 200))
PRESSURES_AND_PATHS, FINEST_PULP = ((1, 1), (2, 1), (4, 1), (N_PRESSURES, 1), (N_PRESSURES, 8), (10, 32)), (20, 128)


def square(boundary: str) -> Plate:
    """Return a square plate with sides of 0.2 m."""
    return Plate(SIDE_M, SIDE_M, 1e-3, 70e9, 0.3, 2500.0, boundary)


def simply_supported() -> Problem:
    """Compare natural frequencies with Navier's closed form."""
    plate = square("SSSS")
    return Problem(
        f"largest error of the frequencies below {F_MAX_HZ / 1e3:g} kHz, 0.2 m square, edges S",
        reference=Reference("Navier's closed form", lambda: _navier_hz(plate), ROUNDING),
        error=_largest,
        settings=_by_degree(plate),
    )


def free() -> Problem:
    """Compare natural frequencies with those from many more basis functions."""
    plate = square("FFFF")
    constant = plate.wave_constant_m2_per_s / SIDE_M**2 / (2 * np.pi)
    return Problem(
        f"largest error of the frequencies below {F_MAX_HZ / 1e3:g} kHz, 0.2 m square, edges F",
        reference=Reference("38 degrees", lambda: _elastic_hz(plate, FINEST_DEGREE), ROUNDING),
        independent=Reference("published values for the square plate", lambda: constant * np.array(PUBLISHED), 4e-7),
        error=_largest,
        settings=_by_degree(plate),
    )


def _largest(found: Real, reference: Real) -> float:
    n = min(len(found), len(reference))
    return float(np.abs(found[:n] / reference[:n] - 1).max())


def _by_degree(plate: Plate) -> tuple[Setting, ...]:
    rule = degrees(plate, F_MAX_HZ)[0]
    names = {degree: f"{degree} degrees{' (rule)' if degree == rule else ''}" for degree in sorted({*DEGREES, rule})}
    return tuple(Setting(name, partial(_elastic_hz, plate, degree)) for degree, name in names.items())


def _elastic_hz(plate: Plate, degree: int) -> Real:
    return _ritz_hz(plate, F_MAX_HZ, degree, degree)[plate.rectangle.n_rigid :]


def _ritz_hz(plate: Plate, f_max_hz: float, p_x: int, p_y: int) -> Real:
    solve.cache_clear()  # else the price would be that of a cached solution
    return ritz_frequencies_hz(plate, f_max_hz, (p_x, p_y))


def _navier_hz(plate: Plate) -> Real:
    order = np.arange(1, 100) ** 2
    all_hz = plate.wave_constant_m2_per_s * np.pi / 2 / SIDE_M**2 * np.add.outer(order, order)
    return np.sort(all_hz[all_hz <= F_MAX_HZ])


def mixed_edges() -> Problem:
    """Compare a plate with edges S and F with Levy's solution."""
    p_x, p_y = degrees(MIXED, MIXED_TO_HZ)
    ritz = partial(_ritz_hz, MIXED, MIXED_TO_HZ)
    return Problem(
        f"largest error of the frequencies below {MIXED_TO_HZ / 1e3:g} kHz, 0.2 x 0.14 m, two edges S, two F",
        reference=Reference("Levy's solution", levy_hz, 1e-11),
        error=_largest,
        settings=tuple(
            Setting(f"{p_x - k} x {p_y - k}{'' if k else ' (rule)'}", partial(ritz, p_x - k, p_y - k)) for k in FEWER
        ),
    )


def levy_hz() -> Real:
    """Return Levy's frequencies of a plate with two opposite edges S.

    Leissa, Vibration of Plates, NASA SP-160 (1969), section 4.2. Hyperbolic functions are divided by their growth.
    """
    k_max = math.sqrt(2 * math.pi * MIXED_TO_HZ / MIXED.wave_constant_m2_per_s)
    n_max = math.ceil(MIXED.length_m * k_max / math.pi) + 1
    wavenumbers = [k for m in range(1, n_max) for k in _wavenumbers(m * math.pi / MIXED.length_m, k_max)]
    return np.sort(MIXED.wave_constant_m2_per_s * np.square(wavenumbers) / (2 * np.pi))


def _wavenumbers(along_rad_per_m: float, k_max_rad_per_m: float) -> Iterator[float]:
    """Yield the wavenumbers that satisfy the even or the odd condition."""
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
    """Return the determinant of moment and force at y = +-width / 2.

    The functions are w = cosh(p y) and cos(q y), or their odd partners.
    """
    half, bent = MIXED.width_m / 2, (1 - MIXED.poisson_ratio) * a * a
    p, moment, force = math.sqrt(k * k + a * a), k * k + bent, k * k - bent
    q2 = k * k - a * a
    at = math.sqrt(abs(q2)) * half
    cos, sinc = (math.cos(at), float(np.sinc(at / np.pi))) if q2 > 0 else (1.0, math.tanh(at) / max(at, 1e-300))
    if parity:
        return p * force**2 * sinc * half - moment**2 * math.tanh(p * half) * cos
    return q2 * moment**2 * sinc * half + p * force**2 * math.tanh(p * half) * cos


def field_grid() -> Problem:
    """Compare spline interpolation on a grid with the exact field."""
    modes = modes_of(A4_SCREEN, FIELD_TO_HZ)
    amplitude = np.cos(np.arange(len(modes.frequency_hz)) * 2.4)
    n = np.arange(N_POINTS)
    points = A4_SCREEN.length_m * (n + 0.5) / N_POINTS, A4_SCREEN.width_m * np.asarray(n * GOLDEN % 1)
    return Problem(
        f"largest error between grid points over the peak, A4 plate, {len(amplitude)} modes, bicubic",
        reference=Reference("the sum of sines at the points", lambda: _sines(amplitude, points), 1e-12),
        error=partial(_field_error, points),
        settings=tuple(Setting(f"{n} per m", partial(_field, modes, amplitude, n)) for n in POINTS_PER_M),
    )


def _field(modes: Modes, amplitude: Real, per_m: int) -> tuple[Real, Real, Real]:
    sides_m = A4_SCREEN.length_m, A4_SCREEN.width_m
    x_m, y_m = (np.linspace(0, side_m, round(side_m * per_m) + 1) for side_m in sides_m)
    return x_m, y_m, modes.field(amplitude, x_m, y_m)


def _field_error(points: tuple[Real, Real], found: tuple[Real, Real, Real] | Real, reference: Real) -> float:
    from scipy.interpolate import RectBivariateSpline

    at_points = RectBivariateSpline(*found).ev(*points) if isinstance(found, tuple) else found
    return float(np.abs(at_points - reference).max() / np.abs(reference).max())


def _sines(amplitude: Real, points: tuple[Real, Real]) -> Real:
    m, n = np.meshgrid(np.arange(1, 80), np.arange(1, 80), indexing="ij")
    k2 = (m / A4_SCREEN.length_m) ** 2 + (n / A4_SCREEN.width_m) ** 2
    order = np.argsort(k2, axis=None, kind="stable")[: len(amplitude)]
    along = np.sin(np.pi * np.outer(m.ravel()[order], points[0] / A4_SCREEN.length_m))
    across = np.sin(np.pi * np.outer(n.ravel()[order], points[1] / A4_SCREEN.width_m))
    return np.asarray(amplitude @ (2 * along * across))


def pulp_impedance() -> Problem:
    """Compare the impedance of a pulp with that from more pressure functions and a longer path."""
    settings = [
        Setting(f"{n} pressures, path x {path}", partial(_pulp_stiffness, n, path)) for n, path in PRESSURES_AND_PATHS
    ]
    default = Setting(f"{N_PRESSURES}, polynomial (default)", lambda: PULP.dynamic_stiffness(PULP_S))
    return Problem(
        f"largest relative error of the impedance from 1 to 60 kHz, disc with a radius of {PULP.radius_m * 1e3:g} mm",
        reference=Reference("20 pressures, path x 128", partial(_pulp_stiffness, *FINEST_PULP), 1e-7),
        error=lambda stiffness, reference: float(np.abs(stiffness / reference - 1).max()),
        settings=(*settings[:3], default, *settings[3:]),
    )


def _pulp_stiffness(n_pressures: int, path: float) -> ComplexArray:
    return disc_stiffness(PULP_S, PULP.radius_m, PULP.tissue, n_pressures=n_pressures, path_factor=path)
