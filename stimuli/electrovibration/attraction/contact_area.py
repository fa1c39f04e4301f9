"""Contact area of a finger as a function of its normal force."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments import require
from tactometry.arguments.checked import NotNegativeArray, Positive, checked
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray
from ...composition.effect import Effect

if TYPE_CHECKING:
    from tactometry.contact import Contact


class AreaLaw(Effect):
    """An area law as an effect of a scene: the contact area of the finger."""

    kind = "contact_area"
    slot = "area"
    requires = ("contact",)
    reads, gives = ("contact",), "area_m2"

    def area_m2(self, force_n: ArrayLike) -> FloatArray:
        """Return the area (m^2) at `force_n` (N, at least 0), in its shape."""
        raise NotImplementedError

    def __call__(self, contact: "Contact") -> float:
        return float(self.area_m2(contact.force_n))


@dataclass(frozen=True)
class PowerLawArea(AreaLaw):
    """An area that is a power of the force, ``A = A_1 (F/1 N)^m``.

    The defaults, 1 cm^2 at 1 N and m = 1/3, are from memory (a Hertz sphere has 2/3).

    Parameters
    ----------
    area_at_1n_m2 : float
        Area at 1 N.
    exponent : float
        Exponent of the force.

    >>> float(PowerLawArea().area_m2(8.0).round(12))
    0.0002
    """

    positive = ("area_at_1n_m2",)
    not_negative = ("exponent",)
    assumes = ("the area is a power of the force and does not change over time",)

    area_at_1n_m2: float = 1e-4
    exponent: float = 1 / 3

    @checked
    def area_m2(self, force_n: NotNegativeArray) -> FloatArray:
        force = np.asarray(force_n, dtype=np.float64)
        with np.errstate(over="ignore"):
            # no contact without force: an exponent of 0 would return 0 ** 0 = 1
            area_m2 = np.where(force > 0, self.area_at_1n_m2 * force**self.exponent, 0.0)
        return require.in_range("PowerLawArea.exponent", area_m2)


@runtime_checkable
class ContactArea(Protocol):
    """Interface of an area law."""

    def area_m2(self, force_n: ArrayLike) -> FloatArray:
        """Return the area (m^2) at `force_n` (N, at least 0), in its shape."""


@checked
@dataclass(frozen=True)
class TableArea(AreaLaw):
    """Areas measured at several forces, with linear interpolation between them, as used for ink prints.

    Parameters
    ----------
    forces_n, areas_m2 : tuple of float
        Ascending forces and their areas, all above 0. Below the first force the area is proportional to the force. A
        force above the last one raises an error.

    >>> prints = TableArea((0.2, 1.5), (0.5e-4, 1.5e-4))
    >>> (prints.area_m2([0.0, 0.1, 0.85]) * 1e4).round(9).tolist()
    [0.0, 0.25, 1.0]
    """

    assumes = ("the area is interpolated linearly between measured areas",)

    forces_n: tuple[float, ...]
    areas_m2: tuple[float, ...]

    def __post_init__(self) -> None:
        fit = len(self.forces_n) == len(self.areas_m2) > 0
        counts = f"{len(self.forces_n)} forces and {len(self.areas_m2)} areas"
        require.expect(fit, "TableArea", counts, "equal numbers, at least one")
        for force_n, area_m2 in zip(self.forces_n, self.areas_m2, strict=True):
            require.positive("TableArea", force_n=force_n, area_m2=area_m2)
        rise = (np.diff(self.forces_n) > 0).all()
        require.expect(rise, "TableArea.forces_n", self.forces_n, "ascending forces")

    def area_m2(self, force_n: NotNegativeArray) -> FloatArray:
        """Return the area (m^2) at `force_n` (N, up to the last of the table)."""
        force = np.asarray(force_n, dtype=np.float64)
        if force.size and force.max() > self.forces_n[-1]:
            raise InvalidParameter(
                f"TableArea: found a force of {force.max()} N, expected at most the last of the table "
                f"({self.forces_n[-1]} N); measure further or use a PowerLawArea"
            )
        return np.asarray(np.interp(force, (0.0, *self.forces_n), (0.0, *self.areas_m2)))


@checked
@dataclass(frozen=True)
class Print:
    """A fingerprint: an ellipse with full axes measured at a normal force.

    >>> round(Print(force_n=1.5, length_m=0.014, width_m=0.011).area_m2 * 1e4, 4)
    1.2095
    """

    force_n: Positive
    length_m: Positive
    width_m: Positive

    @property
    def area_m2(self) -> float:
        return float(ellipse_area_m2(self.length_m, self.width_m))


UNVERIFIED_PRINTS = (
    Print(0.2, 0.0090, 0.0070),
    Print(1.5, 0.0140, 0.0110),
    Print(3.0, 0.0160, 0.0125),
    Print(7.0, 0.0180, 0.0142),
)
"""Unverified default: plausible axes at the four forces of the inked prints. Measure those of your participants."""


@checked
def area_of_prints(prints: Sequence[Print]) -> TableArea:
    """Return the area table of measured prints, given in any order.

    >>> float(area_of_prints(UNVERIFIED_PRINTS).area_m2(1.5) * 1e4).__round__(4)
    1.2095
    """
    ordered = sorted(prints, key=lambda one: one.force_n)
    return TableArea(tuple(one.force_n for one in ordered), tuple(one.area_m2 for one in ordered))


@checked
def power_law_of_prints(prints: Sequence[Print]) -> PowerLawArea:
    """Fit a power law to the logarithms of area and force.

    >>> law = power_law_of_prints([Print(1.0, 0.01, 0.01), Print(8.0, 0.02, 0.01)])
    >>> round(law.exponent, 12)
    0.333333333333
    """
    n_forces = len({one.force_n for one in prints})
    require.expect(n_forces >= 2, "power_law_of_prints", f"{len(prints)} prints", "prints at two or more forces")
    x, y = np.log([one.force_n for one in prints]), np.log([one.area_m2 for one in prints])
    exponent, constant = np.polyfit(x, y, 1)
    return PowerLawArea(float(np.exp(constant)), float(exponent))


@checked
def ellipse_area_m2(length_m: NotNegativeArray, width_m: NotNegativeArray) -> FloatArray:
    """Return an ellipse's area, ``pi/4`` times the product of its full axes.

    >>> float(ellipse_area_m2(0.02, 0.01).round(9))
    0.00015708
    """
    return np.asarray(pi / 4 * np.asarray(length_m, dtype=np.float64) * np.asarray(width_m, dtype=np.float64))
