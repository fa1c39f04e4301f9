"""A contact area that grows as a power of the force that presses the finger."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments import require
from tactometry.arguments.checked import checked
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray
from ...composition.effect import Effect, Stage, Surroundings


@dataclass(frozen=True)
class PowerLawArea(Effect):
    """``A = A_1 (F/1 N)^m``. Both defaults are unverified: 1 cm^2 at 1 N, m = 1/3 (a Hertz sphere has 2/3).

    >>> float(PowerLawArea().area_m2(8.0).round(12))
    0.0002
    """

    kind = "contact_area"
    slot = "area"
    positive = ("area_at_1n_m2",)
    not_negative = ("exponent",)
    requires = ("contact",)
    assumes = ("the area is a power of the force, and no other after a time",)

    area_at_1n_m2: float = 1e-4
    exponent: float = 1 / 3

    @checked
    def area_m2(self, force_n: ArrayLike) -> FloatArray:
        force = pressed_forces(force_n)
        with np.errstate(over="ignore"):
            # without force no contact, where an exponent of 0 would give 0 ** 0 = 1
            area_m2 = np.where(force > 0, self.area_at_1n_m2 * force**self.exponent, 0.0)
        return require.in_range("PowerLawArea.exponent", area_m2)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        settings = {**vars(self), "force_n": scene.contacts[0].force_n}
        return (Stage("contact_area", (), "area_m2", f"{__name__}:pressed", settings),)


def pressed(force_n: float, **law: float) -> Callable[[], float]:
    """The area under a force."""
    area_m2 = float(PowerLawArea(**law).area_m2(force_n))
    return lambda: area_m2


def pressed_forces(force_n: ArrayLike) -> FloatArray:
    force = require.finite_array("force_n", force_n)
    if (force < 0).any():
        raise InvalidParameter(f"force_n: found {force.min()}, expected at least 0 N")
    return force
