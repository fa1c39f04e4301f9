"""Shear and rotary inertia: Mindlin's plate instead of the thin plate."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...composition.effect import Alteration

if TYPE_CHECKING:
    from ...time_reversal.plate.plate import Plate


@dataclass(frozen=True)
class Shear(Alteration):
    """Mindlin's plate with a shear factor; exact for simply supported edges.

    Parameters
    ----------
    shear_factor : float
        Shear correction factor of the plate's cross-section.
    """

    kind = "shear"
    in_signal = True
    positive = ("shear_factor",)
    reads, gives = ("screen",), "screen"

    shear_factor: float = 5 / 6

    def in_setup(self) -> dict[str, float]:
        return {"shear_factor": self.shear_factor}

    def wavenumber_rad_per_m(self, plate: "Plate", frequency_hz: float) -> float:
        """Return the wavenumber of bending waves."""
        from ...time_reversal.plate.dispersion import mindlin_wavenumber_rad_per_m

        return float(mindlin_wavenumber_rad_per_m(plate, frequency_hz, self.shear_factor))
