"""A masker raises the threshold."""

from dataclasses import dataclass

from ...composition.effect import Effect, Stage, Surroundings
from ...defaults import MASKING_SLOPE


@dataclass(frozen=True)
class Masking(Effect):
    """A masker of the same frequency at a level above its own threshold.

    The threshold rises by `slope` times that level. 0.52, from 13 dB at 25 dB (Sci. Rep. 2018, doi
    10.1038/s41598-018-22865-x), is an unverified default. So is its use for foci, masked by a vibration in the channel
    that feels them.

    Parameters
    ----------
    level_db_re_threshold : float
        Level of the masker above its own threshold, above 0.
    slope : float
        Rise of the threshold per dB of that level.
    """

    kind = "masking"
    assumes = ("the same channel feels masker and signal, as if both had the same frequency",)
    positive = ("level_db_re_threshold", "slope")

    level_db_re_threshold: float
    slope: float = MASKING_SLOPE

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        settings = {"elevation_db": self.slope * self.level_db_re_threshold}
        return (Stage("masking", ("sensation_db",), "sensation_db", f"{__name__}:mask", settings),)


def mask(sensation_db: float, elevation_db: float) -> float:
    return sensation_db - elevation_db
