"""The audible-band filter: what is learnt keeps what lies above it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tactometry.arguments import require
from tactometry.errors import InvalidParameter

from ...composition.effect import Effect, Stage, Surroundings

if TYPE_CHECKING:
    from ...time_reversal.responses.responses import Responses


@dataclass(frozen=True)
class AudibleFilter(Effect):
    """Responses above `cutoff_hz` only, before they are reversed and quantised; both defaults are unverified.

    >>> AudibleFilter().cutoff_hz
    20000.0
    """

    kind = "audible_filter"
    slot = "filter"

    cutoff_hz: float = 20e3
    flank_hz: float = 2e3

    def __post_init__(self) -> None:
        require.positive("AudibleFilter", cutoff_hz=self.cutoff_hz, flank_hz=self.flank_hz)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        del scene
        settings = {"cutoff_hz": self.cutoff_hz, "flank_hz": self.flank_hz}
        return (Stage("audible_filter", ("learnt",), "learnt", f"{__name__}:silenced", settings),)

    def weakening(self, scene: Surroundings) -> float:
        """Less of the band adds up."""
        self._check_flanks(scene.surface)
        band_max_hz: float = scene.surface.band_max_hz  # type: ignore[attr-defined]
        return band_max_hz / (band_max_hz - self.cutoff_hz)

    def _check_flanks(self, surface: Any) -> None:
        if self.cutoff_hz + self.flank_hz >= surface.band_max_hz - surface.flank_hz:
            raise InvalidParameter(
                f"audible_filter: found a flank that ends at {self.cutoff_hz + self.flank_hz} Hz, expected it below "
                f"that of the band, {surface.band_max_hz - surface.flank_hz} Hz; lower cutoff_hz or raise band_max_hz"
            )


def silenced(cutoff_hz: float, flank_hz: float) -> "Callable[[Responses], Responses]":
    """Responses without their audible part."""
    from ...time_reversal.responses.responses import inaudible

    return lambda learnt: inaudible(learnt, cutoff_hz, flank_hz)
