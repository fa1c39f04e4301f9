"""Fingers that rest on the plate: each answers its motion there with a force that moves the plate in turn."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...arrays import ComplexArray, FloatArray
from ...time_reversal.fingertip import Fingertip
from ...time_reversal.responses.load import CHUNK, PlateLoad, contact_transfer
from ...time_reversal.screen.transducer import PointForce
from .motion import PlateMotion, moving_modes

Numbers = tuple[float, ...]


def loaded_motion(motion: PlateMotion, x_m: Numbers, y_m: Numbers, force_n: Numbers, **pulp: float) -> PlateMotion:
    """The motion of the plate under fingers: their forces are further channels, exact for linear contacts."""
    finger = Fingertip(**pulp)
    contacts = [finger.load((x, y), f) for x, y, f in zip(x_m, y_m, force_n, strict=True)]
    places = tuple(PointForce(contact.x_m, contact.y_m) for contact in contacts)
    screen = replace(motion.screen, sources=(*motion.screen.sources, *places))
    amplitude, forces = np.empty_like(motion.amplitude), np.empty((len(contacts), len(motion.s)), complex)
    for start in range(0, len(motion.s), CHUNK):  # what is computed on the way takes no more memory than these
        part = slice(start, start + CHUNK)
        free = motion.among(part)
        units = [_unit_motion(replace(free, screen=replace(screen, sources=places)), n) for n in range(len(places))]
        forces[:, part] = _forces(free, units, contacts)
        pulled = sum(unit.amplitude * force for unit, force in zip(units, forces[:, part], strict=True))
        np.subtract(free.amplitude, pulled, out=amplitude[:, part])
    return replace(motion, screen=screen, amplitude=amplitude, played=np.vstack([motion.played, -forces]))


def contact_displacement(motion: PlateMotion, oversampling: int, x_m: Numbers, y_m: Numbers) -> FloatArray:
    """(n_contacts, n): the displacement under every finger (m/V)."""
    return motion.course(motion.of_points(tuple(zip(x_m, y_m, strict=True))), oversampling)


def contact_force(motion: PlateMotion, oversampling: int, n: int) -> FloatArray:
    """(n_contacts, n_times): the force on every finger (N/V): the last channels of the motion, reversed."""
    return motion.course(-motion.played[-n:], oversampling)


def _forces(motion: PlateMotion, units: Sequence[PlateMotion], contacts: Sequence[PlateLoad]) -> ComplexArray:
    """(n_contacts, n_frequencies): on the fingers, Z (1 + H Z)^-1 U, from the motions by a unit force at each."""
    points = tuple((contact.x_m, contact.y_m) for contact in contacts)
    among = np.stack([unit.of_points(points) for unit in units], axis=1)
    stiffness = np.stack([contact.dynamic_stiffness(motion.s) for contact in contacts], axis=1)
    free = motion.of_points(points)[None]
    return np.asarray(contact_transfer(free, among.transpose(2, 0, 1), stiffness)[0])


def _unit_motion(unit: PlateMotion, contact: int) -> PlateMotion:
    """The motion by a unit force at one contact, at each frequency."""
    played = np.zeros((len(unit.screen.sources), len(unit.s)), complex)
    played[contact] = 1.0
    oscillators, at = moving_modes(unit.screen, unit.modes_to_hz, unit.static_to_hz)
    amplitude = at[:, contact, None] * oscillators.compliance(unit.screen.plate.mass_kg, unit.s)
    return replace(unit, amplitude=amplitude, played=played)
