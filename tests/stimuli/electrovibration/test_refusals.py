"""Invalid numbers and names, each refused in one sentence."""

import numpy as np
import pytest

from tactometry.errors import InvalidParameter
from tactometry.stimuli.electrovibration import (
    Bump,
    CoulombFriction,
    Finger,
    Noise,
    Sine,
    Skin,
    electrostatic_force_n,
    sliding,
    stick_slip,
)
from tactometry.stimuli.electrovibration.attraction.contact_area import PowerLawArea
from tactometry.stimuli.electrovibration.attraction.force import force_form
from tactometry.stimuli.electrovibration.attraction.offset import WithOffset
from tactometry.stimuli.electrovibration.motion.dry_friction import DryFriction
from tactometry.stimuli.electrovibration.motion.stick_slip import Travel
from tactometry.stimuli.electrovibration.textures.texture import Region
from tactometry.stimuli.electrovibration.waveforms.waveform import peak_voltage_v

T_S = np.linspace(0, 0.01, 11)
FORM = force_form("sc_layer", Skin(), 1e-4)
SINE = Sine(frequency_hz=60.0, duration_s=0.1, ramp_s=0.0)


def stuck(n_events_max):
    return stick_slip(
        T_S, SINE.pieces(40.0), FORM, finger=Finger(), friction=DryFriction(), force_n=1.0, travel=Travel(0.05),
        n_events_max=n_events_max,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: SINE.pieces(4000.0), "stimulus.level: found 4000.0 dB re 1 V, expected at most 240 dB"),
        (lambda: peak_voltage_v(1e20, "V"), "stimulus.level: found 1e\\+20 V, expected at most 1e\\+12 V"),
        (lambda: Skin(corneum_resistivity_ohm_m=1e-300), "found 1e-300, expected 0 \\(a conductor\\) or a number from"),
        (lambda: Skin(insulator_thickness_m=1e-200), "found 1e-200, expected a number from 1e-20 to 1e\\+09"),
        (lambda: stuck(-1), "n_events_max: found -1, expected a whole number"),
        (lambda: stuck(1.5), "n_events_max: found 1.5, expected a whole number"),
        (
            lambda: electrostatic_force_n(["a"], rate_hz=1e3, skin=Skin(), area_m2=1e-4, law="sc_layer"),
            r"found \['a'\], expected finite numbers",
        ),
    ],
)
def test_invalid_input_is_refused_in_one_sentence(call, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        call()


def test_the_highest_level_has_a_finite_motion():
    motion = sliding(T_S, SINE.pieces(240.0), FORM, finger=Finger(), friction=CoulombFriction(), force_n=1.0)
    assert np.isfinite(motion.lateral_n).all()
    assert motion.lateral_n.max() > 1e15


def slid(finger):
    return sliding(T_S, SINE.pieces(40.0), FORM, finger=finger, friction=CoulombFriction(), force_n=0.5)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: PowerLawArea(1e-4, 500.0).area_m2(1e3), "PowerLawArea.exponent: found a result beyond the range"),
        (lambda: Region(0.0, 1.0, 1e-320), "Region.edge_m: found 1e-320"),
        (lambda: Bump(0.0, 1e-200), "Bump.width_m: found 1e-200"),
        (lambda: Finger(mass_kg=1e-320), "Finger.mass_kg: found 1e-320"),
        (lambda: slid(Finger(1e-20, 1e15, 0.0)), "finger: found one that moves at up to 5.03e\\+16 Hz"),
        (lambda: WithOffset(SINE, 1e307), "WithOffset.ratio: found 1e\\+307"),
        (lambda: CoulombFriction(1e30, 10.0).modulation_n(1e50, 1e29), "found a result beyond the range of a double"),
        (lambda: Noise.drawn(1.0, 1e20, 1e9, rng=np.random.default_rng(0)), "expected at most 268435456 lines"),
    ],
)
def test_incompatible_arguments_are_refused(call, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        call()


@pytest.mark.parametrize("ratio", [1e30, -1e30])
def test_an_offset_far_above_its_waveform_is_a_constant(ratio):
    shifted = WithOffset(SINE, ratio)
    np.testing.assert_allclose(shifted.at(40.0).samples, np.sign(ratio) * 100, rtol=1e-12)
    np.testing.assert_allclose(shifted.pieces(40.0).at(T_S), np.sign(ratio) * 100, rtol=1e-12)
