"""Sensation level by the threshold of touch over frequency."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...composition.content import VoltageContent
from ...composition.effect import Effect, Surroundings, note
from ...defaults import STEEPEST_DB_PER_HZ, THRESHOLD_M

if TYPE_CHECKING:
    from ...perception.detection import Components


@dataclass(frozen=True)
class Sensitivity(Effect):
    """Sensation level above the threshold over frequency.

    The threshold is the lowest of those of the channels. `stimuli/sources.toml` states the source of each number.

    Parameters
    ----------
    reference_m : float
        Displacement of the skin at the threshold at 250 Hz, which scales the other frequencies.
    """

    kind = "sensitivity"
    positive = ("reference_m",)
    requires = ("friction",)
    reads, gives = ("skin_components",), "sensation_db"
    cures = note("add the effects friction and sensitivity, or receptors", "sensation_db")
    excludes = note("both set the threshold over frequency; remove 'sensitivity' or 'receptors'", "receptors")
    assumes = ("no temporal or spatial summation",)
    rests_on = "the displacement of the skin at threshold (by default 0.1 um at 250 Hz, published: 0.01 to 1 um)"

    reference_m: float = THRESHOLD_M

    def __call__(self, skin_components: "Components") -> float:
        from ...perception.channels import sensation_level_db

        return sensation_level_db(skin_components, self.reference_m)

    def in_voltage(self, scene: Surroundings) -> VoltageContent:
        return VoltageContent(steepest_db_per_hz=STEEPEST_DB_PER_HZ)
