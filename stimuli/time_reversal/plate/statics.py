"""Static deflection and bending stress under a finger."""

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.checked import Positive, checked
from tactometry.arguments.require import expect, whole, within

from ...arrays import FloatArray
from .plate import Plate
from .rectangle import SineAxis

# terms of Levy's sum, and of Navier's sum along each side
N_TERMS: Final = 20_000
N_TERMS_PATCH: Final = 1_200
RITZ_DEGREE: Final = 50


@checked
def deflection_m(plate: Plate, force_n: float, at_m: tuple[float, float], x_m: ArrayLike, y_m: ArrayLike) -> FloatArray:
    """Return the static deflection at points under a point force.

    Raises `InvalidParameter` if the force or a point is outside of the plate, the force is not finite, or the edges
    leave a rigid-body motion.

    Parameters
    ----------
    plate : Plate
        Plate whose edges prevent rigid-body motion.
    force_n : float
    at_m : (float, float)
        Where the force acts.
    x_m, y_m : (n_points,) arrays

    Returns
    -------
    (n_points,) array. Levy's sum for simply supported edges, with a relative error of 1e-9. Ritz for other edges,
    within 0.2 % at the force and 1e-5 away from it.

    >>> from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
    >>> round(float(deflection_m(A4_SCREEN, 2.0, (0.1485, 0.105), 0.1485, 0.105)[0]) * 1e6)
    178
    """
    plate.check_holds("at_m", at_m)
    expect(not plate.rectangle.n_rigid, "Plate.boundary", repr(plate.boundary), "edges that prevent rigid-body motion")
    whole("deflection_m", lowest=1, n_x=np.size(x_m), n_y=np.size(y_m))
    x, y = np.broadcast_arrays(np.atleast_1d(x_m), np.atleast_1d(y_m))
    for i, place in enumerate(zip(x.ravel(), y.ravel(), strict=True)):
        plate.check_holds(f"(x_m, y_m)[{i}]", place)
    solve = _levy if plate.boundary == "SSSS" else _ritz
    return force_n * solve(plate, at_m, x.astype(float), y.astype(float))


@checked
def bending_stress_pa(plate: Plate, force_n: float, contact_m: Positive) -> float:
    """Return the largest stress under a square load at the centre.

    The edges are taken as simply supported, regardless of `plate.boundary`. The square's side `contact_m` is above 0
    and at most the plate's shorter side, else `InvalidParameter`.

    sigma = 6 M_y / h^2 with M_y = -D (u_yy + nu u_xx), or M_x if that is larger, by Navier's sum. A point
    force would give an infinite stress.

    >>> from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
    >>> round(bending_stress_pa(A4_SCREEN, 2.0, 10e-3) / 1e6, 1)
    3.6
    """
    within("bending_stress_pa", 0.0, min(plate.length_m, plate.width_m), contact_m=contact_m)
    push_x, kx2 = _side_terms(plate.length_m, contact_m)
    push_y, ky2 = _side_terms(plate.width_m, contact_m)
    weight = np.outer(push_x, push_y) / (kx2[:, None] + ky2) ** 2
    along_x, along_y = float(kx2 @ weight.sum(axis=1)), float(weight.sum(axis=0) @ ky2)
    nu = plate.poisson_ratio
    moment_n = force_n / plate.area_m2 * max(along_x + nu * along_y, along_y + nu * along_x)
    return 6 * moment_n / plate.thickness_m**2


def _side_terms(side_m: float, contact_m: float) -> tuple[FloatArray, FloatArray]:
    """Return each sine's value times its contact mean, and its k^2."""
    axis, middle = SineAxis(side_m, N_TERMS_PATCH), side_m / 2
    load = axis.integral(middle - contact_m / 2, middle + contact_m / 2)[:, 0] / contact_m
    return axis.value(middle)[:, 0] * load, axis.wavenumber_rad_per_m**2


def _levy(plate: Plate, at_m: tuple[float, float], x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the deflection by one sine series across the plate."""
    axis = SineAxis(plate.length_m, N_TERMS)
    along = axis.value(at_m[0])[:, 0]
    across = np.stack([_across(axis.wavenumber_rad_per_m, plate.width_m, at_m[1], float(place)) for place in y])
    terms = axis.value(x).T * along * across
    return np.asarray(terms.sum(axis=1) / (plate.length_m * plate.bending_rigidity_n_m))


def _across(mu: FloatArray, width_m: float, y0: float, y: float) -> FloatArray:
    """Return -(1 / 2 mu) d/dmu of N / d; N: four images of exp(-mu distance), d = 2 mu (1 - exp(-2 mu b))."""
    apart = abs(y - y0)
    # an image in one edge changes the sign, an image in both does not
    distance = np.array([apart, y + y0, 2 * width_m - y - y0, 2 * width_m - apart])[:, None]
    images = np.array([1.0, -1.0, -1.0, 1.0])[:, None] * np.exp(-mu * distance)
    total, slope = images.sum(axis=0), -(distance * images).sum(axis=0)
    once = -np.expm1(-2 * mu * width_m)
    below, below_slope = 2 * mu * once, 2 * once + 4 * mu * width_m * np.exp(-2 * mu * width_m)
    return np.asarray(-(slope - total * below_slope / below) / (2 * mu * below))


def _ritz(plate: Plate, at_m: tuple[float, float], x: FloatArray, y: FloatArray) -> FloatArray:
    from scipy.linalg import solve

    from .ritz import ellipse, pairs, pencil

    scale = plate.length_m**3 / (4 * plate.bending_rigidity_n_m * plate.width_m)
    rectangle, degrees = plate.rectangle, (RITZ_DEGREE, RITZ_DEGREE)
    total = np.zeros(len(x))
    for on_x, on_y in pairs(rectangle, degrees):
        i, j = ellipse(on_x, on_y, *degrees)
        stiffness, _ = pencil(rectangle, on_x, on_y, i, j)
        load = on_x.axis.value(at_m[0])[i, 0] * on_y.axis.value(at_m[1])[j, 0]
        coefficients = solve(stiffness, load, assume_a="pos")
        total += coefficients @ (on_x.axis.value(x)[i] * on_y.axis.value(y)[j])
    return scale * total
