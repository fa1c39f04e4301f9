"""Losses: every mode decays."""

from dataclasses import dataclass, replace
from math import log10
from typing import TYPE_CHECKING, Final

from tactometry.arguments import require

from ...composition.content import PlateContent
from ...composition.effect import Effect, Surroundings

if TYPE_CHECKING:
    from ...time_reversal.screen.screen import Screen

MOST_DECADES: Final = 12.0
"""By which a time constant may change up to the end of the band: no glass comes near."""


@dataclass(frozen=True)
class Losses(Effect):
    """``tau(f) = tau (f/reference)^-exponent``: constant with exponent 0; 3.5 ms is an unverified default.

    >>> Losses(exponent=0.5).tau_at_s(40e3)
    0.00175
    """

    kind = "attenuation"
    slot = "attenuation"
    in_signal = True
    reads, gives = ("screen",), "screen"

    tau_s: float = 3.5e-3
    exponent: float = 0.0
    reference_hz: float = 10e3

    def __post_init__(self) -> None:
        require.positive("Attenuation", tau_s=self.tau_s, reference_hz=self.reference_hz)
        require.not_negative("Attenuation", exponent=self.exponent)

    def __call__(self, screen: "Screen") -> "Screen":
        from ...time_reversal.screen.attenuation import Attenuation

        return replace(screen, attenuation=Attenuation(**vars(self)))

    def in_plate(self, scene: Surroundings) -> PlateContent:
        band_max_hz: float = scene.surface.band_max_hz
        decades = abs(self.exponent * log10(band_max_hz / self.reference_hz))
        found = f"{self.exponent:g}, by which tau changes {decades:.3g} decades up to band_max_hz"
        require.expect(decades <= MOST_DECADES, "attenuation.exponent", found, f"at most {MOST_DECADES:g}; lower it")
        return PlateContent(tau_s=self.tau_at_s(band_max_hz), ringing_s=3 * self.tau_s)

    def in_setup(self) -> dict[str, float]:
        found = f"{self.exponent:g} where a signal is felt"
        require.expect(self.exponent == 0, "attenuation.exponent", found, "0: the plate of a stimulus has one tau_s")
        return {"tau_s": self.tau_s}

    def tau_at_s(self, frequency_hz: float) -> float:
        """The time constant at a frequency."""
        return float(self.tau_s * (frequency_hz / self.reference_hz) ** -self.exponent)
