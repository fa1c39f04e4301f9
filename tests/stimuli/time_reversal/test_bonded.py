"""Mass and stiffness of bonded patches as a low-rank load."""

from math import sqrt

import numpy as np
import pytest
from scipy.linalg import eigh

from tactometry.errors import InvalidParameter
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
from tactometry.stimuli.time_reversal.plate.oscillators import Oscillators
from tactometry.stimuli.time_reversal.responses.bonded_patches import Ceramic, Stiffener, bonded_loads
from tactometry.stimuli.time_reversal.responses.load import PlateLoad, Receptances, loaded_receptance, loaded_responses
from tactometry.stimuli.time_reversal.responses.responses import values_at
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.screen import Screen
from tactometry.stimuli.time_reversal.screen.transducer import DiscPatch, Patch, PointForce, border

F_MAX_HZ = 2e3
AT, SEEN = (0.07, 0.05), (0.2, 0.13)
SCREEN = Screen(A4_SCREEN, (PointForce(*AT),), Attenuation(5e-3))
TIMING = {"rate_hz": 100e3, "duration_s": 10e-3, "f_max_hz": F_MAX_HZ}


def dense(loads):
    """The response from the eigenmodes of M + m phi phi^T and K + k psi psi^T; damping 2 / tau of the whole mass."""
    modes = SCREEN.modes(F_MAX_HZ)
    omega, n = modes.angular_frequency_rad_per_s, len(modes.angular_frequency_rad_per_s)
    mass, stiffness = A4_SCREEN.mass_kg * np.eye(n), A4_SCREEN.mass_kg * np.diag(omega**2)
    for load in loads:
        weight = load.weights(SCREEN, F_MAX_HZ)
        if isinstance(load, PlateLoad):
            mass += load.mass_kg * np.outer(weight, weight)
        else:
            stiffness += load.rigidity_n_m3 * np.outer(weight, weight)
    values, vectors = eigh(stiffness, mass)
    push, at = (vectors.T @ values_at(SCREEN, [place], F_MAX_HZ)[:, 0] for place in (AT, SEEN))
    basis = Oscillators(np.sqrt(values), np.zeros(n)).impulse(TIMING["rate_hz"], 0, 1000)
    return (push * at) @ basis / TIMING["rate_hz"]


@pytest.mark.parametrize(("mass", "stiffness"), [(True, False), (False, True), (True, True)])
def test_loaded_responses_are_those_of_a_dense_eigenproblem(mass, stiffness):
    """Without attenuation, because the dense modes of added mass would lose it too."""
    lossless = Screen(A4_SCREEN, SCREEN.sources, Attenuation(float("inf")))
    loads = bonded_loads(A4_SCREEN, border(A4_SCREEN, 6), mass=mass, stiffness=stiffness)
    found = loaded_responses(lossless, [SEEN], loads, **TIMING).samples[0, 0]
    expected = dense(loads)
    assert np.linalg.norm(found - expected) < 2e-3 * np.linalg.norm(expected)


def test_a_patch_as_large_as_the_wave_is_long_changes_the_first_mode_as_rayleigh_says():
    """For the first mode the quotient (K + dD A lap^2) / (M + m phi^2) holds while the shape stays."""
    disc = DiscPatch(A4_SCREEN.length_m / 2, A4_SCREEN.width_m / 2, 1e-3)
    loads = bonded_loads(A4_SCREEN, [disc])
    modes = SCREEN.modes(F_MAX_HZ)
    omega = modes.angular_frequency_rad_per_s[0]
    shape, curvature = (load.weights(SCREEN, F_MAX_HZ)[0] for load in loads)
    k = A4_SCREEN.mass_kg * omega**2 + loads[1].rigidity_n_m3 * curvature**2
    m = A4_SCREEN.mass_kg + loads[0].mass_kg * shape**2
    n = len(modes.angular_frequency_rad_per_s)
    mass = A4_SCREEN.mass_kg * np.eye(n) + loads[0].mass_kg * np.outer(*[loads[0].weights(SCREEN, F_MAX_HZ)] * 2)
    stiff = A4_SCREEN.mass_kg * np.diag(modes.angular_frequency_rad_per_s**2)
    stiff += loads[1].rigidity_n_m3 * np.outer(*[loads[1].weights(SCREEN, F_MAX_HZ)] * 2)
    assert eigh(stiff, mass, eigvals_only=True)[0] == pytest.approx(k / m, rel=1e-5)
    assert sqrt(k / m) != pytest.approx(omega, rel=1e-7)


def test_added_rigidity_vanishes_with_the_thickness_and_doubles_a_plate_that_is_bonded_on():
    thin = Ceramic(thickness_m=1e-9).added_rigidity_n_m(A4_SCREEN)
    assert thin == pytest.approx(59e9 / 0.91 * (1.1e-3 / 2) ** 2 * 1e-9, rel=1e-5)
    both_sides = Ceramic(
        thickness_m=A4_SCREEN.thickness_m / 2,
        youngs_modulus_pa=A4_SCREEN.youngs_modulus_pa,
        poisson_ratio=A4_SCREEN.poisson_ratio,
    ).added_rigidity_n_m(A4_SCREEN)
    assert 2 * both_sides + A4_SCREEN.bending_rigidity_n_m == pytest.approx(8 * A4_SCREEN.bending_rigidity_n_m)


def test_patches_that_tile_the_plate_are_a_plate_with_their_rigidity_and_mass_added():
    """Midpoints of 12 x 10 tiles are an exact quadrature for the first modes, so the receptance is that of D + dD."""
    tiles = [(0.297 * (i + 0.5) / 12, 0.21 * (j + 0.5) / 10) for i in range(12) for j in range(10)]
    patches = [Patch(x, y, 0.297 / 12, 0.21 / 10) for x, y in tiles]
    modes = SCREEN.modes(500.0)
    omega = modes.angular_frequency_rad_per_s
    to, of = (values_at(SCREEN, [place], 500.0) for place in (AT, SEEN))
    s = np.array([20.0 + 700.0j, 3000.0j])
    loads = bonded_loads(A4_SCREEN, patches)
    at = np.stack([load.weights(SCREEN, 500.0) for load in loads], axis=1)
    stiffness = np.stack([load.dynamic_stiffness(s) for load in loads], axis=1)
    bare = Receptances.of(Oscillators(omega, np.zeros(len(omega))), A4_SCREEN.mass_kg, s)
    mass_kg = A4_SCREEN.mass_kg + 7700.0 * 0.3e-3 * A4_SCREEN.area_m2
    stiffer = 1 + Ceramic().added_rigidity_n_m(A4_SCREEN) / A4_SCREEN.bending_rigidity_n_m
    turned = omega * sqrt(stiffer * A4_SCREEN.mass_kg / mass_kg)
    expected = Receptances.of(Oscillators(turned, np.zeros(len(omega))), mass_kg, s).between(to, of)
    assert np.abs(loaded_receptance(bare, to, of, at, stiffness) / expected - 1).max() < 1e-10


def test_no_patches_no_loads_no_change():
    assert bonded_loads(A4_SCREEN, []) == []
    assert bonded_loads(A4_SCREEN, border(A4_SCREEN, 4), mass=False, stiffness=False) == []


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Ceramic(thickness_m=0.0), "Ceramic.thickness_m: found 0.0"),
        (lambda: Ceramic(poisson_ratio=0.6), "Ceramic.poisson_ratio: found 0.6"),
        (lambda: Stiffener(0.1, 0.1, -1.0), "Stiffener.rigidity_n_m3: found -1.0"),
    ],
)
def test_bad_ceramics_are_refused(make, sentence):
    with pytest.raises(InvalidParameter) as caught:
        make()
    assert str(caught.value).startswith(sentence)
