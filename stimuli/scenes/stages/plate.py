"""Displacement of a played plate under fingers."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from tactometry.contact import Contact

from ...arrays import FloatArray

if TYPE_CHECKING:
    from tactometry.signal import Signal

    from ...time_reversal.responses.load import Placed
    from ...time_reversal.stimulus.contact_force import Places
    from ...time_reversal.stimulus.setup import Setup


def setup(**fields: Any) -> "Setup":
    from ...time_reversal.stimulus.setup import Setup

    return Setup(**fields)


def places(x_m: tuple[float, ...], y_m: tuple[float, ...]) -> "Places":
    """Return the places of the fingers."""
    return tuple(zip(x_m, y_m, strict=True))


def free_displacement(signal: "Signal", setup: "Setup", places_m: "Places") -> FloatArray:
    """Return the free displacement under fingers (n_fingers, n_samples)."""
    from ...time_reversal.stimulus.sensation import free_displacement

    return np.stack([free_displacement(signal, setup, at_m) for at_m in places_m])


def times(displacement_m: FloatArray, setup: "Setup") -> FloatArray:
    """Return the times of the samples."""
    return np.arange(displacement_m.shape[1]) / setup.rate_hz


def under_load(free_m: FloatArray, setup: "Setup", places_m: "Places", contact: Contact, **pulp: Any) -> FloatArray:
    """Return the displacement under linear fingers that load the plate."""
    from ...time_reversal.stimulus.sensation import loaded_displacements

    return loaded_displacements(free_m, setup, _loads(places_m, contact, pulp))


def contact_force(signal: "Signal", setup: "Setup", places_m: "Places", contact: Contact, **pulp: Any) -> FloatArray:
    """Return the force of linear contacts on each finger."""
    from ...time_reversal.stimulus.contact_force import contact_forces_n

    return contact_forces_n(setup, signal, _loads(places_m, contact, pulp))


def _loads(places_m: "Places", contact: Contact, pulp: Mapping[str, Any]) -> "list[Placed]":
    from ...time_reversal.fingertip import Fingertip

    finger, force_n = Fingertip(**pulp), contact.force_n / len(places_m)
    return [finger.contact(at_m, force_n) for at_m in places_m]
