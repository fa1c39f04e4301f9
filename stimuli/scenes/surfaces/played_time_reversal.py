"""A plate that drives are played on: from the samples of all transducers to what a finger feels of them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

from tactometry.arguments.checked import checked

from ...composition.effect import Demand, FingerContact, Stage
from ...time_reversal.fingertip import Fingertip
from ...time_reversal.stimulus.sensation import place_on
from ...time_reversal.stimulus.setup import Setup
from ..effects import OF_TIME_REVERSAL
from .plate import REFUSES
from .played import PlayedSurface

if TYPE_CHECKING:
    from ...time_reversal.stimulus.contact_force import Places

PLATE = "tactometry.stimuli.scenes.stages.plate"
PRESSED = ("signal", "setup", "places_m", "contact")


class PlayedPlate(PlayedSurface):
    """The screen of a stimulus: plate, transducers and losses are those that its drives were made for.

    One finger rests on it, or several that share the force of a touch evenly (an unverified simplification); what is
    computed has a row for each. `finger` is that whose contact force is told where no effect says that it loads the
    plate.
    """

    kind = "time_reversal"
    effects = OF_TIME_REVERSAL
    refuses = REFUSES
    assumes: ClassVar[Mapping[str, str]] = {
        "plate": "plate, patches and losses as the stimulus states them, at the temperature at which it learnt",
        "amplifier": "amplifiers without a roll-off",
        "deflection": "a plate that moves by far less than its thickness",
    }
    touches = (FingerContact(1.0),)

    setup: Setup
    finger: Fingertip

    @property
    def places_m(self) -> "Places":
        """Where the fingers are."""
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

    Parameters
    ----------
    setup : Setup
    finger_x_m : float, optional
        Place of the finger along the length. Default: at the focus.
    finger_y_m : float, optional
        Place of the finger along the width. Default: at the focus.
    finger : Fingertip
        Whose contact force is told where no effect says that it loads the plate.

    Raises
    ------
    InvalidParameter
        If the finger is not on the plate.

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
        """Where the finger is; what is not said of it is that of the focus."""
        return (place_on(self.setup, self.finger_x_m, self.finger_y_m),)
