"""Both on one plate at once: a focus by time reversal, and electrovibration under a finger that slides."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, ClassVar

from tactometry.errors import InvalidParameter

from ...composition.effect import Demand, Effect, FingerContact, Size, Stage, Surface, Surroundings
from ..effects import OF_HYBRID
from .electrovibration import Electrovibration
from .time_reversal import TimeReversal

if TYPE_CHECKING:
    from .played_hybrid import PlayedHybrid

SLIDING = "sliding_"
"""In front of the names of stages, and of those quantities that both surfaces have, on the side that slides."""
SHARED = ("t_s", "motion", "sensation_db")
ELECTRODE_V = "electrode_voltage_v"


@dataclass(frozen=True)
class HybridScreen(Surface):
    """A plate that focuses, with an electrode on it.

    Fingers that rest feel the focus, the first that slides feels friction. To the plate all are loads at their places,
    those at rest first: in the time of a focus a finger slides less than a tenth of a wavelength. The attraction does
    not bend the plate, and the focus does not change friction: both are left out.

    Parameters
    ----------
    electrovibration : Electrovibration
        Table of the electrode and its effects.
    time_reversal : TimeReversal
        Table of the plate and its effects.

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

    def stages(self, scene: Demand) -> tuple[Stage, ...]:
        plate = self.time_reversal.stages(self._resting(scene))
        panel = self.electrovibration.stages(self._sliding(scene))
        return (*self._on(plate, self._resting), *map(_renamed, self._on(panel, self._sliding)))

    def stages_of(self, effect: Effect, scene: Demand) -> tuple[Stage, ...]:
        """The stages of an effect, on each side where it acts, or across both."""
        resting: tuple[Stage, ...] = ()
        sliding: tuple[Stage, ...] = ()
        if effect.kind in TimeReversal.effects:
            resting = self._on(super().stages_of(effect, self._resting(scene)), self._resting)
        if effect.kind in Electrovibration.effects:
            sliding = self._on(super().stages_of(effect, self._sliding(scene)), self._sliding)
        return (*resting, *map(_renamed, sliding)) or super().stages_of(effect, scene)

    def played(self, scene: Surroundings) -> "PlayedHybrid":
        """Both sides as they are played."""
        from .played_hybrid import PlayedHybrid

        return PlayedHybrid(self.electrovibration.played(), self.time_reversal.played(scene))

    def cure(self, quantity: str) -> str:
        """As on the side that has the quantity."""
        of_panel = quantity.removeprefix(SLIDING)
        return super().cure(quantity) if of_panel == quantity else self.electrovibration.cure(of_panel)

    def _on(self, stages: tuple[Stage, ...], side: Callable[[Demand], Demand]) -> tuple[Stage, ...]:
        """Stages that are sized by what one side asks for."""
        return tuple(
            stage if stage.size is None else replace(stage, size=_of_side(stage.size, side)) for stage in stages
        )

    def _sliding(self, scene: Demand) -> Demand:
        sliding = tuple(touch for touch in scene.contacts if touch.slides)
        return replace(scene, surface=self.electrovibration, contacts=sliding)

    def _resting(self, scene: Demand) -> Demand:
        _check_places(scene.contacts)
        touches = sorted(scene.contacts, key=lambda touch: touch.slides)
        contacts = tuple(replace(touch, speed_m_per_s=0.0) for touch in touches)
        return replace(scene, surface=self.time_reversal, contacts=contacts)


def _of_side(size: Callable[[Demand], Size], side: Callable[[Demand], Demand]) -> Callable[[Demand], Size]:
    return lambda demand: size(demand.once(side))


def _check_places(contacts: tuple[FingerContact, ...]) -> None:
    for n, touch in enumerate(contacts):
        if touch.slides and (touch.x_m is None or touch.y_m is None):
            raise InvalidParameter(
                f"contacts[{n}]: found a finger that slides without a place, expected one, for on a hybrid plate it is "
                "a load there; add x_m and y_m"
            )


def _renamed(stage: Stage) -> Stage:
    """A stage of the panel, so that its names are its own."""
    return replace(stage, name=f"{SLIDING}{stage.name}", needs=tuple(map(_name, stage.needs)), gives=_name(stage.gives))


def _name(quantity: str) -> str:
    return ELECTRODE_V if quantity == "voltage_v" else f"{SLIDING}{quantity}" if quantity in SHARED else quantity
