"""An asymmetry of the skin between positive and negative voltages."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from tactometry.arguments import require

from ...composition.effect import Effect, Stage, Surroundings

if TYPE_CHECKING:
    from ...arrays import FloatArray


NO_FLOW = "the exact motion has no term for it; remove 'polarity' or the other"


@dataclass(frozen=True)
class Polarity(Effect):
    """The force counts `positive_share` times while the voltage across the layer is positive; no default is known.

    >>> Polarity(0.5).positive_share
    0.5
    """

    kind = "polarity"
    slot = "polarity"
    excludes: ClassVar[Mapping[str, str]] = {"friction_lag": NO_FLOW, "finger_dynamics": NO_FLOW}

    positive_share: float

    def __post_init__(self) -> None:
        require.not_negative("Polarity", positive_share=self.positive_share)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        del scene
        needs = ("electrostatic_force_n", "layer_voltage_v")
        settings = {"positive_share": self.positive_share}
        return (Stage("polarity", needs, "electrostatic_force_n", f"{__name__}:weighted", settings),)


def weighted(positive_share: float) -> "Callable[[FloatArray, FloatArray], FloatArray]":
    """Forces weighted by the sign of the layer's voltage."""
    from ...electrovibration.attraction import polarity

    return polarity.Polarity(positive_share).weighted
