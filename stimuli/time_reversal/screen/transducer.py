"""Transducers: point forces and bonded piezoelectric patches."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Protocol, runtime_checkable

import numpy as np

from tactometry.arguments.checked import Positive, checked
from tactometry.arguments.require import expect, some, whole

from ...arrays import FloatArray
from ...defaults import VACUUM_PERMITTIVITY_F_PER_M
from ..plate.modes import Modes, laplacians, values
from ..plate.plate import Plate

MOMENT_N_PER_V: Final = 8.2e-4
"""Bending moment per length and volt of a patch, calibrated so that
the one-bit drive of 0.2-60 kHz at 30 V makes a focus of 10 um on the A4 prototype."""

SIDE_M: Final = 10e-3
INSET_M: Final = 12e-3
"""Side of a square patch, and distance of its centre from the edges; ranges: `setup` in
`stimuli/sources.toml`."""

VOLTAGE_V: Final = 30.0
"""Peak of a drive, at which the default moment applies; unverified default."""

VOLTAGE_MAX_V: Final = 200.0
"""Largest voltage of an amplifier, above that of a default drive so that thresholds can be searched; a choice."""

PZ27_RELATIVE_PERMITTIVITY: Final = 1800.0
"""eps33T / eps0 of PZ27; unverified default."""

PZ27_LOSS_TANGENT: Final = 0.017
"""tan(delta) of PZ27 at small fields; unverified default."""

PATCH_THICKNESS_M: Final = 0.3e-3
"""Thickness of a patch; unverified default."""

MAX_TRANSDUCERS: Final = 10_000
EDGE_TOLERANCE: Final = 1e-9


@checked
def capacitance_f(
    area_m2: Positive, thickness_m: Positive, relative_permittivity: Positive = PZ27_RELATIVE_PERMITTIVITY
) -> float:
    """Return the capacitance eps A / t of a piezoelectric plate.

    >>> round(capacitance_f(1e-4, 0.3e-3) * 1e9, 2)
    5.31
    """
    return relative_permittivity * VACUUM_PERMITTIVITY_F_PER_M * area_m2 / thickness_m


PATCH_CAPACITANCE_F: Final = capacitance_f(SIDE_M**2, PATCH_THICKNESS_M)
"""Capacitance of a patch with these defaults."""


@runtime_checkable
class ForceSource(Protocol):
    """Interface of a transducer that drives the plate with one channel."""

    def modal_force(self, modes: Modes) -> FloatArray:
        """Return the generalised force on each mode per unit of the channel."""

    def check(self, plate: Plate, name: str) -> None:
        """Raise an error for a place outside the plate."""


@checked
@dataclass(frozen=True)
class PointForce:
    """A normal force at a point; the channel's unit is N."""

    x_m: float
    y_m: float

    def modal_force(self, modes: Modes) -> FloatArray:
        return values(modes, self.x_m, self.y_m)[:, 0]

    def check(self, plate: Plate, name: str) -> None:
        plate.check_holds(name, (self.x_m, self.y_m))


@checked
@dataclass(frozen=True)
class Patch:
    """A rectangular patch that bends the plate by a moment along its outline; the channel's unit is V.

    The generalised force is -m V times the integral of the shape's Laplacian over the patch, exact for both kinds of
    modes.

    Parameters
    ----------
    x_m, y_m : float
        Centre of the patch.
    length_m, width_m : float
        Sides along x and y, above 0.
    moment_n_per_v : float
        Bending moment per length and volt (N m / m / V).
    """

    x_m: float
    y_m: float
    length_m: Positive
    width_m: Positive
    moment_n_per_v: float = MOMENT_N_PER_V

    @property
    def area_m2(self) -> float:
        return self.length_m * self.width_m

    def modal_force(self, modes: Modes) -> FloatArray:
        x = (self.x_m - self.length_m / 2, self.x_m + self.length_m / 2)
        y = (self.y_m - self.width_m / 2, self.y_m + self.width_m / 2)
        bent_x = modes.products(lambda axis: axis.curvature_integral(*x), lambda axis: axis.integral(*y))
        bent_y = modes.products(lambda axis: axis.integral(*x), lambda axis: axis.curvature_integral(*y))
        return -self.moment_n_per_v * (bent_x + bent_y)[:, 0]

    def check(self, plate: Plate, name: str) -> None:
        _inside(plate, name, (self.x_m, self.y_m), (self.length_m / 2, self.width_m / 2))


@checked
@dataclass(frozen=True)
class DiscPatch:
    """A circular `Patch`, integrated with Gauss's rule along the radius and at equal angles.

    Parameters
    ----------
    x_m, y_m : float
        Centre of the patch.
    diameter_m : float
        Diameter of the patch, above 0.
    moment_n_per_v : float
        Bending moment per length and volt (N m / m / V).
    """

    x_m: float
    y_m: float
    diameter_m: Positive
    moment_n_per_v: float = MOMENT_N_PER_V

    @property
    def area_m2(self) -> float:
        return math.pi * self.diameter_m**2 / 4

    def modal_force(self, modes: Modes) -> FloatArray:
        x, y, weights = self._rule(modes)
        return -self.moment_n_per_v * (laplacians(modes, x, y) @ weights)

    def check(self, plate: Plate, name: str) -> None:
        _inside(plate, name, (self.x_m, self.y_m), (self.diameter_m / 2, self.diameter_m / 2))

    def _rule(self, modes: Modes) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return integration points and weights that resolve the shortest wave."""
        radius = self.diameter_m / 2
        k_max = math.sqrt(modes.angular_frequency_rad_per_s.max(initial=0) / modes.plate.wave_constant_m2_per_s)
        n_radii = 12 + math.ceil(k_max * radius)
        nodes, weights = np.polynomial.legendre.leggauss(n_radii)
        r = radius * (nodes + 1) / 2
        angle = np.arange(2 * n_radii) * (math.pi / n_radii)
        x = self.x_m + np.outer(r, np.cos(angle))
        y = self.y_m + np.outer(r, np.sin(angle))
        area = np.outer(weights * r * radius / 2, np.full(angle.size, math.pi / n_radii))
        return x.ravel(), y.ravel(), area.ravel()


@checked
def modal_forces(modes: Modes, sources: Sequence[ForceSource]) -> FloatArray:
    """Return each source's generalised force on each mode.

    Raises `InvalidParameter` if there is no source, or one is outside of the plate.
    """
    some("modal_forces.sources", sources)
    for i, source in enumerate(sources):
        source.check(modes.plate, f"sources[{i}]")
    return np.stack([source.modal_force(modes) for source in sources], axis=1)


@checked
def border(
    plate: Plate,
    n_transducers: int,
    side_m: float = SIDE_M,
    inset_m: float = INSET_M,
    moment_n_per_v: float = MOMENT_N_PER_V,
) -> list[Patch]:
    """Place square patches at equal steps along a rectangle (unverified).

    >>> from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
    >>> len(border(A4_SCREEN, 32))
    32
    """
    whole("border", lowest=1, highest=MAX_TRANSDUCERS, n_transducers=n_transducers)
    a, b = plate.length_m - 2 * inset_m, plate.width_m - 2 * inset_m
    expect(min(a, b) > 0 and side_m <= 2 * inset_m, "inset_m", inset_m, f"room for patches of {side_m} m on the plate")
    along = (np.arange(n_transducers) + 0.5) / n_transducers * 2 * (a + b)
    corners = np.array([0, a, a + b, 2 * a + b, 2 * (a + b)])
    x = inset_m + np.interp(along, corners, [0, a, a, 0, 0])
    y = inset_m + np.interp(along, corners, [0, 0, b, b, 0])
    places = zip(x, y, strict=True)
    return [Patch(float(at_x), float(at_y), side_m, side_m, moment_n_per_v) for at_x, at_y in places]


def _inside(plate: Plate, name: str, centre: tuple[float, float], half: tuple[float, float]) -> None:
    room = EDGE_TOLERANCE * max(plate.length_m, plate.width_m)
    for at, reach, side in zip(centre, half, (plate.length_m, plate.width_m), strict=True):
        found = f"a transducer of {2 * half[0]} x {2 * half[1]} m at {centre} m"
        expected = f"one within the plate of {plate.length_m} x {plate.width_m} m"
        expect(reach - room <= at <= side - reach + room, name, found, expected)
