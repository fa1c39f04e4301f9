"""A plate that drives are played on: from the samples of all transducers to what a finger feels of them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

from ...composition.effect import Demand, FingerContact, Stage
from ...time_reversal.finger import Fingertip
from ...time_reversal.stimulus.setup import Setup
from ..effects import OF_TIME_REVERSAL
from .played import PlayedSurface

PLATE = "tactometry.stimuli.scenes.stages.plate"
PRESSED = ("signal", "setup", "place_m", "contact")
FREE = "tactometry.stimuli.time_reversal.stimulus.sensation:free_displacement"


@dataclass(frozen=True)
class PlayedTimeReversal(PlayedSurface):
    """The screen of a stimulus: plate, transducers and losses are those that its drives were made for.

    Parameters
    ----------
    setup : Setup
    finger_x_m, finger_y_m : float, optional
        Where the finger is; by default at the focus.
    finger : Fingertip
        Whose contact force is told where no effect says that it loads the plate.

    Raises
    ------
    InvalidParameter
        If the finger is not on the plate.

    >>> PlayedTimeReversal().given
    ('signal', 'contact')
    """

    kind = "time_reversal"
    effects = OF_TIME_REVERSAL
    assumes: ClassVar[Mapping[str, str]] = {
        "plate": "plate, patches and losses as the stimulus states them, at the temperature at which it learnt",
        "amplifier": "amplifiers without a roll-off",
        "deflection": "a plate that moves by far less than its thickness",
    }
    touches = (FingerContact(1.0),)

    setup: Setup = field(default_factory=Setup)
    finger_x_m: float | None = None
    finger_y_m: float | None = None
    finger: Fingertip = field(default_factory=Fingertip)

    def __post_init__(self) -> None:
        self.setup.plate.check_holds("PlayedTimeReversal.finger_x_m, finger_y_m", self.place_m)

    @property
    def place_m(self) -> tuple[float, float]:
        """Where the finger is; what is not said of it is that of the focus."""
        x_m, y_m = self.setup.focus_m
        return x_m if self.finger_x_m is None else self.finger_x_m, y_m if self.finger_y_m is None else self.finger_y_m

    def stages(self, scene: Demand) -> tuple[Stage, ...]:
        x_m, y_m = self.place_m
        return (
            Stage("setup", (), "setup", f"{PLATE}:setup", dict(vars(self.setup))),
            Stage("place", (), "place_m", f"{PLATE}:place", {"x_m": x_m, "y_m": y_m}),
            Stage("plate", ("signal", "setup", "place_m"), "displacement_m", FREE),
            Stage("contact_force", PRESSED, "contact_force_n", f"{PLATE}:contact_force", dict(vars(self.finger))),
            Stage("times", ("displacement_m", "setup"), "t_s", f"{PLATE}:times"),
        )
