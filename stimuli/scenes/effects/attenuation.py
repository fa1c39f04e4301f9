"""Losses: every mode decays."""

from dataclasses import dataclass, replace

from tactometry.arguments import require

from ...composition.content import PlateContent
from ...composition.effect import Effect, Surroundings
from ...time_reversal.screen.attenuation import Attenuation
from ...time_reversal.screen.screen import TAU_S, Screen


@dataclass(frozen=True)
class Losses(Attenuation, Effect):
    """The attenuation of a screen; 3.5 ms is an unverified default.

    >>> round(1 / float(Losses(exponent=0.5).rate_per_s(40e3)), 9)
    0.00175
    """

    kind = "attenuation"
    slot = "attenuation"
    reads, gives = ("screen",), "screen"

    tau_s: float = TAU_S

    def __post_init__(self) -> None:
        require.positive("Attenuation", tau_s=self.tau_s)  # no loss at all is a screen without this effect
        super().__post_init__()

    def __call__(self, screen: Screen) -> Screen:
        return replace(screen, attenuation=self)

    def in_plate(self, scene: Surroundings) -> PlateContent:
        at_top_s = 1 / float(self.rate_per_s(scene.surface.band_max_hz))
        return PlateContent(tau_s=at_top_s, ringing_s=3 * self.tau_s)
