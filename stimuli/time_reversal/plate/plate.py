"""Thin rectangular plates in closed form."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from tactometry.arguments.checked import Positive, checked
from tactometry.arguments.require import at_most, expect, positive, within
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray
from .rectangle import Rectangle, Sines, sines

if TYPE_CHECKING:
    from .ritz import ParityBlock


MAX_MODES: Final = 1_000_000
MARGIN_DEGREES: Final = 20
"""Degrees beyond the shortest wave, for an error of 1e-8 in every frequency
(`tests/stimuli/time_reversal/test_ritz.py`)."""
MAX_FUNCTIONS: Final = 16_000
"""Largest number of functions; their dense matrices take up to 2 GB each."""


@checked
@dataclass(frozen=True)
class Plate:
    """An isotropic Kirchhoff-Love plate from 0 to length in x and 0 to width in y.

    Parameters
    ----------
    length_m : float
        Length of the plate along x.
    width_m : float
        Width of the plate along y.
    thickness_m : float
        Thickness of the plate.
    youngs_modulus_pa : float
        Young's modulus of its material.
    density_kg_per_m3 : float
        Density of its material.
    poisson_ratio : float
        Poisson ratio of its material, from 0 to 0.5.
    boundary : str
        Four letters, S (simply supported), C (clamped) or F (free), for x = 0, y = 0, x = length, y = width.

    >>> plate = Plate(0.297, 0.210, 1.1e-3, 64e9, 0.20, 2230.0, "SSSS")
    >>> [round(float(f), 1) for f in plate.frequencies_hz(300.0)]
    [92.8, 185.5, 278.3]
    """

    length_m: Positive
    width_m: Positive
    thickness_m: Positive
    youngs_modulus_pa: Positive
    poisson_ratio: float
    density_kg_per_m3: Positive
    boundary: str

    def __post_init__(self) -> None:
        within("Plate", 0.0, 0.5, poisson_ratio=self.poisson_ratio)
        found = repr(self.boundary)
        expected = "four letters of S, C, F for the edges x=0, y=0, x=length, y=width, such as 'SSSS'"
        expect(len(self.boundary) == 4 and set(self.boundary) <= set("SCF"), "Plate.boundary", found, expected)

    @property
    def area_m2(self) -> float:
        return self.length_m * self.width_m

    @property
    def perimeter_m(self) -> float:
        return 2 * (self.length_m + self.width_m)

    @property
    def area_density_kg_per_m2(self) -> float:
        return self.density_kg_per_m3 * self.thickness_m

    @property
    def mass_kg(self) -> float:
        return self.area_density_kg_per_m2 * self.area_m2

    @property
    def rotary_inertia_kg(self) -> float:
        """Rotary inertia per area, rho h^3 / 12."""
        return self.area_density_kg_per_m2 * self.thickness_m**2 / 12

    @property
    def bending_rigidity_n_m(self) -> float:
        """Bending rigidity D = Y h^3 / (12 (1 - nu^2))."""
        return self.youngs_modulus_pa * self.thickness_m**3 / (12 * (1 - self.poisson_ratio**2))

    @property
    def wave_constant_m2_per_s(self) -> float:
        """Ratio of omega to the squared wavenumber, sqrt(D / rho_s)."""
        return math.sqrt(self.bending_rigidity_n_m / self.area_density_kg_per_m2)

    @property
    def modal_density_s(self) -> float:
        """Modes per hertz at high frequency, S / (2 sqrt(D / rho_s))."""
        return self.area_m2 / (2 * self.wave_constant_m2_per_s)

    @property
    def point_impedance_n_s_per_m(self) -> float:
        """Driving-point impedance of the infinite plate, 8 sqrt(D rho_s)."""
        return 8 * math.sqrt(self.bending_rigidity_n_m * self.area_density_kg_per_m2)

    def contains(self, x_m: float, y_m: float) -> bool:
        """Return True if a point lies on the plate or its edges."""
        return 0 <= x_m <= self.length_m and 0 <= y_m <= self.width_m

    def check_holds(self, name: str, at_m: tuple[float, float]) -> None:
        """Raise an error that names the argument if a point is off the plate."""
        if not self.contains(*at_m):
            x_m, y_m = map(float, at_m)
            raise InvalidParameter(
                f"{name}: found ({x_m}, {y_m}) m, expected a point of the plate of {self.length_m} x {self.width_m} m"
            )

    @property
    def rectangle(self) -> Rectangle:
        """The rectangle, whose parameters determine the mode shapes."""
        return Rectangle(self.length_m, self.width_m, self.boundary, self.poisson_ratio)

    def frequencies_hz(self, f_max_hz: float) -> FloatArray:
        """Return sorted natural frequencies up to `f_max_hz`, rigid ones 0 Hz.

        Raises `InvalidParameter` if `f_max_hz` is not above 0 or needs more modes than one solution can contain.
        """
        if self.boundary == "SSSS":
            return self.wave_constant_m2_per_s * navier(self, f_max_hz).wavenumber2_per_m2 / (2 * math.pi)
        return ritz_frequencies_hz(self, f_max_hz)


@checked
def navier(plate: Plate, f_max_hz: float) -> Sines:
    """Return the simply supported thin plate's modes up to a frequency.

    Raises `InvalidParameter` if there are too many.
    """
    k2_max = _wavenumber2_per_m2(plate, f_max_hz)
    at_most("number of modes below f_max_hz", plate.area_m2 * k2_max / (4 * math.pi), MAX_MODES)
    at_most("modes along an edge below f_max_hz", plate.perimeter_m * math.sqrt(k2_max) / math.pi, MAX_MODES)
    return sines(plate.rectangle, k2_max)


@checked
def ritz(plate: Plate, f_max_hz: float, degree: tuple[int, int] | None = None) -> Sequence["ParityBlock"]:
    """Return the thin plate's Ritz modes with any edges up to a frequency."""
    # not imported for simply supported edges
    from .ritz import solve

    return solve(plate.rectangle, _wavenumber2_per_m2(plate, f_max_hz), degree or degrees(plate, f_max_hz))


@checked
def ritz_frequencies_hz(plate: Plate, f_max_hz: float, degree: tuple[int, int] | None = None) -> FloatArray:
    """Return the frequencies of `ritz`, sorted."""
    wavenumber2_per_m2 = np.concatenate([block.wavenumber2_per_m2 for block in ritz(plate, f_max_hz, degree)])
    return plate.wave_constant_m2_per_s * np.sort(wavenumber2_per_m2) / (2 * math.pi)


@checked
def degrees(plate: Plate, f_max_hz: float) -> tuple[int, int]:
    """Return the degrees in x and y needed for modes up to `f_max_hz`.

    Raises `InvalidParameter` if there are too many functions for the memory.
    """
    p_x, p_y = degrees_called_for(plate, f_max_hz)
    # products within an ellipse, see `ritz.ellipse`
    if math.pi / 4 * p_x * p_y > MAX_FUNCTIONS:
        raise InvalidParameter(
            f"f_max_hz: found {f_max_hz}, which needs {p_x} x {p_y} functions, more than can be held; "
            "lower f_max_hz or use the simply supported plate"
        )
    return p_x, p_y


@checked
def degrees_called_for(plate: Plate, f_max_hz: float) -> tuple[int, int]:
    """Return the needed degrees without a limit, for a cost estimate."""
    half_k = math.sqrt(_wavenumber2_per_m2(plate, f_max_hz)) / 2
    p_x, p_y = (math.ceil(half_k * side) + MARGIN_DEGREES for side in (plate.length_m, plate.width_m))
    return p_x, p_y


def _wavenumber2_per_m2(plate: Plate, f_max_hz: float) -> float:
    positive("Plate", f_max_hz=f_max_hz)
    return 2 * math.pi * f_max_hz / plate.wave_constant_m2_per_s
