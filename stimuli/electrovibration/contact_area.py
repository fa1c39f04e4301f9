"""Contact area of a finger against the force that presses it."""

from dataclasses import dataclass
from math import pi
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactometry.errors import InvalidParameter
from tactometry.stimuli.electrovibration import require


class ContactArea(Protocol):
    """An area law."""

    def area_m2(self, force_n: ArrayLike) -> NDArray[np.float64]:
        """Area (m^2), of the shape of `force_n` (N, at least 0)."""


@dataclass(frozen=True)
class PowerLawArea:
    """``A = A_1 (F/1 N)^m``. Both defaults are unverified: 1 cm^2 at 1 N, m = 1/3 (a Hertz sphere has 2/3).

    >>> float(PowerLawArea().area_m2(8.0).round(12))
    0.0002
    """

    area_at_1n_m2: float = 1e-4
    exponent: float = 1 / 3

    def __post_init__(self) -> None:
        require.positive("PowerLawArea", area_at_1n_m2=self.area_at_1n_m2)
        require.non_negative("PowerLawArea", exponent=self.exponent)

    def area_m2(self, force_n: ArrayLike) -> NDArray[np.float64]:
        force = _forces(force_n)
        return np.where(force > 0, self.area_at_1n_m2 * force**self.exponent, 0.0)


def ellipse_area_m2(length_m: ArrayLike, width_m: ArrayLike) -> NDArray[np.float64]:
    """Area of an ellipse from its full axes: ``pi/4`` times their product.

    >>> float(ellipse_area_m2(0.02, 0.01).round(9))
    0.00015708
    """
    return pi / 4 * np.asarray(length_m, dtype=np.float64) * np.asarray(width_m, dtype=np.float64)


def _forces(force_n: ArrayLike) -> NDArray[np.float64]:
    force = require.finite_array("force_n", force_n)
    if (force < 0).any():
        raise InvalidParameter(f"force_n: found {force.min()}, expected at least 0 N")
    return force
