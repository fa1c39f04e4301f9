"""Mutual masking of foci and friction at one finger: each raises the threshold of the other."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from tactometry.arguments import require

from ...composition.effect import Effect, Stage, Surroundings
from ...defaults import MASKING_SLOPE

if TYPE_CHECKING:
    from ...arrays import FloatArray

TARGETS: Final = ("foci", "friction")


@dataclass(frozen=True)
class CrossMasking(Effect):
    """Masking of the `target` (foci or friction) by the other stimulus.

    The threshold of the target rises by `slope` times the level of the other stimulus above its own threshold. This is
    an unverified default: no source states it for a focus and friction. 0.52 is the slope of `Masking`: 13 dB by a
    masker of the same frequency at 25 dB.

    Raises `InvalidParameter` for any other target.

    Parameters
    ----------
    target : {"foci", "friction"}
        Stimulus that is felt: foci or friction. The other one masks it.
    slope : float
        Rise of the threshold per dB of the masker above its own threshold, above 0.
    """

    kind = "cross_masking"
    positive = ("slope",)
    assumes = ("foci and friction mask each other like vibrations of the same frequency",)

    target: str
    slope: float = MASKING_SLOPE

    def __post_init__(self) -> None:
        require.one_of("CrossMasking.target", self.target, TARGETS)
        super().__post_init__()

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        """Return the stages for a resting and a sliding finger."""
        levels = "sensation_db", "sliding_sensation_db"
        return (self._stage(levels, levels[TARGETS.index(self.target)]),)

    def felt_stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        """Return the stages for one finger that feels both."""
        return (self._stage(("resting_sensation_db", "sliding_sensation_db"), "sensation_db"),)

    def _stage(self, levels: tuple[str, str], gives: str) -> Stage:
        needs = levels if self.target == "foci" else levels[::-1]
        return Stage(self.kind, needs, gives, f"{__name__}:masked", {"slope": self.slope})


def masked(target_db: "float | FloatArray", masker_db: "float | FloatArray", slope: float) -> "float | FloatArray":
    """Return the level above the threshold that a perceptible masker raises."""
    import numpy as np

    return target_db - slope * max(float(np.max(masker_db)), 0.0)
