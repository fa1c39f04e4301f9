"""A focusing plate with an electrode on it."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, ClassVar

from tactometry.errors import InvalidParameter

from ...composition.effect import Demand, FingerContact, Surroundings
from ..effects import OF_HYBRID
from . import Side, TwoSided
from .electrovibration import Electrovibration
from .time_reversal import TimeReversal

if TYPE_CHECKING:
    from .played_plates import PlayedHybrid

SLIDING = "sliding_"
"""Prefix of stages and quantities of the sliding finger's side."""
RENAMED = ("t_s", "motion", "sensation_db")
"""Quantities that both sides have."""


@dataclass(frozen=True)
class HybridScreen(TwoSided):
    """A focusing plate with an electrode on it.

    Fingers at rest feel the focus, and the first sliding finger feels friction. All fingers load the plate at their
    places, those at rest first, since a finger slides less than a tenth of a wavelength during a focus. The model
    ignores that the attraction bends the plate and that the focus changes friction.

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
        "hybrid": "the attraction does not bend the plate, and its vibration does not lubricate the sliding finger",
    }

    electrovibration: Electrovibration
    time_reversal: TimeReversal = field(default_factory=TimeReversal)

    def sides(self) -> tuple[Side, ...]:
        plate = Side(self.time_reversal, self._resting)
        return plate, Side(self.electrovibration, self._sliding, lambda name: f"{SLIDING}{name}", _on_electrode)

    def played(self, scene: Surroundings) -> "PlayedHybrid":
        """Return the surface with both sides as played surfaces."""
        from .played_plates import PlayedHybrid

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
