"""Recorded levels of the built-in studies and scenes."""

import numpy as np
import pytest
from stimulus_levels import recorded, scene_outputs, study_levels

RECORDED = recorded()


def check(found, was):
    assert found.keys() == was.keys()
    for name, values in found.items():
        got, expected = np.array(values, float), np.array(was[name], float)
        largest = np.abs(expected[np.isfinite(expected)]).max(initial=0.0)
        np.testing.assert_allclose(got, expected, rtol=1e-12, atol=1e-12 * largest, err_msg=name)


@pytest.mark.parametrize("study", RECORDED["studies"])
def test_the_stimuli_of_a_built_in_study_feel_as_they_did(study):
    check(study_levels(study), RECORDED["studies"][study])


SLOW = {"hybrid-screen": pytest.mark.slow}


@pytest.mark.parametrize("scene", [pytest.param(name, marks=SLOW.get(name, ())) for name in RECORDED["scenes"]])
def test_a_built_in_scene_gives_what_it_gave(scene):
    check(scene_outputs(scene), RECORDED["scenes"][scene])
