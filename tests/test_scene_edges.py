"""Edges by Rayleigh and Ritz: what their polynomials miss stands in the plan, or is refused."""

from dataclasses import replace

import pytest
from scene_cases import effect, screen, small_screen
from test_scene_time_reversal import LOSSY, error_of, run

from tactometry.errors import InvalidParameter
from tactometry.stimuli.time_reversal import plate, ritz
from tactometry.stimuli.time_reversal import screen as screens

BOUNDARIES = ("FFFF", "CCCC", "CFFF", "SSFF")
COURSE = ("t_s", "focus_displacement_m")


@pytest.fixture
def with_degrees(monkeypatch):
    """A run whose polynomials go so many degrees beyond the shortest wave."""

    def clear():
        plate._modes.cache_clear()
        screens._modal_forces.cache_clear()

    def at(margin, scene):
        with monkeypatch.context() as patch:
            patch.setattr(ritz, "MARGIN_DEGREES", margin)
            clear()
            got = run(scene)
        clear()
        return got

    return at


def held(boundary, *effects, **changes):
    scene = screen(effect("edges", boundary=boundary), *effects, outputs=COURSE)
    return replace(scene, surface=small_screen(band_max_hz=8e3, flank_hz=2e3, rate_hz=32e3, **changes))


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_what_more_degrees_change_is_within_the_error_of_the_stage(boundary, with_degrees):
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


def test_an_accuracy_finer_than_the_polynomials_is_refused_with_the_cure():
    assert held("FFFF").resolve()
    with pytest.raises(InvalidParameter, match=r"accuracy: .*edges CFFF, expected at least .*; loosen the accuracy"):
        replace(held("CFFF"), accuracy=1e-4).resolve()
