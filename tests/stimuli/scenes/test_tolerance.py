"""Accuracy of each time-reversal effect and of quantised spectra."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from scene_cases import effect, finest_of, refusal, screen, screens, tuned
from scene_errors import LOSSY, accepted, error_of, finer, run
from soak import SOAK

OUTPUTS = {
    "foci": ("peaks_m",),
    "repetition": ("t_s", "focus_displacement_m"),
    "temperature_drift": ("t_s", "focus_displacement_m"),
    "amplifier": ("t_s", "focus_displacement_m"),
    "shear": ("t_s", "focus_displacement_m"),
}


def error_of_peaks(got, reference, output):
    return abs(got[output] - reference[output]).max() / abs(reference[output]).max()


@pytest.mark.parametrize("kind", sorted(OUTPUTS))
def test_an_effect_keeps_the_accuracy(kind):
    scene = screen(LOSSY, *tuned(kind), outputs=OUTPUTS[kind])
    error = error_of_peaks if kind == "foci" else error_of
    reference = run(finer(scene))
    for accuracy in (1e-2, 1e-3, 1e-4):
        asked = replace(scene, accuracy=accuracy)
        assert kind in {stage.effect for stage in asked.resolve().stages}
        assert error(run(asked), reference, OUTPUTS[kind][-1]) <= asked.resolve().error <= accuracy


COURSE = ("t_s", "focus_displacement_m")
QUANTISERS = (
    effect("one_bit"), effect("sigma_delta", order=1), effect("sigma_delta", order=2),
    effect("pulse_width", carrier_hz=15e3),
)  # fmt: skip


@st.composite
def quantised(draw):
    scene = draw(screens(COURSE))
    others = tuple(each for each in scene.effects if each.slot != "quantiser")
    return replace(scene, effects=(draw(st.sampled_from(QUANTISERS)), *others))


def spectrum(got, n_lines):
    """Return the first lines of the course at the focus.

    Its duration does not depend on the sampling.
    """
    course = got["focus_displacement_m"][:-1]
    return np.fft.rfft(course)[:n_lines] / course.size


@given(quantised())
@settings(max_examples=100 if SOAK else 5, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_quantised_spectrum_meets_accuracy_or_is_refused(scene):
    """Relative to its highest line."""
    finest = finest_of(scene, *((3e-5, 1e-4) if SOAK else ()), 3e-4, 9e-4)
    found = run(finest)
    n_lines = round(scene.surface.f_max_hz * (found["t_s"][-1] - found["t_s"][0]))
    reference = spectrum(found, n_lines)
    for asked in accepted(scene, (1e-1, 1e-2, 1e-3, 1e-4) if SOAK else (1e-1, 1e-2, 1e-3)):
        off = np.abs(spectrum(run(asked), n_lines) - reference).max() / np.abs(reference).max()
        assert off <= asked.accuracy + finest.accuracy


@pytest.mark.parametrize("quantiser", QUANTISERS, ids=lambda each: each.kind)
def test_quantised_drive_is_refused_at_unreachable_accuracy(quantiser):
    scene = screen(LOSSY, quantiser, outputs=COURSE, accuracy=1e-12)
    assert "error budget of" in refusal(scene)
    assert "loosen the accuracy" in refusal(scene)
