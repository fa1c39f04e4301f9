"""An electrode of strips, which covers a part of the contact alone."""

from dataclasses import dataclass

from ...composition.effect import Effect


@dataclass(frozen=True)
class Strips(Effect):
    """Strips that cover `share` of the contact, above 0."""

    kind = "strips"
    slot = "strips"
    positive = ("share",)
    reads, gives = ("area_m2",), "area_m2"
    assumes = ("strips are much narrower than the contact",)

    share: float = 0.5

    def __call__(self, area_m2: float) -> float:
        return self.share * area_m2
