"""Foci and friction that are played at once: the level is that of the stronger one."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import ClassVar

from ...composition.effect import Demand, Effect, Size, Stage
from ..effects import OF_HYBRID
from .played import PlayedSurface
from .played_electrovibration import PlayedElectrovibration
from .played_time_reversal import PlayedTimeReversal

BOTH = "tactometry.stimuli.scenes.stages.both"
RESTING, SLIDING = "resting", "sliding"
OF_BOTH = ("contact", "contact_force_n")
"""The finger is one, and foci alone move it."""


@dataclass(frozen=True)
class PlayedHybrid(PlayedSurface):
    """A plate with an electrode on it, whose last channel is that of the electrode.

    Neither masks the other (an unverified simplification, which the effect `cross_masking` does without): foci are felt
    as if the finger rested at the focus, friction while it slides.

    >>> PlayedHybrid().given
    ('signal', 'contact')
    """

    kind = "hybrid"
    effects: ClassVar[Mapping[str, str]] = OF_HYBRID
    assumes: ClassVar[Mapping[str, str]] = {
        **PlayedTimeReversal.assumes,
        **PlayedElectrovibration.assumes,
        "cross_masking": "neither foci nor friction mask the other",
        "hybrid": "foci are felt as by a finger that rests",
    }
    touches = (*PlayedTimeReversal.touches, *PlayedElectrovibration.touches)

    electrovibration: PlayedElectrovibration = field(default_factory=PlayedElectrovibration)
    time_reversal: PlayedTimeReversal = field(default_factory=PlayedTimeReversal)

    def stages(self, scene: Demand) -> tuple[Stage, ...]:
        parts = (Stage(f"{side}_part", ("signal",), f"{side}_signal", f"{BOTH}:{side}") for side in (RESTING, SLIDING))
        levels = (f"{RESTING}_sensation_db", f"{SLIDING}_sensation_db")
        return (
            *parts,
            *_on_side(RESTING, self.time_reversal.stages(self._resting(scene)), self._resting),
            *_on_side(SLIDING, self.electrovibration.stages(self._sliding(scene)), self._sliding),
            Stage("stronger", levels, "sensation_db", f"{BOTH}:stronger"),
        )

    def stages_of(self, effect: Effect, scene: Demand) -> tuple[Stage, ...]:
        """The stages of an effect, on each side where it acts, or across both."""
        sides = ((RESTING, self.time_reversal, self._resting), (SLIDING, self.electrovibration, self._sliding))
        of_sides = [
            stage
            for side, surface, demand in sides
            if effect.kind in surface.effects
            for stage in _on_side(side, surface.stages_of(effect, demand(scene)), demand)
        ]
        return tuple(of_sides) or super().stages_of(effect, scene)

    def cure(self, quantity: str) -> str:
        """As on the side that has the quantity."""
        return super().cure(quantity.removeprefix(f"{RESTING}_").removeprefix(f"{SLIDING}_"))

    def _resting(self, scene: Demand) -> Demand:
        return replace(scene, surface=self.time_reversal, contacts=self.time_reversal.touches)

    def _sliding(self, scene: Demand) -> Demand:
        return replace(scene, surface=self.electrovibration, contacts=self.electrovibration.touches)


def _on_side(side: str, stages: tuple[Stage, ...], demand: Callable[[Demand], Demand]) -> tuple[Stage, ...]:
    """Stages whose names are their side's own, sized by what that side asks for; both have one contact."""

    def name(quantity: str) -> str:
        return quantity if quantity in OF_BOTH else f"{side}_{quantity}"

    def size(own: Callable[[Demand], Size]) -> Callable[[Demand], Size]:
        return lambda asked: own(asked.once(demand))

    return tuple(
        replace(
            stage,
            name=name(stage.name),
            needs=tuple(map(name, stage.needs)),
            gives=name(stage.gives),
            size=stage.size and size(stage.size),
        )
        for stage in stages
    )
