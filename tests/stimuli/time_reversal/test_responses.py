"""Impulse responses of the model: reciprocity, causality, energy, Parseval, patches, bad input."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.special import j1
from soak import SOAK

from tactometry.stimuli.time_reversal import Plate
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
from tactometry.stimuli.time_reversal.plate.modes import laplacians, modes_of, values
from tactometry.stimuli.time_reversal.responses.responses import Responses, band_limited, impulse_responses, samples_in
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE, Screen
from tactometry.stimuli.time_reversal.screen.transducer import DiscPatch, Patch, PointForce, border

FAST = {"rate_hz": 50e3, "duration_s": 4e-3, "f_max_hz": 5e3}


def point_screen(plate: Plate, *places: tuple[float, float], tau_s: float = 3e-3) -> Screen:
    return Screen(plate, tuple(PointForce(*place) for place in places), Attenuation(tau_s))


def a4(boundary: str) -> Plate:
    return Plate(0.297, 0.210, 1.1e-3, 64e9, 0.2, 2230.0, boundary)


@pytest.mark.parametrize("boundary", ["SSSS", "FFFF", "CFSF"])
@pytest.mark.parametrize("quantity", ["displacement", "velocity", "acceleration"])
def test_reciprocity(boundary, quantity):
    p, q = (0.05, 0.17), (0.2, 0.03)
    there = impulse_responses(point_screen(a4(boundary), p), [q], quantity=quantity, **FAST)
    back = impulse_responses(point_screen(a4(boundary), q), [p], quantity=quantity, **FAST)
    assert there.samples == pytest.approx(back.samples, rel=1e-12, abs=1e-14 * np.abs(there.samples).max())


@settings(max_examples=200 if SOAK else 20, deadline=None)
@given(
    boundary=st.just("SSSS") | st.text("SCF", min_size=4, max_size=4),
    aspect=st.floats(1.0, 20.0),
    thickness_m=st.floats(1e-4, 1e-2),
    glass=st.tuples(st.floats(60e9, 75e9), st.floats(0.15, 0.3)),
    x=st.floats(0.0, 1.0),
    y=st.floats(0.0, 1.0),
    tau_s=st.floats(1e-6, 1.0),
    n_modes=st.integers(1, 20),
)
def test_any_plate_and_edges_are_reciprocal_and_causal(boundary, aspect, thickness_m, glass, x, y, tau_s, n_modes):
    plate = Plate(0.3, 0.3 / aspect, thickness_m, *glass, 2400.0, boundary)
    p, q = (x * plate.length_m, y * plate.width_m), (0.4 * plate.length_m, 0.7 * plate.width_m)
    f_max = (n_modes + 2 * aspect) / plate.modal_density_s
    timing = {"rate_hz": 2.5 * f_max, "duration_s": 100 / f_max, "f_max_hz": f_max}
    there = impulse_responses(point_screen(plate, p, tau_s=tau_s), [q], **timing).samples[0, 0]
    back = impulse_responses(point_screen(plate, q, tau_s=tau_s), [p], **timing).samples[0, 0]
    assert np.isfinite(there).all()
    assert np.abs(there - back).max() <= 1e-12 * np.abs(there).max()
    assert abs(there[0]) <= 1e-12 * np.abs(there).max()
    frequencies = plate.frequencies_hz(f_max)
    n_rigid = {0: 3, 1: 1}.get(4 - boundary.count("F"), 0) if boundary.count("C") == 0 else 0
    assert np.count_nonzero(frequencies == 0) == n_rigid
    assert (np.diff(frequencies) >= 0).all()


def test_energy_balance_of_an_impulse():
    """Energy put in = energy stored + energy lost, at any time, to 1e-10."""
    plate, at, f_max = A4_SCREEN, (0.08, 0.13), 20e3
    screen = point_screen(plate, at)
    oscillators = screen.oscillators(f_max)
    push = values(screen.modes(f_max), *at)[:, 0] / plate.mass_kg
    put_in = 0.5 * plate.mass_kg * push @ push
    end_s = 2e-3
    nodes, weights = np.polynomial.legendre.leggauss(12)
    edges = np.linspace(0, end_s, 401)
    half = (edges[1] - edges[0]) / 2
    times = ((edges[1:] + edges[:-1]) / 2)[:, None] + half * nodes
    speed = oscillators.impulse_at(times.ravel(), "velocity") * push[:, None]
    power = 2 * plate.mass_kg / 3e-3 * (speed**2).sum(axis=0)
    lost = float(power @ np.tile(weights * half, 400))
    u, v = (oscillators.impulse_at(end_s, quantity)[:, 0] for quantity in ("displacement", "velocity"))
    stored = 0.5 * plate.mass_kg * np.sum(push**2 * (v**2 + (oscillators.omega_rad_per_s * u) ** 2))
    assert stored + lost == pytest.approx(put_in, rel=1e-10)


@pytest.mark.parametrize("place", [(0.0, 0.1), (0.297, 0.21), (0.1485, 0.21)])
def test_edge_and_corner_of_a_supported_plate_do_not_move(place):
    h = impulse_responses(A4_PROTOTYPE, [place], **FAST).samples
    assert np.abs(h).max() == 0.0


def test_patch_force_is_the_integral_of_the_laplacian():
    modes = modes_of(a4("FFFF"), 5e3)
    patch = Patch(0.05, 0.03, 0.012, 0.008, 1.0)
    nodes, weights = np.polynomial.legendre.leggauss(20)
    x, y = 0.05 + 0.006 * nodes, 0.03 + 0.004 * nodes
    area = np.outer(weights * 0.006, weights * 0.004).ravel()
    expected = -laplacians(modes, np.repeat(x, 20), np.tile(y, 20)) @ area
    assert patch.modal_force(modes) == pytest.approx(expected, rel=1e-9, abs=1e-11 * np.abs(expected).max())


def test_disc_on_a_supported_plate_is_the_bessel_closed_form():
    """The mean of a solution of Helmholtz's equation over a disc is its centre times 2 J1(ka) / ka."""
    modes = modes_of(A4_SCREEN, 25e3)
    k = np.sqrt(modes.angular_frequency_rad_per_s / A4_SCREEN.wave_constant_m2_per_s)
    radius = 17.5e-3
    centre = values(modes, 0.1, 0.08)[:, 0]
    expected = k**2 * centre * math.pi * radius**2 * 2 * j1(k * radius) / (k * radius)
    found = DiscPatch(0.1, 0.08, 35e-3, 1.0).modal_force(modes)
    assert found == pytest.approx(expected, abs=1e-11 * np.abs(expected).max())


def test_transducer_as_large_as_the_plate_is_the_exact_integral():
    whole = Patch(0.1485, 0.105, 0.297, 0.210, 1.0)
    modes = modes_of(A4_SCREEN, 5e3)
    odd = (modes.m % 2 == 1) & (modes.n % 2 == 1)
    k2 = (math.pi * modes.m / 0.297) ** 2 + (math.pi * modes.n / 0.210) ** 2
    expected = np.where(odd, k2 * 2 * (2 * 0.297 / (math.pi * modes.m)) * (2 * 0.210 / (math.pi * modes.n)), 0.0)
    assert whole.modal_force(modes) == pytest.approx(expected, abs=1e-9 * expected.max())
    assert np.isfinite(
        impulse_responses(Screen(A4_SCREEN, (whole,), Attenuation(3e-3)), [(0.1, 0.1)], **FAST).samples
    ).all()


def test_border_places_patches_in_equal_steps():
    n, (a, b) = 10, (0.297 - 0.024, 0.21 - 0.024)
    patches = border(A4_SCREEN, n)
    assert (patches[0].x_m, patches[0].y_m) == pytest.approx((12e-3 + (a + b) / n, 12e-3))
    steps = [abs(p.x_m - q.x_m) + abs(p.y_m - q.y_m) for p, q in pairwise(patches)]
    assert steps == pytest.approx([2 * (a + b) / n] * (n - 1))


def test_responses_are_read_only_and_select_channels():
    h = Responses(np.arange(24.0).reshape(2, 3, 4), 1e3)
    with pytest.raises(ValueError, match="read-only"):
        h.samples[0, 0, 0] = 1.0
    assert h.of_channels([2, 0]).samples[:, :, 0].tolist() == [[8.0, 0.0], [20.0, 12.0]]


def test_a_duration_is_rounded_to_the_nearest_sample():
    assert 0.29 * 100.0 < 29
    assert samples_in("duration_s", 0.29, 100.0) == 29


def test_border_layout_keeps_its_distance_from_the_edges():
    for patch in border(A4_SCREEN, 32):
        inset = min(patch.x_m, patch.y_m, 0.297 - patch.x_m, 0.210 - patch.y_m)
        assert inset == pytest.approx(12e-3)


def test_frequency_dependent_attenuation_shortens_the_high_notes():
    loss = Attenuation(3e-3, exponent=0.5, reference_hz=10e3)
    assert loss.rate_per_s(np.array([10e3, 40e3])) * 3e-3 == pytest.approx([1.0, 2.0])


STATIC_SCREEN = Screen(A4_SCREEN, tuple(border(A4_SCREEN, 4)), Attenuation(3.5e-3))
STATIC_POINTS = [(0.1, 0.08), (0.2, 0.15)]


def static_responses(f_max_hz, static_to_hz=None):
    return impulse_responses(
        STATIC_SCREEN, STATIC_POINTS, rate_hz=400e3, duration_s=25e-3, f_max_hz=f_max_hz, static_to_hz=static_to_hz
    )


def test_the_static_residual_saves_modes():
    """Below 10 kHz, the modes to 20 kHz and the residual do better than those to 60 kHz without it."""
    band = Band(0.0, 10e3)
    whole = band_limited(static_responses(190e3), band).samples

    def error(responses):
        return np.linalg.norm(band_limited(responses, band).samples - whole) / np.linalg.norm(whole)

    corrected = error(static_responses(20e3, 190e3))
    assert corrected < error(static_responses(60e3)) / 2
    assert corrected < error(static_responses(20e3)) / 5


def test_static_residual_restores_compliance_of_all_modes():
    static = static_responses(12e3, 190e3).samples.sum(axis=2)
    assert static == pytest.approx(static_responses(190e3).samples.sum(axis=2), rel=2e-3)


def test_the_static_residual_is_on_sample_0_alone():
    change = static_responses(12e3, 190e3).samples - static_responses(12e3).samples
    assert change[..., 0].all()
    assert not change[..., 1:].any()


def test_screen_accepts_list_from_border():
    from_list = Screen(A4_SCREEN, border(A4_SCREEN, 4), Attenuation(3e-3))
    assert from_list == Screen(A4_SCREEN, tuple(border(A4_SCREEN, 4)), Attenuation(3e-3))
    assert from_list.modal_forces(500.0).shape[1] == 4
