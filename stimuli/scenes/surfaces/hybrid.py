"""A plate that focuses with an electrode on it: both sides at once, designed or played."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import ClassVar

from tactometry.errors import InvalidParameter

from ...composition.effect import PLAYED, Demand, Effect, FingerContact, Size, Stage, Surface, Surroundings
from ..effects import OF_HYBRID
from .electrovibration import Electrovibration, PlayedElectrovibration
from .played_plates import PlayedTimeReversal
from .time_reversal import TimeReversal

BOTH = "tactometry.stimuli.scenes.stages.record"
RESTING, SLIDING = "resting_", "sliding_"
"""Prefixes of stages and quantities of one side."""
RENAMED = ("t_s", "motion", "sensation_db")
"""Quantities that both sides of a designed screen have."""
COMMON = ("contact", "contact_force_n")
"""Quantities of the one finger on a surface that is played; only foci move it."""


@dataclass(frozen=True)
class Side:
    """One side of a hybrid surface: its demand, and the names of its stages and quantities."""

    surface: Surface
    demand: Callable[[Demand], Demand]
    stage_name: Callable[[str], str] = str
    quantity: Callable[[str], str] = str

    def place(self, stages: tuple[Stage, ...]) -> tuple[Stage, ...]:
        """Rename stages, and size each by the demand of this side."""
        return tuple(
            replace(
                stage,
                name=self.stage_name(stage.name),
                needs=tuple(map(self.quantity, stage.needs)),
                gives=self.quantity(stage.gives),
                size=stage.size and self._sized(stage.size),
            )
            for stage in stages
        )

    def _sized(self, size: Callable[[Demand], Size]) -> Callable[[Demand], Size]:
        return lambda demand: size(demand.once(self.demand))


class TwoSided(Surface):
    """A surface on which an effect acts on each side that knows it, or across both."""

    def sides(self) -> tuple[Side, ...]:
        """Return the side of the foci and that of friction."""
        raise NotImplementedError

    def stages(self, scene: Demand) -> tuple[Stage, ...]:
        return tuple(stage for side in self.sides() for stage in side.place(side.surface.stages(side.demand(scene))))

    def stages_of(self, effect: Effect, scene: Demand) -> tuple[Stage, ...]:
        knowing = [side for side in self.sides() if effect.kind in side.surface.effects]
        placed = (side.place(side.surface.stages_of(effect, side.demand(scene))) for side in knowing)
        return tuple(stage for stages in placed for stage in stages) or super().stages_of(effect, scene)


@dataclass(frozen=True)
class HybridScreen(TwoSided):
    """A plate that focuses, with an electrode on it.

    Fingers at rest feel the focus, the first finger that slides feels friction. For the plate all fingers are loads at
    their places, those at rest first: while a focus lasts, a finger slides less than a tenth of a wavelength. The
    model leaves out that the attraction bends the plate and that the focus changes friction.

    Parameters
    ----------
    electrovibration : Electrovibration
        The electrode.
    time_reversal : TimeReversal
        The plate.

    >>> from tactometry.stimuli.scenes.surfaces.electrovibration import Electrovibration
    >>> HybridScreen(Electrovibration(frequency_hz=240.0)).given
    ('voltage_v', 'level_db_re_1v')
    """

    kind = "hybrid"
    effects: ClassVar[Mapping[str, str]] = OF_HYBRID
    given = (*TimeReversal.given, *Electrovibration.given)
    assumes: ClassVar[Mapping[str, str]] = {
        **TimeReversal.assumes,
        **Electrovibration.assumes,
        "hybrid": "the attraction does not bend the plate, and its vibration does not lubricate the finger that slides",
    }

    electrovibration: Electrovibration
    time_reversal: TimeReversal = field(default_factory=TimeReversal)

    def sides(self) -> tuple[Side, ...]:
        plate = Side(self.time_reversal, self._resting)
        return plate, Side(self.electrovibration, self._sliding, lambda name: f"{SLIDING}{name}", _on_electrode)

    def played(self, scene: Surroundings) -> "PlayedHybrid":
        """Return both sides as they are played."""
        return PlayedHybrid(self.electrovibration.played(), self.time_reversal.played(scene))

    def cure(self, quantity: str) -> str:
        of_panel = quantity.removeprefix(SLIDING)
        return super().cure(quantity) if of_panel == quantity else self.electrovibration.cure(of_panel)

    def _sliding(self, scene: Demand) -> Demand:
        sliding = tuple(touch for touch in scene.contacts if touch.slides)
        return replace(scene, surface=self.electrovibration, contacts=sliding)

    def _resting(self, scene: Demand) -> Demand:
        _check_places(scene.contacts)
        touches = sorted(scene.contacts, key=lambda touch: touch.slides)
        contacts = tuple(replace(touch, speed_m_per_s=0.0) for touch in touches)
        return replace(scene, surface=self.time_reversal, contacts=contacts)


@dataclass(frozen=True)
class PlayedHybrid(TwoSided):
    """A plate with an electrode on it, whose last channel is that of the electrode.

    Foci are felt as if the finger rested at the focus, friction while it slides, and the level is that of the stronger
    one. Neither masks the other (an unverified simplification, which the effect `cross_masking` removes).

    >>> PlayedHybrid().given
    ('signal', 'contact')
    """

    kind = "hybrid"
    is_played, given = True, PLAYED
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

    def sides(self) -> tuple[Side, ...]:
        foci, friction = partial(_of_side, RESTING), partial(_of_side, SLIDING)
        return (
            Side(self.time_reversal, self._resting, foci, foci),
            Side(self.electrovibration, self._sliding, friction, friction),
        )

    def stages(self, scene: Demand) -> tuple[Stage, ...]:
        levels = (f"{RESTING}sensation_db", f"{SLIDING}sensation_db")
        return (
            Stage("resting_part", ("signal",), "resting_signal", f"{BOTH}:resting"),
            Stage("sliding_part", ("signal",), "sliding_signal", f"{BOTH}:sliding"),
            *super().stages(scene),
            Stage("stronger", levels, "sensation_db", f"{BOTH}:stronger"),
        )

    def cure(self, quantity: str) -> str:
        return super().cure(quantity.removeprefix(RESTING).removeprefix(SLIDING))

    def _resting(self, scene: Demand) -> Demand:
        return replace(scene, surface=self.time_reversal, contacts=self.time_reversal.touches)

    def _sliding(self, scene: Demand) -> Demand:
        return replace(scene, surface=self.electrovibration, contacts=self.electrovibration.touches)


def _of_side(prefix: str, name: str) -> str:
    return name if name in COMMON else f"{prefix}{name}"


def _check_places(contacts: tuple[FingerContact, ...]) -> None:
    for n, touch in enumerate(contacts):
        if touch.slides and (touch.x_m is None or touch.y_m is None):
            raise InvalidParameter(
                f"contacts[{n}]: found a finger that slides without a place, expected one, for on a hybrid plate it is "
                "a load there; add x_m and y_m"
            )


def _on_electrode(quantity: str) -> str:
    if quantity == "voltage_v":
        return "electrode_voltage_v"
    return f"{SLIDING}{quantity}" if quantity in RENAMED else quantity
