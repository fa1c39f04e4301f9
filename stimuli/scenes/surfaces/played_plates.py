"""Plates on which drives are played, with or without an electrode."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, ClassVar

from tactometry.arguments.checked import checked

from ...composition.effect import PLAYED, Demand, FingerContact, Stage, Surface
from ...time_reversal.fingertip import Fingertip
from ...time_reversal.stimulus.placed_foci import Place, check_fingers
from ...time_reversal.stimulus.sensation import place_on
from ...time_reversal.stimulus.setup import Setup
from ..effects import OF_HYBRID, OF_TIME_REVERSAL
from . import REFUSES, Side, TwoSided
from .electrovibration import PlayedElectrovibration

if TYPE_CHECKING:
    from ...time_reversal.stimulus.contact_force import Places

BOTH = "tactometry.stimuli.scenes.stages.record"
RESTING, SLIDING = "resting_", "sliding_"
"""Prefixes of stages and quantities of one side."""
COMMON = ("contact", "contact_force_n")
"""Quantities that both sides share for the one finger on a played surface."""
PLATE = "tactometry.stimuli.scenes.stages.plate"
PRESSED = ("signal", "setup", "places_m", "contact")


class PlayedPlate(Surface):
    """The screen of a stimulus, with the plate, transducers and losses that its drives were made for.

    One finger rests on it, or several that share the force of a touch evenly (an unverified simplification), with a row
    of results for each. Without a load effect, the contact force is that of `finger`.
    """

    kind = "time_reversal"
    is_played, given = True, PLAYED
    effects = OF_TIME_REVERSAL
    refuses = REFUSES
    assumes: ClassVar[Mapping[str, str]] = {
        "plate": "plate, patches and losses as the stimulus states them, at the temperature of learning",
        "amplifier": "amplifiers without a roll-off",
        "deflection": "a plate that moves by much less than its thickness",
    }
    touches = (FingerContact(1.0),)

    setup: Setup
    finger: Fingertip

    @property
    def places_m(self) -> "Places":
        """Places of the fingers."""
        raise NotImplementedError

    def stages(self, scene: Demand) -> tuple[Stage, ...]:
        x_m, y_m = zip(*self.places_m, strict=True)
        return (
            Stage("setup", (), "setup", f"{PLATE}:setup", dict(vars(self.setup))),
            Stage("places", (), "places_m", f"{PLATE}:places", {"x_m": x_m, "y_m": y_m}),
            Stage("plate", ("signal", "setup", "places_m"), "displacement_m", f"{PLATE}:free_displacement"),
            Stage("contact_force", PRESSED, "contact_force_n", f"{PLATE}:contact_force", dict(vars(self.finger))),
            Stage("times", ("displacement_m", "setup"), "t_s", f"{PLATE}:times"),
        )


@checked
@dataclass(frozen=True)
class PlayedTimeReversal(PlayedPlate):
    """A plate under one finger.

    Raises `InvalidParameter` if the finger is not on the plate.

    Parameters
    ----------
    setup : Setup
    finger_x_m : float, optional
        Place of the finger along the length. Default: at the focus.
    finger_y_m : float, optional
        Place of the finger along the width. Default: at the focus.
    finger : Fingertip
        Finger whose contact force is reported if no effect loads the plate.

    >>> PlayedTimeReversal().given
    ('signal', 'contact')
    """

    setup: Setup = field(default_factory=Setup)
    finger_x_m: float | None = None
    finger_y_m: float | None = None
    finger: Fingertip = field(default_factory=Fingertip)

    def __post_init__(self) -> None:
        self.setup.plate.check_holds("PlayedTimeReversal.finger_x_m, finger_y_m", self.places_m[0])

    @property
    def places_m(self) -> "Places":
        """Place of the finger; by default the focus."""
        return (place_on(self.setup, self.finger_x_m, self.finger_y_m),)


@dataclass(frozen=True)
class PlayedFingers(PlayedPlate):
    """A played plate under several fingers.

    A detection depends on the finger that feels most, a localisation on all fingers.

    Raises `InvalidParameter` if a finger rests on no place, or two are nearer to each other than a fingertip is wide.

    Parameters
    ----------
    setup : Setup
    places : mapping of str to Place
        Places of the stimulus.
    fingers : tuple of str
        Names of the places with a finger, at least a fingertip apart. Default: all places.
    finger : Fingertip
        Finger whose contact force is reported if no effect loads the plate.

    >>> PlayedFingers(Setup(), {"index": Place(0.10), "middle": Place(0.13)}).names
    ('index', 'middle')
    """

    assumes: ClassVar[Mapping[str, str]] = {
        **PlayedPlate.assumes,
        "load": "fingers that do not damp the motion under other fingers",
        "fingers": "fingers that share the force of a touch evenly",
    }

    setup: Setup
    places: Mapping[str, Place]
    fingers: tuple[str, ...] = ()
    finger: Fingertip = field(default_factory=Fingertip)

    def __post_init__(self) -> None:
        check_fingers("PlayedFingers.fingers", self.setup, self.places, self.fingers)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the places where a finger rests."""
        return self.fingers or tuple(self.places)

    @property
    def places_m(self) -> "Places":
        return tuple(self.places[name].on(self.setup) for name in self.names)


@dataclass(frozen=True)
class PlayedHybrid(TwoSided):
    """A played plate with an electrode, which is the last channel.

    Foci are felt as if the finger rested at the focus, and friction while it slides. The level is that of the stronger
    stimulus. Neither masks the other (an unverified simplification, which the effect `cross_masking` removes).

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
        "hybrid": "foci are felt as by a resting finger",
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
