"""Contacts on the plate: lift-off and rigid contactors by their equations of motion, and the finger pulp."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.integrate import solve_ivp

from tactometry.experiments.accuracy.problems.plate_motion import (
    AT_M as AT,
    DURATION_S,
    IMPULSE_N_S,
    SMALL,
    TO_HZ,
    by_events,
    free_m,
)
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.finger import Contactor, amplitude_loss, hertz_stiffness_n_per_m
from tactometry.stimuli.time_reversal.fingertip import Fingertip
from tactometry.stimuli.time_reversal.focus_loss import focus_loss
from tactometry.stimuli.time_reversal.focusing.focusing import Emission, emitted
from tactometry.stimuli.time_reversal.lift_off import one_sided_contact
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
from tactometry.stimuli.time_reversal.pulp import PulpLoad, Tissue, disc_stiffness
from tactometry.stimuli.time_reversal.responses.load import SprungMass, loaded_responses
from tactometry.stimuli.time_reversal.responses.responses import values_at
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE, Screen
from tactometry.stimuli.time_reversal.screen.transducer import PointForce
from tactometry.stimuli.time_reversal.stimulus.focus_train import FocusTrain
from tactometry.stimuli.time_reversal.stimulus.sensation import free_displacement, loaded_displacements
from tactometry.stimuli.time_reversal.stimulus.setup import Setup

RATE_HZ = 400e3


@pytest.mark.parametrize("finger", [Fingertip(), Fingertip(stiffness_n_per_m=2e3)], ids=["damper", "damper and spring"])
def test_lift_off_matches_event_based_solution(finger):
    plate, skin, n_events = by_events(finger, 0.5, RATE_HZ)
    found = one_sided_contact(SMALL, AT, free_m(RATE_HZ), RATE_HZ, TO_HZ, 0.5, finger)
    assert n_events >= 3
    assert found.apart.any()
    largest = np.abs(plate).max()
    assert found.displacement_m == pytest.approx(plate, abs=2e-4 * largest)
    assert found.skin_m == pytest.approx(skin, abs=2e-4 * largest)


def test_hard_pressed_finger_matches_linear_contact():
    finger = replace(Fingertip(), exponent=0.0)
    found = one_sided_contact(SMALL, AT, free_m(RATE_HZ), RATE_HZ, TO_HZ, 1e3, finger)
    sampling = {"rate_hz": RATE_HZ, "duration_s": DURATION_S, "f_max_hz": TO_HZ}
    linear = loaded_responses(SMALL, [AT], [finger.load(AT, 1e3)], **sampling).samples[0, 0] * RATE_HZ * IMPULSE_N_S
    assert not found.apart.any()
    assert found.displacement_m == pytest.approx(linear, abs=5e-3 * np.abs(linear).max())


@given(
    force_n=st.floats(0.01, 20.0),
    impulse_n_s=st.floats(1e-4, 1.0),
    stiffness_n_per_m=st.one_of(st.just(0.0), st.floats(1.0, 1e4)),
)
@settings(max_examples=20, deadline=None)
def test_finger_never_pulls_or_penetrates_the_plate(force_n, impulse_n_s, stiffness_n_per_m):
    finger = Fingertip(stiffness_n_per_m=stiffness_n_per_m)
    course = free_m(100e3, impulse_n_s)
    found = one_sided_contact(SMALL, AT, course, 100e3, TO_HZ, force_n, finger)
    gap_m, largest = found.skin_m - found.displacement_m, np.abs(course).max()
    assert found.contact_force_n.min() >= 0
    assert gap_m.min() >= -1e-12 * largest
    assert np.abs(gap_m[~found.apart]).max() <= 1e-12 * largest


def test_rigid_contactor_matches_its_equations_of_motion():
    """Modes and tip as one system of ordinary differential equations after a tap, by Runge-Kutta of order 8.

    M (q'' + 2 a q' + w^2 q) = - sum_i R_i phi_i phi_i.q' - phi_c k (phi_c.q - z), m z'' = k (phi_c.q - z).
    """
    rate_hz, at, to_hz = 800e3, (0.05, 0.04), 15e3
    plate = replace(A4_SCREEN, length_m=0.12, width_m=0.09)
    tapped = Screen(plate, (PointForce(0.08, 0.03),), Attenuation(2e-3))
    loads = Contactor("rigid", 5e-3).loads(plate, at, 2.0)
    skin, tip = loads[:-1], loads[-1]
    assert (len(skin), tip.mass_kg) == (7, 2e-3)
    resistance, stiffness = skin[0].resistance_n_s_per_m, hertz_stiffness_n_per_m(2.0, 2.5e-3)
    assert sum(part.resistance_n_s_per_m for part in skin) == pytest.approx(10 / 4)
    modes, mass_kg = tapped.oscillators(to_hz), plate.mass_kg
    weights = values_at(tapped, [(part.x_m, part.y_m) for part in skin], to_hz)
    here, n = values_at(tapped, [at], to_hz)[:, 0], modes.omega_rad_per_s.size

    def slope(_, state):
        q, speed, z, tip_speed = state[:n], state[n : 2 * n], state[2 * n], state[2 * n + 1]
        spring_n = stiffness * (here @ q - z)
        on_plate = -resistance * (weights @ (weights.T @ speed)) - here * spring_n
        own = -2 * modes.decay_per_s * speed - modes.omega_rad_per_s**2 * q
        return np.concatenate([speed, own + on_plate / mass_kg, [tip_speed, spring_n / 2e-3]])

    start = np.concatenate([np.zeros(n), tapped.modal_forces(to_hz)[:, 0] / (mass_kg * rate_hz), [0.0, 0.0]])
    t = np.arange(1600) / rate_hz
    q = solve_ivp(slope, (0, t[-1]), start, "DOP853", t, rtol=1e-9, atol=1e-18).y[:n]
    heard = loaded_responses(tapped, [at], loads, rate_hz=rate_hz, duration_s=2e-3, f_max_hz=to_hz).samples[0, 0]
    assert heard == pytest.approx(here @ q, abs=3e-3 * np.abs(here @ q).max())


def test_rigid_contactor_mass_is_independent_of_force():
    light, heavy = (Contactor("rigid").loads(A4_SCREEN, (0.1, 0.1), force_n)[-1] for force_n in (0.1, 4.0))
    assert light.mass_kg == heavy.mass_kg
    assert heavy.stiffness_n_per_m == pytest.approx(40 ** (1 / 3) * light.stiffness_n_per_m)


def test_sprung_mass_reduces_to_mass_or_spring():
    s = np.array([10j, 1e3j, 100 + 1e5j])
    np.testing.assert_allclose(SprungMass(0.1, 0.1, 1e-3, 1e20).dynamic_stiffness(s), 1e-3 * s**2, rtol=1e-9)
    np.testing.assert_allclose(SprungMass(0.1, 0.1, 1e9, 1.0).dynamic_stiffness(s), 1.0, rtol=1e-9)


RADIUS_M, AREA_M2 = 6e-3, math.pi * 6e-3**2
FOCUS = (0.121, 0.093)
RIG = Emission(Band(200.0, 25e3, 200.0), 7e-3, 100e3)


def stiffness(frequency_hz, tissue, radius_m=RADIUS_M):
    return disc_stiffness(2j * np.pi * np.atleast_1d(np.asarray(frequency_hz, float)), radius_m, tissue)


@pytest.mark.parametrize("sound_speed_m_per_s", [3.0, 30.0, 1500.0])
def test_pulp_at_low_frequency_is_the_rigid_punch_of_boussinesq(sound_speed_m_per_s):
    shear_pa, tissue = 1e3, Tissue(1000.0, sound_speed_m_per_s, 1e3, 0.0)
    longitudinal_pa = 1000.0 * sound_speed_m_per_s**2
    poisson_ratio = (longitudinal_pa - 2 * shear_pa) / (2 * (longitudinal_pa - shear_pa))
    expected = 4 * shear_pa * RADIUS_M / (1 - poisson_ratio)
    np.testing.assert_allclose(stiffness([0.0, 1e-3], tissue).real, expected, rtol=1e-4)


def test_viscous_pulp_at_low_frequency_resists_as_a_disc_in_creeping_flow():
    impedance = stiffness(1e-3, Tissue(shear_modulus_pa=0.0, shear_viscosity_pa_s=5.0)) / (2j * np.pi * 1e-3)
    assert impedance[0].real == pytest.approx(8 * 5.0 * RADIUS_M, rel=1e-2)


@pytest.mark.parametrize("radii_per_wave", [10.0, 30.0])
def test_pulp_at_high_frequency_radiates_plane_waves(radii_per_wave):
    tissue = Tissue(1000.0, 1500.0, 0.0, 0.02)
    frequency_hz = radii_per_wave * 1500.0 / (2 * np.pi * RADIUS_M)
    impedance = stiffness(frequency_hz, tissue)[0] / (2j * np.pi * frequency_hz)
    assert impedance == pytest.approx(1000.0 * 1500.0 * AREA_M2, rel=1.5 / radii_per_wave)


def test_pulp_of_little_shear_is_the_added_mass_of_a_disc():
    """A disc in an unbounded liquid carries 8/3 rho a^3 on two sides."""
    mass_kg = -stiffness(2e3, Tissue(1000.0, 1500.0, 1.0, 1e-3))[0].real / (2 * np.pi * 2e3) ** 2
    assert mass_kg == pytest.approx(4 / 3 * 1000.0 * RADIUS_M**3, rel=2e-2)


@pytest.mark.parametrize("shear_modulus_pa", [0.0, 2e3, 5e4, 1e6])
@pytest.mark.parametrize("shear_viscosity_pa_s", [0.3, 2.0, 15.0])
@pytest.mark.parametrize("radius_m", [1e-4, 6e-3, 2e-2])
def test_pulp_is_passive_from_0_to_100_khz(shear_modulus_pa, shear_viscosity_pa_s, radius_m):
    tissue = Tissue(1100.0, 1500.0, shear_modulus_pa, shear_viscosity_pa_s)
    frequency_hz = np.concatenate([[0.0], np.geomspace(1.0, 1e5, 26)])
    found = stiffness(frequency_hz, tissue, radius_m)
    assert (found.imag >= -1e-12 * np.abs(found)).all()  # w Re Z, but for rounding at 0 Hz


def test_interpolated_stiffness_is_that_of_each_frequency():
    load = PulpLoad(0.1, 0.1, RADIUS_M, Tissue(shear_viscosity_pa_s=0.3))
    s = 1300.0 + 2j * np.pi * np.linspace(0.0, 125e3, 401)
    direct = np.concatenate([disc_stiffness(part, RADIUS_M, load.tissue) for part in np.array_split(s, 20)])
    np.testing.assert_allclose(load.dynamic_stiffness(s), direct, rtol=2e-3)


@pytest.mark.parametrize("load", [Fingertip().load(FOCUS), PulpLoad(*FOCUS, RADIUS_M)], ids=["damper", "pulp"])
def test_loss_from_the_plate_computed_once_is_amplitude_loss(load):
    once = focus_loss(A4_PROTOTYPE, FOCUS, load, RIG)
    expected = amplitude_loss(A4_PROTOTYPE, FOCUS, [load], RIG)
    assert once.by(load.dynamic_stiffness(once.s)) == pytest.approx(expected, rel=1e-9)


def test_loss_grows_with_force_from_none_to_less_than_all():
    tip = Fingertip(impedance="tissue")
    losses = [amplitude_loss(A4_PROTOTYPE, FOCUS, [tip.contact(FOCUS, force_n)], RIG) for force_n in (0, 0.5, 2, 100)]
    assert losses[0] == 0
    assert losses == sorted(losses)
    assert losses[-1] < 1


def test_displacement_under_tissue_is_that_of_loaded_responses():
    """The free motion over the disc is that of waves of the plate, not of each mode."""
    setup = Setup(n_transducers=8, modes_to_hz=22e3, rate_hz=50e3)
    signal, load = FocusTrain(setup, f_max_hz=20e3).at(20.0), PulpLoad(*setup.focus_m, RADIUS_M)
    free_m = free_displacement(signal, setup, setup.focus_m)
    sampling = {"rate_hz": 50e3, "duration_s": free_m.size / 50e3, "f_max_hz": 22e3}
    exact_m = emitted(signal, loaded_responses(setup.screen, [setup.focus_m], [load], **sampling))[0][: free_m.size]
    found_m = loaded_displacements(free_m[None], setup, [load])[0]
    np.testing.assert_allclose(found_m, exact_m, atol=5e-3 * np.abs(exact_m).max())
