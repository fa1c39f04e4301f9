"""Sensation by the component furthest above the spectral threshold of touch."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...composition.content import VoltageContent
from ...composition.effect import Effect, Surroundings, note

if TYPE_CHECKING:
    from ...perception.detection import Components

STEEPEST_DB_PER_HZ = 0.69
"""Of `tactometry.stimuli.perception.sensitivity_db`, at 0 Hz: an upper bound."""


@dataclass(frozen=True)
class Sensitivity(Effect):
    """Threshold by frequency, `reference_force_n` the amplitude of friction at threshold, at 250 Hz.

    6.7 uN is an unverified default, as in `ElectrovibrationSensation`.

    >>> Sensitivity().slot
    'sensitivity'
    """

    kind = "sensitivity"
    slot = "sensitivity"
    positive = ("reference_force_n",)
    requires = ("friction",)
    reads, gives = ("components",), "sensation_db"
    cures = note("add the effects friction and sensitivity, or receptors", "sensation_db")
    excludes = note("both are thresholds by frequency; remove 'sensitivity' or 'receptors'", "receptors")
    assumes = ("the threshold is one of force, without the mobility of the skin; nothing sums over time",)

    reference_force_n: float = 6.7e-6

    def __call__(self, components: "Components") -> float:
        """Level above threshold."""
        from ...perception.detection import sensation_level_db

        return sensation_level_db(components, self.reference_force_n)

    def in_voltage(self, scene: Surroundings) -> VoltageContent:
        return VoltageContent(steepest_db_per_hz=STEEPEST_DB_PER_HZ)
