"""Surfaces of scenes by name, and their common parts."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from ...composition.effect import Demand, Effect, Size, Stage, Surface, note

SURFACES: Mapping[str, str] = {
    "electrovibration": "tactometry.stimuli.scenes.surfaces.electrovibration:Electrovibration",
    "time_reversal": "tactometry.stimuli.scenes.surfaces.time_reversal:TimeReversal",
    "hybrid": "tactometry.stimuli.scenes.surfaces.hybrid:HybridScreen",
}

REFUSES: Mapping[str, str] = note(
    "'focus_detection': no source states the spectrum of a focus in the skin, so that a focus is felt as one event, "
    "and a train by the Pacinian channel alone",
    "receptors",
    "sensitivity",
    "summation",
)
"""Thresholds over frequency, which do not apply to foci."""


@dataclass(frozen=True)
class Side:
    """One side of a hybrid surface: its demand and the prefix of its names."""

    surface: Surface
    demand: Callable[[Demand], Demand]
    stage_name: Callable[[str], str] = str
    quantity_name: Callable[[str], str] = str

    def place(self, stages: tuple[Stage, ...]) -> tuple[Stage, ...]:
        """Rename stages and size them by the demand of this side."""
        return tuple(
            replace(
                stage,
                name=self.stage_name(stage.name),
                needs=tuple(map(self.quantity_name, stage.needs)),
                gives=self.quantity_name(stage.gives),
                size=stage.size and self._sized(stage.size),
            )
            for stage in stages
        )

    def _sized(self, size: Callable[[Demand], Size]) -> Callable[[Demand], Size]:
        return lambda demand: size(demand.once(self.demand))


class TwoSided(Surface):
    """A surface with two sides: an effect acts on each side that supports it, or on both together."""

    def sides(self) -> tuple[Side, ...]:
        """Return the side of the foci and the side of the friction."""
        raise NotImplementedError

    def stages(self, scene: Demand) -> tuple[Stage, ...]:
        return tuple(stage for side in self.sides() for stage in side.place(side.surface.stages(side.demand(scene))))

    def stages_of(self, effect: Effect, scene: Demand) -> tuple[Stage, ...]:
        knowing = [side for side in self.sides() if effect.kind in side.surface.effects]
        placed = (side.place(side.surface.stages_of(effect, side.demand(scene))) for side in knowing)
        return tuple(stage for stages in placed for stage in stages) or super().stages_of(effect, scene)
