"""A rigid contactor, against its equations of motion."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tactometry.stimuli.time_reversal.finger import Contactor, hertz_stiffness_n_per_m
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
from tactometry.stimuli.time_reversal.responses.load import SprungMass, loaded_responses
from tactometry.stimuli.time_reversal.responses.responses import values_at
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.screen import Screen
from tactometry.stimuli.time_reversal.screen.transducer import PointForce


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
