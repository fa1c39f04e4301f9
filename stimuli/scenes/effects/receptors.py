"""Receptor channels in place of one threshold: the channel furthest above its own mediates detection."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tactometry.arguments import require

from ...composition.effect import Demand, Effect, Size, Stage, Surroundings

if TYPE_CHECKING:
    from ...arrays import FloatArray
    from ...perception.detection import Components

STEEPEST_DB_PER_HZ = 2.5
"""Of the thresholds of `tactometry.stimuli.perception.channels`, at 3 Hz: an upper bound."""


@dataclass(frozen=True)
class Receptors(Effect):
    """The channels NP III, NP I and P, `reference_force_n` the amplitude of friction at threshold, at 250 Hz.

    6.7 uN and the thresholds of the channels are unverified defaults.

    >>> Receptors().slot
    'receptors'
    """

    kind = "receptors"
    slot = "receptors"
    requires = ("friction",)
    assumes = ("thresholds are those of force, without the mobility of the skin; nothing sums over time",)

    reference_force_n: float = 6.7e-6

    def __post_init__(self) -> None:
        require.positive("Receptors", reference_force_n=self.reference_force_n)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        del scene
        settings = {"reference_force_n": self.reference_force_n}
        needs, target = ("t_s", "friction_force_n"), "tactometry.stimuli.scenes.stages.spectrum:components_of"
        return (
            Stage("spectrum", needs, "components", target, size=fine_spectrum),
            Stage("receptors", ("components",), "channels_db", f"{__name__}:levels", settings),
            Stage("strongest", ("channels_db",), "sensation_db", f"{__name__}:strongest"),
        )


def fine_spectrum(demand: Demand) -> Size:
    """Components as finely as the steepest channel asks for."""
    from ..stages.spectrum import size

    return size(demand, STEEPEST_DB_PER_HZ)


def levels(reference_force_n: float) -> "Callable[[Components], FloatArray]":
    """(3,): the level of each channel."""
    from ...perception.channels import channel_levels_db

    return lambda components: channel_levels_db(components, reference_force_n)


def strongest() -> "Callable[[FloatArray], float]":
    """The highest level."""
    return lambda channels_db: float(channels_db.max())
