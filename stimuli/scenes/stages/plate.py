"""A plate under drives that are played: the displacement where a finger is, and what its load takes of it."""

from typing import TYPE_CHECKING, Any

import numpy as np

from tactometry.contact import Contact

from ...arrays import FloatArray

if TYPE_CHECKING:
    from tactometry.signal import Signal

    from ...time_reversal.responses.responses import Point
    from ...time_reversal.stimulus.setup import Setup


def setup(**fields: Any) -> "Setup":
    """The screen that a stimulus is played on."""
    from ...time_reversal.stimulus.setup import Setup

    return Setup(**fields)


def place(x_m: float, y_m: float) -> "Point":
    """Where a finger is."""
    return x_m, y_m


def times(displacement_m: FloatArray, setup: "Setup") -> FloatArray:
    """When the samples are."""
    return np.arange(displacement_m.size) / setup.rate_hz


def under_load(free_m: FloatArray, setup: "Setup", place_m: "Point", contact: Contact, **pulp: float) -> FloatArray:
    """The displacement under a finger, exact for one linear contact."""
    from ...time_reversal.finger import Fingertip
    from ...time_reversal.stimulus.sensation import loaded_displacement

    return loaded_displacement(free_m, setup, Fingertip(**pulp).load(place_m, contact.force_n))


def contact_force(signal: "Signal", setup: "Setup", place_m: "Point", contact: Contact, **pulp: float) -> FloatArray:
    """What a linear contact does to the finger on top of its force."""
    from ...time_reversal.finger import Fingertip
    from ...time_reversal.stimulus.contact_force import contact_force_n

    return contact_force_n(setup, signal, [Fingertip(**pulp).load(place_m, contact.force_n)])
