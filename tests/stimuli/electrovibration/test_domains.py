"""Refusals of out-of-domain input, and finite results within it."""

import numpy as np
import pytest
from corneum_closed_form import sine_voltage_v, square_edge_v, step_voltage_v

from tactometry.errors import InvalidParameter
from tactometry.stimuli.electrovibration import (
    AmplitudeModulated,
    Bump,
    CoulombFriction,
    Grating,
    GreyImage,
    Layer,
    Noise,
    PulseTrain,
    Sine,
    Skin,
    Square,
    Stack,
    Step,
    electrostatic_force_n,
)
from tactometry.stimuli.electrovibration.attraction.contact_area import ellipse_area_m2
from tactometry.stimuli.electrovibration.skin.relaxation import Solution
from tactometry.stimuli.electrovibration.textures.texture import Region

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


@pytest.mark.parametrize(
    "texture", [Grating(1e-3), Region(0.0, 1.0), Bump(0.0, 1.0), NOISE, GreyImage(1e-3, (1.0, 1.0, 1.0))]
)
def test_texture_refuses_non_finite_position(texture) -> None:
    with pytest.raises(InvalidParameter, match=r"x_m: found nan, expected a finite number"):
        texture.force_share(np.nan)


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
