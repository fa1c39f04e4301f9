"""Fingers on the plate as linear contacts or as contacts that open."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...arrays import ComplexArray, FloatArray, real_product
from ...time_reversal.fingertip import Fingertip
from ...time_reversal.plate.modes import values
from ...time_reversal.responses.load import CHUNK, Placed, PlateLoad, contact_transfer
from ...time_reversal.screen.transducer import PointForce
from .motion import PlateMotion, answer, moving_modes

if TYPE_CHECKING:
    from ...time_reversal.lift_off import ContactCourses

Numbers = tuple[float, ...]


def loaded_motion(motion: PlateMotion, x_m: Numbers, y_m: Numbers, force_n: Numbers, **pulp: Any) -> PlateMotion:
    """Return the motion under linear contacts, with their forces as channels."""
    finger = Fingertip(**pulp)
    contacts = [finger.contact((x, y), f) for x, y, f in zip(x_m, y_m, force_n, strict=True)]
    places = tuple(
        PointForce(x, y) if isinstance(one, PlateLoad) else one for x, y, one in zip(x_m, y_m, contacts, strict=True)
    )
    screen = replace(motion.screen, sources=(*motion.screen.sources, *places))
    amplitude, forces = np.empty_like(motion.amplitude), np.empty((len(contacts), len(motion.s)), complex)
    for start in range(0, len(motion.s), CHUNK):  # limits the memory of intermediate results
        part = slice(start, start + CHUNK)
        free = motion.among(part)
        units = [_unit_motion(replace(free, screen=replace(screen, sources=places)), n) for n in range(len(places))]
        forces[:, part] = _forces(free, units, contacts)
        pulled = sum(unit.amplitude * force for unit, force in zip(units, forces[:, part], strict=True))
        np.subtract(free.amplitude, pulled, out=amplitude[:, part])
    return replace(motion, screen=screen, amplitude=amplitude, played=np.vstack([motion.played, -forces]))


def contact_displacement(motion: PlateMotion, oversampling: int, x_m: Numbers, y_m: Numbers) -> FloatArray:
    """Return the displacement (m/V) under each finger, (n_contacts, n)."""
    return motion.course(motion.of_points(tuple(zip(x_m, y_m, strict=True))), oversampling)


def contact_force(motion: PlateMotion, oversampling: int, n: int) -> FloatArray:
    """Return the force on every finger (N/V), (n_contacts, n_times)."""
    return motion.course(-motion.played[-n:], oversampling)


def _forces(motion: PlateMotion, units: Sequence[PlateMotion], contacts: Sequence[Placed]) -> ComplexArray:
    """Return the forces Z (1 + H Z)^-1 U on the fingers."""
    among = np.stack([_under(unit, contacts) for unit in units], axis=1)
    stiffness = np.stack([contact.dynamic_stiffness(motion.s) for contact in contacts], axis=1)
    free = _under(motion, contacts)[None]
    return np.asarray(contact_transfer(free, among.transpose(2, 0, 1), stiffness)[0])


def _under(motion: PlateMotion, contacts: Sequence[Placed]) -> ComplexArray:
    """Return the spectra of the mean displacement under each contact."""
    spectra = motion.of_points(tuple(point for contact in contacts for point in contact.points))
    ends = np.cumsum([len(contact.points) for contact in contacts])[:-1]
    return np.stack([part.mean(axis=0) for part in np.split(spectra, ends)])


def _unit_motion(unit: PlateMotion, contact: int) -> PlateMotion:
    played = np.zeros((len(unit.screen.sources), len(unit.s)), complex)
    played[contact] = 1.0
    oscillators, at = moving_modes(unit.screen, unit.modes_to_hz, unit.static_to_hz)
    amplitude = at[:, contact, None] * oscillators.compliance(unit.screen.plate.mass_kg, unit.s)
    return replace(unit, amplitude=amplitude, played=played)


@dataclass(frozen=True, eq=False)
class OpenedMotion(PlateMotion):
    """Motion of a plate under fingers that may lift off, per volt, valid at one voltage.

    Parameters
    ----------
    contacts : ContactCourses
        Courses of the contacts, at `finer` steps per sample.
    finer : int
    voltage_v : float
    """

    contacts: "ContactCourses"
    finer: int
    voltage_v: float


def opened_motion(
    motion: PlateMotion, voltage_v: float, *, x_m: Numbers, y_m: Numbers, force_n: Numbers, finer: int, **pulp: Any
) -> PlateMotion:
    """Return the motion at a voltage under fingers that may lift off."""
    from ...time_reversal.lift_off import one_sided_contacts

    if voltage_v == 0:
        return motion
    finger, places = Fingertip(**pulp), tuple(zip(x_m, y_m, strict=True))
    loads = [finger.load(place, force) for place, force in zip(places, force_n, strict=True)]
    free = _under_forces(motion, np.zeros((len(places), len(motion.s)), complex))
    contacts = one_sided_contacts(
        motion.screen,
        voltage_v * free.course(free.of_points(places), finer),
        loads,
        np.asarray(force_n),
        finer * motion.rate_hz,
        motion.modes_to_hz,
        _still_m_per_n(motion, places),
    )
    answers = (contacts.contact_force_n - np.asarray(force_n)[:, None]) / voltage_v

    # the mean of each step is at its middle
    shift, step_s = motion.s[0].real, 1 / (finer * motion.rate_hz)
    damped = answers * np.exp(-shift * step_s * np.arange(answers.shape[1]))
    spectrum = np.fft.rfft(damped, motion.n_fft * finer)[:, : len(motion.s)] / finer
    opened = _under_forces(motion, np.asarray(spectrum * np.exp(motion.s * step_s / 2)))
    inherited = {field.name: getattr(opened, field.name) for field in fields(PlateMotion)}
    return OpenedMotion(**inherited, contacts=contacts, finer=finer, voltage_v=voltage_v)


def contact_answers(motion: PlateMotion, oversampling: int, n: int) -> FloatArray:
    """Return the fingers' force minus their normal force, per volt."""
    if not isinstance(motion, OpenedMotion):  # at 0 V
        return np.zeros((n, (motion.n_samples - 1) * oversampling + 1))
    pressed_n = motion.contacts.force_n[:, None]
    answers = (motion.contacts.contact_force_n - pressed_n) / motion.voltage_v
    # the mean of each step is at its middle
    steps, times = np.arange(answers.shape[1]) - 0.5, motion.times_s(oversampling)
    at = (times - times[0]) * motion.rate_hz * motion.finer
    return np.stack([np.interp(at, steps, answer_n) for answer_n in answers])


def lost_s(motion: PlateMotion) -> FloatArray:
    """Return the time without contact of each finger, (n_contacts,)."""
    if not isinstance(motion, OpenedMotion):
        return np.zeros(1)
    return np.asarray(motion.contacts.apart.sum(axis=1) / (motion.finer * motion.rate_hz))


def _under_forces(motion: PlateMotion, forces: ComplexArray) -> PlateMotion:
    """Return the motion with new contact forces (N/V), (n_contacts, n_frequencies)."""
    n = len(forces)
    oscillators, at = moving_modes(motion.screen, motion.modes_to_hz, motion.static_to_hz)
    pushed, change = np.ascontiguousarray(at[:, -n:]), -forces - motion.played[-n:]
    mass_kg = motion.screen.plate.mass_kg
    moved = answer(oscillators, mass_kg, motion.s, lambda part: real_product(pushed, change[:, part]))
    played = np.vstack([motion.played[:-n], -forces])
    return replace(motion, amplitude=motion.amplitude + moved, played=played)


def _still_m_per_n(motion: PlateMotion, places: tuple[tuple[float, float], ...]) -> FloatArray:
    """Return the static compliance (m/N) of the modes that do not move."""
    at = np.asarray(places)
    n = len(motion.amplitude)
    shapes = values(motion.modes, at[:, 0], at[:, 1])[n:]
    pushed = replace(motion.screen, sources=tuple(PointForce(*place) for place in places))
    forces = pushed.modal_forces(motion.static_to_hz)[n:]
    return np.asarray(shapes.T @ (forces / motion.stiffness_n_per_m[:, None]))
