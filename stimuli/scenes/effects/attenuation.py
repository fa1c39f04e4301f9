"""Losses: every mode decays."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from tactometry.arguments import require

from ...composition.content import PlateContent
from ...composition.effect import Effect, Stage, Surroundings

if TYPE_CHECKING:
    from ...time_reversal.screen.screen import Screen


@dataclass(frozen=True)
class Attenuation(Effect):
    """``tau(f) = tau (f/reference)^-exponent``: constant with exponent 0; 3.5 ms is an unverified default.

    >>> Attenuation(exponent=0.5).tau_at_s(40e3)
    0.00175
    """

    kind = "attenuation"
    slot = "attenuation"

    tau_s: float = 3.5e-3
    exponent: float = 0.0
    reference_hz: float = 10e3

    def __post_init__(self) -> None:
        require.positive("Attenuation", tau_s=self.tau_s, reference_hz=self.reference_hz)
        require.not_negative("Attenuation", exponent=self.exponent)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        del scene
        settings = {"tau_s": self.tau_s, "exponent": self.exponent, "reference_hz": self.reference_hz}
        return (Stage("attenuation", ("screen",), "screen", f"{__name__}:damped", settings),)

    def in_plate(self, scene: Surroundings) -> PlateContent:
        return PlateContent(tau_s=self.tau_at_s(scene.surface.band_max_hz), ringing_s=3 * self.tau_s)

    def tau_at_s(self, frequency_hz: float) -> float:
        """The time constant at a frequency."""
        return float(self.tau_s * (frequency_hz / self.reference_hz) ** -self.exponent)


def damped(tau_s: float, exponent: float, reference_hz: float) -> "Callable[[Screen], Screen]":
    """The screen with losses."""
    from ...time_reversal.screen.attenuation import Attenuation as Law

    law = Law(tau_s, exponent, reference_hz)
    return lambda screen: replace(screen, attenuation=law)
