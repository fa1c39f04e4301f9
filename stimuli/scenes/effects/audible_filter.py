"""Audible-band filter: learnt responses keep only higher frequencies."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from tactometry.errors import InvalidParameter

from ...composition.content import PlateContent
from ...composition.effect import Effect, Surroundings
from ...defaults import AUDIBLE_MAX_HZ

if TYPE_CHECKING:
    from ...time_reversal.responses.responses import Responses


@dataclass(frozen=True)
class AudibleFilter(Effect):
    """Filter that removes frequencies below `cutoff_hz` before reversal and quantisation; both defaults are unverified.

    Parameters
    ----------
    cutoff_hz : float
        Frequency below which nothing is emitted.
    flank_hz : float
        Width of the filter's flank.
    """

    kind = "audible_filter"
    slot = "filter"
    in_signal = True
    positive = ("cutoff_hz", "flank_hz")
    reads, gives = ("learnt",), "learnt"

    cutoff_hz: float = AUDIBLE_MAX_HZ
    flank_hz: float = 2e3

    def __call__(self, learnt: "Responses") -> "Responses":
        from ...time_reversal.responses.responses import inaudible

        return inaudible(learnt, self.cutoff_hz, self.flank_hz)

    def in_plate(self, scene: Surroundings) -> PlateContent:
        """Return the weakening by the part of the band that is removed."""
        surface = scene.surface
        if self.cutoff_hz + self.flank_hz >= surface.f_max_hz - surface.flank_hz:
            raise InvalidParameter(
                f"audible_filter: found a flank up to {self.cutoff_hz + self.flank_hz} Hz, expected it below the "
                f"band's flank at {surface.f_max_hz - surface.flank_hz} Hz; lower cutoff_hz or raise f_max_hz"
            )
        return PlateContent(weakening=surface.f_max_hz / (surface.f_max_hz - self.cutoff_hz))
