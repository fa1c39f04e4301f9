"""Fingers that rest on the plate: each answers its motion there with a force that moves the plate in turn."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tactometry.errors import InvalidParameter

from ...arrays import ComplexArray, FloatArray, real_product
from ...time_reversal.finger import Fingertip
from ...time_reversal.responses.load import PlateLoad, contact_transfer
from ...time_reversal.screen.screen import Screen
from ...time_reversal.screen.transducer import PointForce
from .motion import PlateMotion, answer, moving_modes

Numbers = tuple[float, ...]


def loaded_motion(motion: PlateMotion, x_m: Numbers, y_m: Numbers, force_n: Numbers, **pulp: float) -> PlateMotion:
    """The motion of the plate under fingers: their forces are further channels, exact for linear contacts."""
    finger = Fingertip(**pulp)
    contacts = [finger.load((x, y), f) for x, y, f in zip(x_m, y_m, force_n, strict=True)]
    _check_places(motion.screen, contacts)
    places = tuple(PointForce(contact.x_m, contact.y_m) for contact in contacts)
    screen = replace(motion.screen, sources=(*motion.screen.sources, *places))
    forces = _forces(motion, screen, contacts)
    oscillators, at = moving_modes(screen, motion.modes_to_hz, motion.static_to_hz)
    pushed = np.ascontiguousarray(at[:, -len(places) :])
    amplitude = answer(oscillators, screen.plate.mass_kg, motion.s, lambda part: real_product(pushed, -forces[:, part]))
    amplitude += motion.amplitude
    return replace(motion, screen=screen, amplitude=amplitude, played=np.vstack([motion.played, -forces]))


def contact_displacement(motion: PlateMotion, oversampling: int, x_m: Numbers, y_m: Numbers) -> FloatArray:
    """(n_contacts, n): the displacement under every finger (m/V)."""
    return motion.course(motion.of_points(tuple(zip(x_m, y_m, strict=True))), oversampling)


def contact_force(motion: PlateMotion, oversampling: int, n: int) -> FloatArray:
    """(n_contacts, n_times): the force on every finger (N/V): the last channels of the motion, reversed."""
    return motion.course(-motion.played[-n:], oversampling)


def _forces(motion: PlateMotion, screen: Screen, contacts: Sequence[PlateLoad]) -> ComplexArray:
    """(n_contacts, n_frequencies): on the fingers, Z (1 + H Z)^-1 U."""
    points = tuple((contact.x_m, contact.y_m) for contact in contacts)
    unit = replace(motion, screen=replace(screen, sources=screen.sources[-len(contacts) :]))
    among = np.stack([_unit_motion(unit, n).of_points(points) for n in range(len(contacts))], axis=1)
    stiffness = np.stack([contact.dynamic_stiffness(motion.s) for contact in contacts], axis=1)
    free = motion.of_points(points)[None]
    return np.asarray(contact_transfer(free, among.transpose(2, 0, 1), stiffness)[0])


def _unit_motion(unit: PlateMotion, contact: int) -> PlateMotion:
    """The motion by a unit force at one contact, at every frequency."""
    played = np.zeros((len(unit.screen.sources), len(unit.s)), complex)
    played[contact] = 1.0
    oscillators, at = moving_modes(unit.screen, unit.modes_to_hz, unit.static_to_hz)
    amplitude = answer(oscillators, unit.screen.plate.mass_kg, unit.s, lambda part: at[:, contact, None])
    return replace(unit, amplitude=amplitude, played=played)


def _check_places(screen: Screen, contacts: Sequence[PlateLoad]) -> None:
    for n, contact in enumerate(contacts):
        if not screen.plate.contains(contact.x_m, contact.y_m):
            raise InvalidParameter(
                f"contacts[{n}]: found ({contact.x_m}, {contact.y_m}) m, expected a place on the plate of "
                f"{screen.plate.length_m} x {screen.plate.width_m} m"
            )
