"""A plate under drives that are played: the displacement where a finger is, and what its load takes of it."""

from typing import TYPE_CHECKING, Any

import numpy as np

from tactometry.contact import Contact
from tactometry.errors import InvalidParameter

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


def free_displacement(signal: "Signal", setup: "Setup", place_m: "Point") -> FloatArray:
    """(n_samples,): what the plate does there as long as nothing is on it.

    Raises
    ------
    InvalidParameter
        If the signal is not in volt, or its rate or channels are not those of the setup.
    """
    from ...time_reversal.focusing.focusing import emitted

    n_channels = signal.samples.shape[0]
    if signal.unit != "V" or n_channels != setup.n_transducers or signal.rate_hz != setup.rate_hz:
        raise InvalidParameter(
            f"signal: found {n_channels} channels in {signal.unit!r} at {signal.rate_hz:g} Hz, expected "
            f"{setup.n_transducers} in volt ('V') at {setup.rate_hz:g} Hz, as in the setup"
        )
    return np.asarray(emitted(signal, setup.responses_at(*place_m))[0])


def times(displacement_m: FloatArray, setup: "Setup") -> FloatArray:
    """When the samples are."""
    return np.arange(displacement_m.size) / setup.rate_hz


def under_load(free_m: FloatArray, setup: "Setup", place_m: "Point", contact: Contact, **pulp: float) -> FloatArray:
    """The displacement under a finger, exact for one linear contact."""
    from ...time_reversal.finger import Fingertip
    from ...time_reversal.stimulus.sensation import loaded_displacement

    return loaded_displacement(free_m, setup, Fingertip(**pulp).load(place_m, contact.force_n))
