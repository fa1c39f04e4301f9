"""A plate that drives are played on, under fingers that rest on named places of it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

from ...time_reversal.fingertip import Fingertip
from ...time_reversal.stimulus.placed_foci import Place, check_fingers
from ...time_reversal.stimulus.setup import Setup
from .played_time_reversal import PlayedPlate

if TYPE_CHECKING:
    from ...time_reversal.stimulus.contact_force import Places


@dataclass(frozen=True)
class PlayedFingers(PlayedPlate):
    """A plate under fingers, of which the one that feels most decides a detection, and all of them a localisation.

    Parameters
    ----------
    setup : Setup
    places : mapping of str to Place
        Those of the stimulus.
    fingers : tuple of str
        The places where a finger rests, a fingertip or more from each other; by default on every one.
    finger : Fingertip
        Whose contact force is told where no effect says that it loads the plate.

    Raises
    ------
    InvalidParameter
        If a finger rests on no place, or two are nearer to each other than a fingertip is wide.

    >>> PlayedFingers(Setup(), {"index": Place(0.10), "middle": Place(0.13)}).names
    ('index', 'middle')
    """

    assumes: ClassVar[Mapping[str, str]] = {
        **PlayedPlate.assumes,
        "load": "fingers that do not damp what others feel",
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
        """The places where a finger rests."""
        return self.fingers or tuple(self.places)

    @property
    def places_m(self) -> "Places":
        return tuple(self.places[name].on(self.setup) for name in self.names)
