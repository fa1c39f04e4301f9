"""Refusals of numbers and names outside of their domains, and finite results within."""

import numpy as np
import pytest
from corneum_closed_form import sine_voltage_v

from tactometry.errors import InvalidParameter
from tactometry.stimuli.electrovibration import (
    AmplitudeModulated,
    Bump,
    CoulombFriction,
    ElectrovibrationSensation,
    Finger,
    Grating,
    Layer,
    Noise,
    PulseTrain,
    Sine,
    Skin,
    Square,
    Stack,
    Step,
    Trapezoid,
    Triangle,
    Velvet,
    electrostatic_force_n,
    sliding,
)
from tactometry.stimuli.electrovibration.attraction.contact_area import (
    PowerLawArea,
    Print,
    TableArea,
    ellipse_area_m2,
    power_law_of_prints,
)
from tactometry.stimuli.electrovibration.attraction.force import force_form
from tactometry.stimuli.electrovibration.attraction.offset import WithOffset
from tactometry.stimuli.electrovibration.motion.dry_friction import DryFriction
from tactometry.stimuli.electrovibration.motion.friction_lag import FrictionLag, lagged_friction_n
from tactometry.stimuli.electrovibration.motion.skin_mobility import SkinMobility
from tactometry.stimuli.electrovibration.skin.relaxation import Solution
from tactometry.stimuli.electrovibration.skin.stack import DispersiveLayer
from tactometry.stimuli.electrovibration.textures.texture import Region
from tactometry.stimuli.electrovibration.waveforms.pieces import Pieces, straight
from tactometry.stimuli.electrovibration.waveforms.sampled import Sampled
from tactometry.stimuli.electrovibration.waveforms.waveform import peak_voltage_v

P0, AREA_M2 = Skin(), 1e-4
FINGER, FRICTION, LAG = Finger(), CoulombFriction(), FrictionLag()
T_S = np.linspace(0, 0.1, 101)
FORM = force_form("sc_layer", P0, AREA_M2)
SINE = Sine(frequency_hz=60.0, duration_s=0.1, ramp_s=0.0)
STEP = Step(duration_s=0.1).pieces(40.0)
SOLVED = Solution(STEP, P0.relaxations(AREA_M2))
FLAT = np.zeros(2)
LINES = {"rise_s": 0.0, "high_s": 4e-3, "fall_s": 0.0, "low_s": 4e-3}
SHORT = "expected at least one sample (5e-05 s); lengthen it, raise rate_hz or set band_limited"


def force_n(voltage_v, **changes):
    given = {"rate_hz": 1e4, "skin": P0, "area_m2": AREA_M2, "law": "sc_layer", **changes}
    return electrostatic_force_n(voltage_v, **given)


def slid(t_s=T_S, finger=FINGER, friction=FRICTION, force_n=0.5, level=40.0):
    return sliding(t_s, SINE.pieces(level), FORM, finger=finger, friction=friction, force_n=force_n)


def lagged(lag=LAG, t_s=T_S, speed_m_per_s=0.05):
    return lagged_friction_n(t_s, STEP, FORM, lag=lag, friction=FRICTION, force_n=0.5, speed_m_per_s=speed_m_per_s)


WAVEFORMS = [
    (lambda: SINE.pieces(4000.0), "stimulus.level: found 4000.0 dB re 1 V, expected at most 240 dB"),
    (lambda: peak_voltage_v(1e20, "V"), "stimulus.level: found 1e+20 V, expected at most 1e+12 V"),
    (lambda: Sine(60.0, level_unit="V").at(-1.0), "stimulus.level: found -1.0, expected a finite number, at least 0"),
    (lambda: Sine(60.0, level_unit="dB"), "Sine.level_unit: found 'dB', expected one of dB re 1 V, V"),
    (lambda: Sine(0.0), "Sine.frequency_hz: found 0.0"),
    (lambda: Sine(1e4),
     "Sine.frequency_hz: found 10000.0 Hz, expected less than half of rate_hz (10000.0 Hz); lower the frequency or"),
    (lambda: Square(1.5e4), "Square.frequency_hz: found 15000.0 Hz, expected less than half of rate_hz"),
    (lambda: Sine(60.0, 1e-6), "Sine.duration_s: found 1e-06 s, expected at least one sample at 20000.0 Hz"),
    (lambda: Sine(60.0, 1e12), "Sine.duration_s: found 1000000000000.0 s, expected at most 268435456 samples at 20000"),
    (lambda: Sine(60.0, 0.08),
     "Sine.ramp_s: found 0.05 s on and off, expected at most half of the duration of 0.08 s; shorten the ramp"),
    (lambda: AmplitudeModulated(60.0, carrier_hz=100.0),
     "AmplitudeModulated.carrier_hz: found 100.0 Hz, expected at least twice the programmed frequency (120.0 Hz);"),
    (lambda: AmplitudeModulated(60.0, carrier_hz=12e3),
     "AmplitudeModulated.carrier_hz: found 12000.0 Hz, expected less than half of rate_hz (10000.0 Hz); lower"),
    (lambda: AmplitudeModulated(240.0, carrier_hz=9_900.0),
     "AmplitudeModulated.carrier_hz + frequency_hz: found 10140.0 Hz, expected less than half of rate_hz (10000.0 Hz)"),
    (lambda: AmplitudeModulated(60.0, modulation="fulll"),
     "AmplitudeModulated.modulation: found 'fulll', expected one of square_root, full, suppressed_carrier; did you"),
    (lambda: WithOffset(SINE, 1e307), "WithOffset.ratio: found 1e+307"),
    (lambda: PulseTrain(60.0, 0.01),
     "PulseTrain.width_s: found 0.01 s, expected at most 0.00833333 s for biphasic pulses at 60.0 Hz; shorten them"),
    (lambda: PulseTrain(60.0, 1e-5), f"PulseTrain.width_s: found a pulse of 1e-05 s, {SHORT}"),
    (lambda: PulseTrain(100.0, 9.99e-3, polarity="positive"),
     f"PulseTrain.width_s (the pause after it): found a pulse of 1e-05 s, {SHORT}"),
    (lambda: Square(60.0, duty=0.999), f"Square.duty: found a pulse of 1.66667e-05 s, {SHORT}"),
    (lambda: Square(60.0, duty=1.0), "Square.duty: found 1.0, expected a number above 0 and below 1"),
    (lambda: Square(0.01, rate_hz=192_000.0, band_limited=True),
     "Square.band_limited: found 9.6e+06 harmonics below half of rate_hz, expected at most 1048576; raise"),
    (lambda: Trapezoid(**LINES | {"high_s": 1e-6}), f"Trapezoid.high_s: found a pulse of 1e-06 s, {SHORT}"),
    (lambda: Trapezoid(1e-6, 4e-3, 1e-6, 3e-6), f"Trapezoid.low_s: found a pulse of 4e-06 s, {SHORT}"),
    (lambda: Trapezoid(0, 0, 0, 0), "Trapezoid: found four durations of 0 s, expected a period longer than 0 s"),
    (lambda: Triangle(60.0).pieces(0.0),
     "ramp_s: found 0.05 s for a voltage with slopes, expected 0: a raised cosine times a slope has no exact"),
    (lambda: Step(onset_s=0.5, duration_s=0.5),
     "Step: found onset, rise and fall of 0.5 s in total, expected less than duration_s (0.5 s); lengthen the signal"),
    (lambda: Step(onset_s=0.09999, duration_s=0.1),
     "Step.duration_s: found a pulse of 1e-05 s, expected at least one sample (5e-05 s); lengthen it or raise rate_hz"),
    (lambda: Sampled((0.0, 0.0), rate_hz=10.0), "Sampled.shape: found shape (2,), expected at least two samples, not"),
    (lambda: Pieces(np.array(0.0), 1.0, FLAT[:1], FLAT[:1]), "Pieces.starts_s: found shape (), expected (1,)"),
    (lambda: Pieces(FLAT[:1], 1.0, FLAT[:1], FLAT[:1], FLAT[:1], np.ones((1, 1))),
     "Pieces.frequencies_hz: found [0.], expected numbers above 0"),
    (lambda: Pieces(np.array([0.0, 1.0]), 1.0, FLAT, FLAT),
     "Pieces.starts_s: found [0. 1.] and an end of 1.0, expected ascending times from 0"),
    (lambda: straight([0, 1], [0, 1, 2]), "straight: found shapes (2,) and (3,), expected equal lengths"),
    (lambda: straight([0, 2, 1], [0, 1, 2]),
     "straight.times_s: found 1.0 after 2.0, expected times in ascending order"),
]  # fmt: skip
SKIN = [
    (lambda: Skin(corneum_resistivity_ohm_m=1e-300), "Skin.corneum_resistivity_ohm_m: found 1e-300, expected 0 (a"),
    (lambda: P0.gain(-1.0), "Relaxations.response.frequency_hz: found -1.0, expected a finite number, at least 0"),
    (lambda: Layer(1e-6, resistivity_ohm_m=-1.0),
     "Layer.resistivity_ohm_m: found -1.0, expected 0 (a conductor) or a number from 1e-30 to 1e+30 (inf: lossless)"),
    (lambda: Stack((Layer(0.0),)), "Stack.layers: found no layer that can carry a voltage, expected a layer of"),
    (lambda: Stack((Layer(1e-6),)).relaxations(1, AREA_M2), "Stack.index: found 1, expected one of 0"),
    (lambda: Stack((Layer(1e-6),)).relaxations(-1, AREA_M2), "Stack.index: found -1, expected one of 0"),
    (lambda: DispersiveLayer(1e-4, (1.0, 1.0), (1.0, 1.0), (1.0, 1.0)),
     "DispersiveLayer.frequencies_hz: found (1.0, 1.0), expected ascending numbers"),
    (lambda: DispersiveLayer(1e-4, (1.0, 2.0), (1.0,), (1.0, 1.0)),
     "DispersiveLayer.permittivities: found [1.0], expected 2 numbers above 0, one per frequency"),
    (lambda: SOLVED.at([0.05, 0.2]), "Solution.t_s: found times from 0.05 to 0.2 s, expected 0 to the end of the"),
    (lambda: sine_voltage_v(0.0, 60.0, 1.0, Skin(body_resistance_ohm=1.0)),
     "skin: found a skin with Skin.body_resistance_ohm other than 0.0, which this formula ignores; expected 0.0, or"),
    (lambda: sine_voltage_v(0.0, 60.0, 1.0, Skin(tissue=Layer(5e-3, 1e4, 2.0))),
     "skin: found a skin with Skin.tissue other than None, which this formula ignores; expected None, or use Solution"),
]  # fmt: skip
FORCE = [
    (lambda: force_n(5.0), "electrostatic_force_n.voltage_v: found shape (), expected (..., n_samples), at least one"),
    (lambda: force_n([]), "electrostatic_force_n.voltage_v: found shape (0,), expected (..., n_samples), at least one"),
    (lambda: force_n([1e200]), "electrostatic_force_n.voltage_v[0]: found 1e+200, expected a number of at most 1e+12"),
    (lambda: force_n([1.0], law=None),
     "law: found none, expected one of parallel_plate, interface, total_thickness, sc_layer; their forces differ by a"),
    (lambda: force_n([1.0], law="total_thickness", skin=Skin(tissue=Layer(5e-3, 1e3, 5.0))),
     "law: found total_thickness with Skin.tissue other than None, which it has no term for; expected None, or the"),
    (lambda: force_n([1.0], law="parallel_plate", skin=Skin(gap_m=1e-6)),
     "law: found parallel_plate with Skin.gap_m other than 0.0, which it has no term for; expected 0.0, or the law"),
    (lambda: force_n([1.0], law="total_thickness", skin=Skin(gap_m=1e-6)),
     "law: found total_thickness with Skin.gap_m"),
    (lambda: ElectrovibrationSensation(law="sc_layers"),
     "ElectrovibrationSensation.law: found 'sc_layers', expected one of parallel_plate, interface, total_thickness,"),
    (lambda: ellipse_area_m2(-1.0, -1.0), "ellipse_area_m2.length_m: found -1.0, expected a finite number, at least 0"),
    (lambda: PowerLawArea(1e-4, 500.0).area_m2(1e3), "PowerLawArea.exponent: found a result beyond the range"),
    (lambda: TableArea((1.0,), (1e-4,)).area_m2(2.0),
     "TableArea: found a force of 2.0 N, expected at most the last of the table (1.0 N); measure further or use a"),
    (lambda: TableArea((2.0, 1.0), (1.0, 1.0)), "TableArea.forces_n: found (2.0, 1.0), expected ascending forces"),
    (lambda: TableArea((1.0,), ()), "TableArea: found 1 forces and 0 areas, expected equal numbers, at least one"),
    (lambda: power_law_of_prints([Print(1.0, 0.01, 0.01)]),
     "power_law_of_prints: found 1 prints, expected prints at two or more forces"),
]  # fmt: skip
MOTION = [
    (lambda: slid([0.1, 0.0]), "t_s: found 2 times in shape (2,), expected ascending times from 0 to 0.1 s"),
    (lambda: slid(finger=Finger(1e-20, 1e15, 0.0)), "finger: found a frequency of up to 5.03e+16 Hz"),
    (lambda: slid(friction=CoulombFriction(load_exponent=-0.1), force_n=0.0),
     "CoulombFriction.load_exponent: found -0.1 for a normal force of 0.0 N, expected a coefficient within the range"),
    (lambda: CoulombFriction(load_exponent=-20.0).coefficient_at(1e-30),
     "CoulombFriction.load_exponent: found -20.0 for a normal force of 1e-30 N, expected a coefficient within the"),
    (lambda: CoulombFriction(1e30, 10.0).modulation_n(1e50, 1e29), "CoulombFriction.modulation_n: found a result"),
    (lambda: DryFriction(0.4, 0.5), "DryFriction.static: found 0.4, expected at least the kinetic coefficient (0.5)"),
    (lambda: SkinMobility(damping_exponent=1.0).under(0.0), "SkinMobility.under.force_n: found 0.0, expected a finite"),
    (lambda: SkinMobility(damping_exponent=400.0).under(100.0),
     "SkinMobility: found an exponent of 400.0 for a normal force of 100.0 N, expected a power within the range of a"),
    (lambda: lagged(FrictionLag(0.0, 0.0, 1.1e10)), "lagged_friction_n.lag: found a cut-off of"),
    (lambda: lagged(FrictionLag(0.0, 0.0, 1e15)), "lagged_friction_n.lag: found a cut-off of"),
    (lambda: lagged(FrictionLag(0.0, 0.0, 1e9), t_s=[0.09, 0.091]),
     "lagged_friction_n.lag: found a cut-off of 1e+09 Hz with times up to 0.09"),
    (lambda: lagged(speed_m_per_s=1e8), "lagged_friction_n.lag: found a cut-off of"),
    (lambda: lagged(speed_m_per_s=1e200), "lagged_friction_n.speed_m_per_s: found 1e+200"),
]  # fmt: skip
TEXTURES = [
    (lambda: Grating(1e-3, "sinusoid"),
     "Grating.shape: found 'sinusoid', expected one of square, sinusoidal, sawtooth; did you mean 'sinusoidal'?"),
    (lambda: Grating(1e-3, duty=1.5), "Grating.duty: found 1.5, expected a number from 0 to 1"),
    (lambda: Velvet(with_pile=2.0), "Velvet.with_pile: found 2.0, expected a number from 0 to 1"),
    (lambda: Velvet().force_share_along([]),
     "Velvet.x_m: found shape (0,), expected positions (n_times,), at least one"),
    (lambda: Bump(0.0, 1e-3, height_sign=0), "Bump.height_sign: found 0, expected one of 1, -1"),
    (lambda: Region(0.03, 0.01), "Region: found 0.03 to 0.01 m with edges of 0.0 m, expected a right edge at least"),
    (lambda: Region(0.0, 1.0, 1e-320), "Region.edge_m: found 1e-320"),
    (lambda: Noise(100.0, 1000.0, 0.1, (0.0,)),
     "Noise.phases_rad: found 1, expected one for each of the 91 lines between 100.0 and 1000.0 per m (multiples of 1"),
    (lambda: Noise.drawn(1.0, 1e20, 1e9, rng=np.random.default_rng(0)),
     "Noise.high_per_m: found 1e+20 per m over 1000000000.0 m, expected at most 268435456"),
]  # fmt: skip


@pytest.mark.parametrize(("call", "message"), WAVEFORMS + SKIN + FORCE + MOTION + TEXTURES)
def test_value_outside_its_domain_is_refused(call, message: str) -> None:
    with pytest.raises(InvalidParameter) as caught:
        call()
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)


def test_the_highest_level_has_a_finite_motion() -> None:
    motion = slid(force_n=1.0, level=240.0)
    assert np.isfinite(motion.lateral_n).all()
    assert motion.lateral_n.max() > 1e15


@pytest.mark.parametrize("ratio", [1e30, -1e30])
def test_an_offset_far_above_its_waveform_is_a_constant(ratio: float) -> None:
    shifted = WithOffset(SINE, ratio)
    np.testing.assert_allclose(shifted.at(40.0).samples, np.sign(ratio) * 100, rtol=1e-12)
    np.testing.assert_allclose(shifted.pieces(40.0).at(T_S), np.sign(ratio) * 100, rtol=1e-12)


def test_a_short_pulse_may_be_band_limited() -> None:
    train = PulseTrain(frequency_hz=60.0, width_s=1e-5, band_limited=True)
    assert 0 < train.at(0.0).peak <= 1


def test_a_voltage_is_0_before_it_starts() -> None:
    assert STEP.at([-1.0, 0.0, 0.05]).tolist() == [0.0, 100.0, 100.0]
