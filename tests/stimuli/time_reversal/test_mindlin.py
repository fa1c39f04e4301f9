"""Frequencies of thick plates with any edges, against a Ritz solution of Mindlin's plate in its three fields."""

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.linalg import block_diag, eigh

from tactometry.stimuli.time_reversal import Plate
from tactometry.stimuli.time_reversal.plate.dispersion import frequencies_rad_per_s, mindlin_angular_frequency_rad_per_s
from tactometry.stimuli.time_reversal.plate.modes import modes_of, values
from tactometry.stimuli.time_reversal.plate.plate import ritz

KAPPA = 5 / 6
N = 28


def plate(boundary, thickness_m, width_m=0.7):
    return Plate(1.0, width_m, thickness_m, 70e9, 0.3, 2500.0, boundary)


def along(degree, held):
    """Legendre polynomials that vanish at the held ends, their slopes and Gauss's weights."""
    rows = np.eye(degree + 1) * np.sqrt(np.arange(degree + 1) + 0.5)
    for end, factor in zip(held, ([1, 1], [1, -1]), strict=True):
        rows = [legendre.legmul(row, factor) for row in rows] if end else rows
    x, w = legendre.leggauss(degree + 4)
    return [legendre.legval(x, row) for row in rows], [legendre.legval(x, legendre.legder(row)) for row in rows], w


def mindlin(p, degree):
    """The lowest angular frequencies of Mindlin's plate in deflection and two rotations (hard supports)."""
    x_ends, y_ends = (p.boundary[0], p.boundary[2]), (p.boundary[1], p.boundary[3])
    held = {name: [edge in which for edge in ends] for name, ends, which in [
        ("x", x_ends, "SC"), ("y", y_ends, "SC"), ("turn x", x_ends, "C"), ("turn y", y_ends, "C")]}  # fmt: skip
    on = {name: along(degree, ends) for name, ends in held.items()}
    w, turn_x, turn_y = (on["x"], on["y"]), (on["turn x"], on["y"]), (on["x"], on["turn y"])
    a, b, nu = p.length_m, p.width_m, p.poisson_ratio
    rigidity, mass = p.bending_rigidity_n_m, p.area_density_kg_per_m2
    shear = KAPPA * p.youngs_modulus_pa / (2 * (1 + nu)) * p.thickness_m

    def integral(f, f_x, f_y, g, g_x, g_y):
        x = (np.array(f[0][f_x]) * f[0][2]) @ np.array(g[0][g_x]).T
        y = (np.array(f[1][f_y]) * f[1][2]) @ np.array(g[1][g_y]).T
        return (2 / a) ** (f_x + g_x) * (2 / b) ** (f_y + g_y) * a * b / 4 * np.kron(x, y)

    def twice(f, f_x, f_y):
        return integral(f, f_x, f_y, f, f_x, f_y)

    xx = rigidity * (twice(turn_x, 1, 0) + (1 - nu) / 2 * twice(turn_x, 0, 1)) + shear * twice(turn_x, 0, 0)
    yy = rigidity * (twice(turn_y, 0, 1) + (1 - nu) / 2 * twice(turn_y, 1, 0)) + shear * twice(turn_y, 0, 0)
    xy = nu * integral(turn_x, 1, 0, turn_y, 0, 1) + (1 - nu) / 2 * integral(turn_x, 0, 1, turn_y, 1, 0)
    wx, wy = shear * integral(w, 1, 0, turn_x, 0, 0), shear * integral(w, 0, 1, turn_y, 0, 0)
    ww = shear * (twice(w, 1, 0) + twice(w, 0, 1))
    stiffness = np.block([[ww, wx, wy], [wx.T, xx, rigidity * xy], [wy.T, rigidity * xy.T, yy]])
    inertia = mass * p.thickness_m**2 / 12
    kinetic = block_diag(mass * twice(w, 0, 0), inertia * twice(turn_x, 0, 0), inertia * twice(turn_y, 0, 0))
    shift = (10 * p.wave_constant_m2_per_s / a**2) ** 2
    n = len(kinetic)
    theta = eigh(kinetic, stiffness + shift * kinetic, eigvals_only=True, subset_by_index=[n - N - 1, n - 1])
    return np.sqrt(np.maximum(1 / theta[::-1] - shift, 0))


def corrected(p):
    blocks = ritz(p, 440 * p.wave_constant_m2_per_s / (2 * np.pi))
    thin = p.wave_constant_m2_per_s * np.sort(np.concatenate([block.wavenumber2_per_m2 for block in blocks]))
    thick = np.sort(np.concatenate([frequencies_rad_per_s(p, block, KAPPA) for block in blocks]))
    return thin, thick


def worst(found, expected):
    n = min(len(found), len(expected))
    bent = expected[:n] > 1e-3 * expected.max()
    return np.abs(found[:n][bent] / expected[:n][bent] - 1).max()


@pytest.mark.parametrize("boundary", ["FFFF", "CCCC", "CFFF", "SFSF"])
@pytest.mark.parametrize(
    ("over_side", "width_m", "error"), [(0.02, 0.7, 2e-3), (0.05, 0.4, 1e-2), (0.1, 1.0, 2.7e-2), (0.2, 0.7, 6e-2)]
)
def test_thick_plate_correction_stays_within_stated_error(boundary, width_m, over_side, error):
    """The error depends on thickness over the shorter side."""
    p = plate(boundary, over_side * width_m, width_m)
    expected = mindlin(p, 16)[:N]
    thin, thick = corrected(p)
    waves = mindlin_angular_frequency_rad_per_s(p, np.sqrt(thin / p.wave_constant_m2_per_s), KAPPA)
    assert worst(thick, expected) < error
    assert over_side > 0.05 or worst(thick, expected) < 0.9 * worst(waves, expected)
    assert worst(thick, expected) < 0.15 * worst(thin, expected)


def test_simply_supported_edges_are_exact():
    p = plate("SSSS", 0.1)
    thin, thick = corrected(p)
    waves = mindlin_angular_frequency_rad_per_s(p, np.sqrt(thin / p.wave_constant_m2_per_s), KAPPA)
    assert thick == pytest.approx(waves, rel=1e-8)
    assert worst(thick, mindlin(p, 16)[:N]) < 1e-6


def test_a_strip_loses_torsional_stiffness_as_an_elastic_bar_does():
    """Torsion constant of a bar b x h: b h^3 / 3 (1 - 0.630 h / b) (Saint-Venant); h / (12 kappa)^(1/2) per edge."""
    wide, narrow = 1.0, 0.1
    p = Plate(wide, narrow, 4e-3, 70e9, 0.3, 2500.0, "FFFF")
    blocks = ritz(p, 1500.0)
    thin, thick = (
        np.concatenate(parts)
        for parts in (
            [p.wave_constant_m2_per_s * block.wavenumber2_per_m2 for block in blocks],
            [frequencies_rad_per_s(p, block, KAPPA) for block in blocks],
        )
    )
    twists = np.concatenate(
        [np.full(len(b.vectors), b.on_x.order[0] % 2 == 1 and b.on_y.order[0] % 2 == 1) for b in blocks]
    )
    first = np.flatnonzero(twists & (thin > 0))[np.argmin(thin[twists & (thin > 0)])]
    assert (thick[first] / thin[first]) ** 2 == pytest.approx(1 - 0.630 * 4e-3 / narrow, abs=2e-3)


def test_thick_modes_keep_rigid_motions_shapes_and_order():
    p = plate("FFFF", 0.02)
    thin, thick = modes_of(p, 2e3), modes_of(p, 2e3, shear_factor=KAPPA)
    assert np.array_equal(thick.frequency_hz[:3], np.zeros(3))
    assert (np.diff(thick.frequency_hz) >= 0).all()
    assert thick.frequency_hz[-1] <= 2e3
    assert len(thick.frequency_hz) >= len(thin.frequency_hz)
    x, y = np.linspace(0, 1.0, 5), np.linspace(0, 0.7, 4)
    amplitude = np.random.default_rng(0).normal(size=len(thick.frequency_hz))
    points = values(thick, *(axis.ravel() for axis in np.meshgrid(x, y, indexing="ij")))
    assert thick.field(amplitude, x, y).ravel() == pytest.approx(amplitude @ points, abs=1e-9)


def test_every_thick_mode_below_a_frequency_is_there():
    """Some of them are slower than their thin mode by more than the plane wave of that frequency is."""
    plate = Plate(0.2, 0.15, 8e-3, 64e9, 0.2, 2230.0, "CFFC")
    found, more = (modes_of(plate, f_hz, shear_factor=5 / 6).frequency_hz for f_hz in (40e3, 55e3))
    assert found == pytest.approx(more[more <= 40e3], rel=1e-3)
    assert len(found) > 30
