"""Detection by the receptor channel furthest above its threshold."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...composition.content import VoltageContent
from ...composition.effect import Effect, Stage, Surroundings, note
from ...defaults import STEEPEST_DB_PER_HZ, THRESHOLD_M
from ..stages.circuit import HIGHEST

if TYPE_CHECKING:
    from ...arrays import FloatArray
    from ...perception.detection import Components


@dataclass(frozen=True)
class Receptors(Effect):
    """Levels of the channels NP III, NP I and P above their thresholds.

    0.1 um and the thresholds of the channels are unverified defaults.

    Parameters
    ----------
    reference_m : float
        Displacement of the skin at the threshold at 250 Hz, which scales the channels.
    """

    kind = "receptors"
    positive = ("reference_m",)
    requires = ("friction",)
    reads, gives = ("skin_components",), "channels_db"
    cures = note("add the effects friction and receptors", "channels_db")
    assumes = ("no temporal summation",)
    rests_on = "the displacement of the skin at threshold (by default 0.1 um at 250 Hz, published: 0.01 to 1 um)"

    reference_m: float = THRESHOLD_M

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        strongest = Stage("strongest", ("channels_db",), "sensation_db", HIGHEST)
        return self.stage(), strongest

    def __call__(self, skin_components: "Components") -> "FloatArray":
        """Return the level (3,) of each channel."""
        from ...perception.channels import channel_levels_db

        return channel_levels_db(skin_components, self.reference_m)

    def in_voltage(self, scene: Surroundings) -> VoltageContent:
        return VoltageContent(steepest_db_per_hz=STEEPEST_DB_PER_HZ)
