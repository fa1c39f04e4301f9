"""Shear and rotary inertia: Mindlin's plate in place of the thin one."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ...composition.effect import Effect

if TYPE_CHECKING:
    from ...time_reversal.plate.plate import Plate
    from ...time_reversal.screen.screen import Screen


@dataclass(frozen=True)
class Shear(Effect):
    """Mindlin's plate with a shear factor; exact for simply supported edges.

    >>> Shear().factor
    0.8333333333333334
    """

    kind = "shear"
    slot = "shear"
    in_signal = True
    positive = ("factor",)
    reads, gives = ("screen",), "screen"

    factor: float = 5 / 6

    def __call__(self, screen: "Screen") -> "Screen":
        return replace(screen, shear_factor=self.factor)

    def in_setup(self) -> dict[str, float]:
        return {"shear_factor": self.factor}

    def wavenumber_rad_per_m(self, plate: "Plate", frequency_hz: float) -> float:
        """Of the waves at a frequency."""
        from ...time_reversal.plate.dispersion import mindlin_wavenumber_rad_per_m

        return float(mindlin_wavenumber_rad_per_m(plate, frequency_hz, self.factor))
