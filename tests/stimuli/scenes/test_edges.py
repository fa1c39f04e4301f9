"""Plate edges by Rayleigh-Ritz: predicted truncation errors."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from exact_plate import dense_ritz, levy_modes
from scene_cases import effect, screen, small_screen
from scene_errors import LOSSY, error_of, run
from soak import SOAK

from tactometry.errors import InvalidParameter
from tactometry.stimuli.time_reversal.plate import modes, plate
from tactometry.stimuli.time_reversal.screen import screen as screens

BOUNDARIES = ("CCCC", "CFFF")
"""Of which there is no solution of another origin here: their own polynomials of more degrees, whose frequencies
`../time_reversal/test_ritz.py` holds against published ones."""
COURSE = ("t_s", "focus_displacement_m")


@pytest.fixture
def with_degrees(monkeypatch):
    """Run with this many polynomial degrees above the shortest wave."""

    def clear():
        modes._modes_of.cache_clear()
        screens._modal_forces.cache_clear()

    def at(margin, scene):
        with monkeypatch.context() as patch:
            patch.setattr(plate, "MARGIN_DEGREES", margin)
            clear()
            got = run(scene)
        clear()
        return got

    return at


@dataclass(frozen=True)
class Exact:
    """Modes from another solver, for a whole scene."""

    plate: object
    angular_frequency_rad_per_s: np.ndarray
    shapes: object

    @property
    def frequency_hz(self):
        return self.angular_frequency_rad_per_s / (2 * np.pi)

    def products(self, on_x, on_y):
        points = zip(on_x(Itself()), on_y(Itself()), strict=True)
        return np.stack([self.shapes(x, y) for x, y in points], axis=1)

    def frame(self, x_m, y_m):
        raise NotImplementedError

    field = frame


class Itself:
    """Stand-in for functions of x or y."""

    def value(self, at):
        return np.atleast_1d(at)


@cache
def exact(plate, f_max_hz, shear_factor):
    """Return modes of Levy's solution or of one dense eigenproblem."""
    assert shear_factor is None
    if plate.boundary == "FFFF":
        omega, shapes = dense_ritz(plate, 26)
        n = int(np.searchsorted(omega, 2 * np.pi * f_max_hz))
        still = np.where(np.arange(n) < 3, 0.0, omega[:n])
        return Exact(plate, still, lambda x, y: np.ravel(shapes(x, y))[:n])
    modes = levy_modes(plate, f_max_hz)
    return Exact(plate, np.array([omega for omega, _ in modes]), lambda x, y: [shape(x, y) for _, shape in modes])


@pytest.fixture
def on_exact_modes(monkeypatch):
    """Return a runner that uses modes of another solver."""

    def run_on(scene):
        with monkeypatch.context() as patch:
            patch.setattr(modes, "_modes_of", exact)
            screens._modal_forces.cache_clear()
            got = run(scene)
        screens._modal_forces.cache_clear()
        return got

    return run_on


@pytest.mark.parametrize("boundary", ["SFSF", "SCSC", "FFFF"])
def test_edges_error_bounds_difference_to_exact_modes(boundary, on_exact_modes):
    scene = replace(held(boundary), settings={"motion": {"modes_to_hz": 12e3, "static_to_hz": 16e3}})
    predicted = next(stage.error for stage in scene.resolve().stages if stage.name == "edges")
    assert error_of(run(scene), on_exact_modes(scene), COURSE[1]) <= predicted


@pytest.mark.slow
@pytest.mark.parametrize("boundary", ["SFSF", "SCSC"])
def test_simply_supported_scene_matches_levy_within_accuracy(boundary, on_exact_modes):
    scene = held(boundary, LOSSY)
    to_hz, accuracies = (120e3, (1e-1, 1e-2, 1e-3, 1e-4)) if SOAK else (60e3, (1e-1, 1e-2, 1e-3))
    whole = {"motion": {"modes_to_hz": to_hz, "static_to_hz": to_hz}}
    reference = on_exact_modes(replace(scene, accuracy=8e-5, settings=whole))
    for accuracy in accuracies:
        finer = replace(scene, accuracy=accuracy)
        assert error_of(run(finer), reference, COURSE[1]) <= finer.resolve().error <= accuracy


def held(boundary, *effects, **changes):
    scene = screen(effect("edges", boundary=boundary), *effects, outputs=COURSE)
    return replace(scene, surface=small_screen(f_max_hz=8e3, flank_hz=2e3, rate_hz=32e3, **changes))


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_edges_error_bounds_difference_to_more_degrees(boundary, with_degrees):
    scene = replace(held(boundary), settings={"motion": {"modes_to_hz": 12e3, "static_to_hz": 16e3}})
    predicted = next(stage.error for stage in scene.resolve().stages if stage.name == "edges")
    assert predicted > 0
    assert error_of(run(scene), with_degrees(40, scene), COURSE[1]) <= predicted


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_a_scene_with_other_edges_keeps_its_accuracy(boundary, with_degrees):
    scene = held(boundary, LOSSY)
    whole = {"motion": {"modes_to_hz": 60e3, "static_to_hz": 60e3}}
    reference = with_degrees(25, replace(scene, accuracy=1e-3, settings=whole))
    for accuracy in (1e-1, 1e-2):
        finer = replace(scene, accuracy=accuracy)
        assert error_of(run(finer), reference, COURSE[1]) <= finer.resolve().error <= accuracy


def test_accuracy_finer_than_polynomials_is_refused():
    assert held("FFFF").resolve()
    with pytest.raises(InvalidParameter, match=r"accuracy: .*edges CFFF, expected at least .*; loosen the accuracy"):
        replace(held("CFFF"), accuracy=1e-4).resolve()


@pytest.mark.parametrize(("boundary", "width_m"), [("SFSF", 0.09), ("FFFF", 0.09), ("FFFF", 0.12)])
def test_the_strain_energy_may_take_further_modes_of_another_solution(boundary, width_m, on_exact_modes):
    energy = replace(held(boundary, LOSSY, effect("drive_energy"), width_m=width_m), outputs=("energy_j",))
    far = {"modes_to_hz": 12e3, "static_to_hz": 16e3}
    mixed = replace(energy, settings={"motion": far, "strain_energy": {"static_to_hz": 32e3}})
    one = replace(energy, settings={"motion": far | {"static_to_hz": 32e3}, "strain_energy": {"static_to_hz": 32e3}})
    expected = on_exact_modes(one)["energy_j"] if boundary == "SFSF" else run(one)["energy_j"]
    assert run(mixed)["energy_j"] == pytest.approx(expected, rel=1e-6)
    assert run(replace(energy, settings={"motion": far, "strain_energy": {"static_to_hz": 16e3}})) != run(mixed)
