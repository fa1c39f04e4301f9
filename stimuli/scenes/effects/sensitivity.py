"""Sensation by the component furthest above the spectral threshold of touch."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from tactometry.arguments import require

from ...composition.effect import Demand, Effect, Size, Stage, Surroundings

if TYPE_CHECKING:
    from ...perception.detection import Components


@dataclass(frozen=True)
class Sensitivity(Effect):
    """Threshold by frequency, `reference_force_n` the amplitude of friction at threshold, at 250 Hz.

    6.7 uN is an unverified default, as in `ElectrovibrationSensation`.

    >>> Sensitivity().slot
    'sensitivity'
    """

    kind = "sensitivity"
    slot = "sensitivity"
    requires = ("friction",)
    excludes: ClassVar[Mapping[str, str]] = {
        "receptors": "both are thresholds by frequency; remove 'sensitivity' or 'receptors'"
    }
    assumes = ("the threshold is one of force, without the mobility of the skin; nothing sums over time",)

    reference_force_n: float = 6.7e-6

    def __post_init__(self) -> None:
        require.positive("Sensitivity", reference_force_n=self.reference_force_n)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        del scene
        needs, target = ("t_s", "friction_force_n"), "tactometry.stimuli.scenes.stages.spectrum:components_of"
        spectrum = Stage("spectrum", needs, "components", target, size=fine_spectrum)
        settings = {"reference_force_n": self.reference_force_n}
        level = Stage("sensitivity", ("components",), "sensation_db", f"{__name__}:level", settings)
        return spectrum, level


def fine_spectrum(demand: Demand) -> Size:
    """Components as finely as the threshold asks for."""
    from ..stages.spectrum import size

    return size(demand)


def level(reference_force_n: float) -> "Callable[[Components], float]":
    """Level above threshold."""
    from ...perception.detection import sensation_level_db

    return lambda components: sensation_level_db(components, reference_force_n)
