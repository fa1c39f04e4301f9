"""Refusals of numbers and names outside of their domains, and finite results within."""

import numpy as np
import pytest
from corneum_closed_form import sine_voltage_v, square_edge_v, step_voltage_v

from tactometry.errors import InvalidParameter
from tactometry.stimuli.electrovibration import (
    AmplitudeModulated,
    Bump,
    CoulombFriction,
    Finger,
    Layer,
    Noise,
    PulseTrain,
    Sine,
    Skin,
    Square,
    Stack,
    Step,
    electrostatic_force_n,
    sliding,
    stick_slip,
)
from tactometry.stimuli.electrovibration.attraction.contact_area import PowerLawArea, ellipse_area_m2
from tactometry.stimuli.electrovibration.attraction.force import force_form
from tactometry.stimuli.electrovibration.attraction.offset import WithOffset
from tactometry.stimuli.electrovibration.motion.dry_friction import DryFriction
from tactometry.stimuli.electrovibration.motion.skin_mobility import SkinMobility
from tactometry.stimuli.electrovibration.motion.stick_slip import Travel
from tactometry.stimuli.electrovibration.skin.relaxation import Solution
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
        (lambda: slid(Finger(1e-20, 1e15, 0.0)), "finger: found a frequency of up to 5.03e\\+16 Hz"),
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


P0, AREA_M2 = Skin(), 1e-4
PIECES = Step(duration_s=0.1).pieces(40.0)
SOLVED = Solution(PIECES, P0.relaxations(AREA_M2))
NOISE = Noise.drawn(100.0, 500.0, 0.1, rng=np.random.default_rng(0))


def force_n(voltage_v, **changes):
    return electrostatic_force_n(
        voltage_v, **{"rate_hz": 1e4, "skin": P0, "area_m2": AREA_M2, "law": "sc_layer", **changes}
    )


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: SOLVED.at([0.05, 0.2]),
         "Solution.t_s: found times from 0.05 to 0.2 s, expected 0 to the end of the voltage (0.1 s)"),
        (lambda: force_n(5.0),
         "electrostatic_force_n.voltage_v: found shape (), expected (..., n_samples), at least one sample"),
        (lambda: force_n([]),
         "electrostatic_force_n.voltage_v: found shape (0,), expected (..., n_samples), at least one sample"),
        (lambda: force_n([1e200]),
         "electrostatic_force_n.voltage_v[0]: found 1e+200, expected a number of at most 1e+12"),
        (lambda: force_n([1.0], area_m2=-1e-4),
         "force_form.area_m2: found -0.0001, expected a finite number, at least 0"),
        (lambda: force_n([1.0], rate_hz=0.0),
         "electrostatic_force_n.rate_hz: found 0.0, expected a finite number above 0"),
        (lambda: force_n([1.0], law=None),
         "law: found none, expected one of parallel_plate, interface, total_thickness, sc_layer; their forces "
         "differ by a factor near 1000, so name yours"),
        (lambda: force_n([1.0], law="total_thickness", skin=Skin(tissue=Layer(5e-3, 1e3, 5.0))),
         "law: found total_thickness with Skin.tissue other than None, which it has no term for; expected None, or "
         "the law interface or sc_layer"),
        (lambda: Stack((Layer(1e-6),)).relaxations(1, AREA_M2), "Stack.index: found 1, expected one of 0"),
        (lambda: Stack((Layer(1e-6),)).relaxations(-1, AREA_M2), "Stack.index: found -1, expected one of 0"),
        (lambda: step_voltage_v(-1.0, 1.0, P0), "t_s: found -1.0, expected a finite number, at least 0"),
        (lambda: sine_voltage_v(-1.0, 60.0, 1.0, P0), "t_s: found -1.0, expected a finite number, at least 0"),
        (lambda: square_edge_v(0.0, 1.0, P0), "frequency_hz: found 0.0, expected a finite number above 0"),
        (lambda: CoulombFriction(load_exponent=-20.0).coefficient_at(1e-30),
         "CoulombFriction.load_exponent: found -20.0 for a normal force of 1e-30 N, expected a coefficient within "
         "the range of a double"),
        (lambda: SkinMobility(damping_exponent=1.0).under(0.0),
         "SkinMobility.under.force_n: found 0.0, expected a finite number above 0"),
        (lambda: SkinMobility(damping_exponent=400.0).under(100.0),
         "SkinMobility: found an exponent of 400.0 for a normal force of 100.0 N, expected a power within the range of "
         "a double"),
        (lambda: Noise.drawn(100.0, 500.0, 0.0, rng=np.random.default_rng(0)),
         "Noise.length_m: found 0.0, expected a finite number above 0"),
        (lambda: PulseTrain(frequency_hz=60.0, width_s=1e-5),
         "PulseTrain.width_s: found a pulse of 1e-05 s, expected at least one sample (5e-05 s); lengthen it, raise "
         "rate_hz or set band_limited"),
        (lambda: Square(frequency_hz=60.0, duty=0.999),
         "Square.duty: found a pulse of 1.66667e-05 s, expected at least one sample (5e-05 s); lengthen it, raise "
         "rate_hz or set band_limited"),
        (lambda: AmplitudeModulated(frequency_hz=240.0, carrier_hz=9_900.0),
         "AmplitudeModulated.carrier_hz + frequency_hz: found 10140.0 Hz, expected less than half of rate_hz "
         "(10000.0 Hz); lower the frequency or raise rate_hz"),
        (lambda: Sine(frequency_hz=10**400), f"Sine.frequency_hz: found {10**59}, expected a finite number above 0"),
        (lambda: Sine(frequency_hz=True), "Sine.frequency_hz: found True, expected a finite number above 0"),
    ],
)  # fmt: skip
def test_outside_of_its_domain_it_says_so(call, message: str) -> None:
    with pytest.raises(InvalidParameter) as caught:
        call()
    assert str(caught.value) == message


def test_an_area_of_two_negative_axes_is_refused() -> None:
    with pytest.raises(
        InvalidParameter, match=r"ellipse_area_m2.length_m: found -1.0, expected a finite number, at least 0"
    ):
        ellipse_area_m2(-1.0, -1.0)


def test_a_short_pulse_may_be_band_limited() -> None:
    train = PulseTrain(frequency_hz=60.0, width_s=1e-5, band_limited=True)
    assert 0 < train.at(0.0).peak <= 1


def test_a_voltage_is_0_before_it_starts() -> None:
    assert PIECES.at([-1.0, 0.0, 0.05]).tolist() == [0.0, 100.0, 100.0]
