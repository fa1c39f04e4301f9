"""Impedance of the finger pulp: limits, passivity, and the loss of a focus under it."""

import math

import numpy as np
import pytest

from tactometry.errors import InvalidParameter
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.finger import amplitude_loss
from tactometry.stimuli.time_reversal.fingertip import Fingertip
from tactometry.stimuli.time_reversal.focus_loss import focus_loss
from tactometry.stimuli.time_reversal.focusing.focusing import Emission, emitted
from tactometry.stimuli.time_reversal.pulp import PulpLoad, Tissue, disc_stiffness
from tactometry.stimuli.time_reversal.responses.load import loaded_responses
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE
from tactometry.stimuli.time_reversal.stimulus.focus_train import FocusTrain
from tactometry.stimuli.time_reversal.stimulus.sensation import free_displacement, loaded_displacements
from tactometry.stimuli.time_reversal.stimulus.setup import Setup

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


def test_shear_waves_that_are_too_short_are_refused():
    with pytest.raises(InvalidParameter, match="raise the shear viscosity"):
        stiffness(1e5, Tissue(shear_modulus_pa=10.0, shear_viscosity_pa_s=0.0))


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


def test_disc_over_an_edge_is_refused():
    with pytest.raises(InvalidParameter, match="PulpLoad: found"):
        PulpLoad(2e-3, 0.1, RADIUS_M).weights(A4_PROTOTYPE, 1e3)


def test_tissue_where_a_contact_opens_is_refused():
    with pytest.raises(InvalidParameter, match="expected 'lumped' where contacts open"):
        Fingertip(impedance="tissue").load(FOCUS)


def test_displacement_under_tissue_is_that_of_loaded_responses():
    """The free motion over the disc is that of waves of the plate, not of each mode."""
    setup = Setup(n_transducers=8, modes_to_hz=22e3, rate_hz=50e3)
    signal, load = FocusTrain(setup, f_max_hz=20e3).at(20.0), PulpLoad(*setup.focus_m, RADIUS_M)
    free_m = free_displacement(signal, setup, setup.focus_m)
    sampling = {"rate_hz": 50e3, "duration_s": free_m.size / 50e3, "f_max_hz": 22e3}
    exact_m = emitted(signal, loaded_responses(setup.screen, [setup.focus_m], [load], **sampling))[0][: free_m.size]
    found_m = loaded_displacements(free_m[None], setup, [load])[0]
    np.testing.assert_allclose(found_m, exact_m, atol=5e-3 * np.abs(exact_m).max())
