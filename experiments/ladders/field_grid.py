"""The field of many modes on a grid, against its value between the points of the grid."""

from functools import partial

import numpy as np

from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
from tactometry.stimuli.time_reversal.plate.modes import Modes, modes_of, values

from ..cost.problem import Problem, Real, Reference, Rung

F_MAX_HZ = 20e3
POINTS_PER_M = (200, 400, 800, 1600, 3200)
N_POINTS = 4000
GOLDEN = 0.6180339887498949


def problem() -> Problem:
    """Cubic splines between the points of the grid, in the maximum norm over the peak."""
    modes = modes_of(A4_SCREEN, F_MAX_HZ)
    amplitude = np.cos(np.arange(len(modes.frequency_hz)) * 2.4)
    points = _points()
    return Problem(
        f"largest error between grid points over the peak, A4 plate, {len(amplitude)} modes, bicubic",
        reference=Reference("the sum over modes at points", lambda: values(modes, *points).T @ amplitude, 1e-12),
        independent=Reference("sines written out", lambda: _sines(amplitude, points), 1e-12),
        error=_error,
        rungs=tuple(Rung(f"{n} per m", partial(_field, modes, amplitude, n)) for n in POINTS_PER_M),
    )


def _points() -> tuple[Real, Real]:
    n = np.arange(N_POINTS)
    across = np.asarray(n * GOLDEN % 1, dtype=np.float64)
    return A4_SCREEN.length_m * (n + 0.5) / N_POINTS, A4_SCREEN.width_m * across


def _field(modes: Modes, amplitude: Real, per_m: int) -> tuple[Real, Real, Real]:
    x_m = np.linspace(0, A4_SCREEN.length_m, round(A4_SCREEN.length_m * per_m) + 1)
    y_m = np.linspace(0, A4_SCREEN.width_m, round(A4_SCREEN.width_m * per_m) + 1)
    return x_m, y_m, modes.field(amplitude, x_m, y_m)


def _error(found: tuple[Real, Real, Real] | Real, reference: Real) -> float:
    at_points = _interpolation(found) if isinstance(found, tuple) else found
    return float(np.abs(at_points - reference).max() / np.abs(reference).max())


def _interpolation(found: tuple[Real, Real, Real]) -> Real:
    from scipy.interpolate import RectBivariateSpline

    return np.asarray(RectBivariateSpline(*found).ev(*_points()))


def _sines(amplitude: Real, points: tuple[Real, Real]) -> Real:
    """Navier's shapes written out, in the order of their frequencies."""
    m, n = np.meshgrid(np.arange(1, 80), np.arange(1, 80), indexing="ij")
    k2 = (m / A4_SCREEN.length_m) ** 2 + (n / A4_SCREEN.width_m) ** 2
    order = np.argsort(k2, axis=None, kind="stable")[: len(amplitude)]
    shapes = (
        2
        * np.sin(np.pi * np.outer(m.ravel()[order], points[0] / A4_SCREEN.length_m))
        * np.sin(np.pi * np.outer(n.ravel()[order], points[1] / A4_SCREEN.width_m))
    )
    return np.asarray(amplitude @ shapes)
