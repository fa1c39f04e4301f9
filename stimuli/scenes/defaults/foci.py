"""Foci at named places under fingers that rest on some of them."""

from ...time_reversal.stimulus.placed_foci import FingersSensation
from ..scene import SENSATION, Scene
from ..surfaces.played_fingers import PlayedFingers
from . import ACCURACY, effect


def default_scene(model: FingersSensation, duration_s: float = 1.0) -> Scene:
    """The scene of a model; no spectrum is read, however long its drives last.

    >>> from tactometry.contact import Contact
    >>> from tactometry.stimuli.time_reversal.stimulus.placed_foci import Place, PlacedFoci
    >>> from tactometry.stimuli.time_reversal.stimulus.setup import Setup
    >>> setup = Setup(n_transducers=8, modes_to_hz=22e3, rate_hz=50e3)
    >>> places = {"index": Place(0.10), "middle": Place(0.13)}
    >>> signal = PlacedFoci(setup, f_max_hz=20e3, places=places, place="index").at(20.0)
    >>> index_db, middle_db = default_scene(FingersSensation(setup, places)).fingers_db(signal, Contact(1.0))
    >>> abs(round(index_db, 2)), middle_db < -3
    (0.0, True)
    """
    surface = PlayedFingers(model.setup, model.places, model.fingers)
    detection = effect("focus_detection", model.reference_m)
    return Scene(surface, (detection,), (SENSATION,), ACCURACY, surface.touches)
