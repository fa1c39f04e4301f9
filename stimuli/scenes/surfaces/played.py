"""What all surfaces under a signal that is played have in common."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Self

from ...composition.effect import Demand, Effect, Stage, Surface, Surroundings


class PlayedSurface(Surface):
    """A surface that each run is given a signal and a contact for, of which the level is felt."""

    given = ("signal", "contact")

    def stages_of(self, effect: Effect, scene: Demand) -> tuple[Stage, ...]:
        """As what is felt needs them."""
        return tuple(replace(stage, effect=effect.kind) for stage in effect.felt_stages(scene))

    def excluded(self, effect: Effect | type[Effect]) -> Mapping[str, str]:
        """As what is felt excludes them."""
        return effect.excludes if effect.felt_excludes is None else effect.felt_excludes

    def played(self, scene: Surroundings) -> Self:
        """It is played already."""
        return self
