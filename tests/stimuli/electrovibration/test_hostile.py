"""Hostile values for one argument at a time of every public callable."""

from inspect import getmembers, isclass, isfunction

import numpy as np
import pytest
from corneum_closed_form import sine_voltage_v
from hostile import Call, call_of, complaints, faults, methods, valid_arguments

from tactometry.stimuli import electrovibration as ev
from tactometry.stimuli.electrovibration.attraction import contact_area
from tactometry.stimuli.electrovibration.attraction.contact_area import (
    ContactArea,
    PowerLawArea,
    Print,
    TableArea,
    area_of_prints,
    ellipse_area_m2,
    power_law_of_prints,
)
from tactometry.stimuli.electrovibration.attraction.force import electrostatic_force_n_at, force_form
from tactometry.stimuli.electrovibration.attraction.offset import WithOffset
from tactometry.stimuli.electrovibration.attraction.polarity import Polarity
from tactometry.stimuli.electrovibration.motion.dry_friction import DryFriction
from tactometry.stimuli.electrovibration.motion.finger import Motion
from tactometry.stimuli.electrovibration.motion.friction_lag import FrictionLag, lagged_friction_n
from tactometry.stimuli.electrovibration.motion.skin_mobility import SkinMobility
from tactometry.stimuli.electrovibration.motion.stick_slip import Travel
from tactometry.stimuli.electrovibration.skin import stack
from tactometry.stimuli.electrovibration.skin.relaxation import Solution
from tactometry.stimuli.electrovibration.skin.stack import DispersiveLayer
from tactometry.stimuli.electrovibration.textures.followed_texture import FollowedTexture
from tactometry.stimuli.electrovibration.textures.texture import Region, Texture
from tactometry.stimuli.electrovibration.waveforms.pieces import Corners, Pieces, straight
from tactometry.stimuli.electrovibration.waveforms.sampled import Sampled
from tactometry.stimuli.electrovibration.waveforms.waveform import level_db_re_1v, peak_voltage_v

SKIN = ev.Skin()
SINE = ev.Sine(frequency_hz=60.0, duration_s=0.1)
PIECES = SINE.pieces(40.0)
FORM = force_form("sc_layer", SKIN, 1e-4)
T_S = [0.0, 0.01, 0.05]
V = [0.0, 1.0, -2.0]
PRINTS = [Print(1.0, 0.012, 0.01), Print(2.0, 0.014, 0.011)]
SHORT = {"duration_s": 0.1, "ramp_s": 0.0, "level_unit": "V"}

STIMULI = (
    ev.AmplitudeModulated(240.0, carrier_hz=2e3, modulation="full", **SHORT),
    ev.PulseTrain(60.0, 1e-3, **SHORT),
    Sampled((0.0, 1.0, -1.0, 0.0), rate_hz=1e3, ramp_s=0.0, level_unit="V"),
    ev.Sine(60.0, phase_rad=1.0, **SHORT),
    ev.Square(60.0, **SHORT),
    ev.Step(onset_s=0.01, duration_s=0.1, level_unit="V"),
    ev.Trapezoid(1e-3, 1e-3, 1e-3, 1e-3, low_ratio=-1.0, **SHORT),
    ev.Triangle(60.0, band_limited=True, **SHORT),
    WithOffset(SINE, ratio=0.5),
)
INSTANCES = (
    *STIMULI,
    ev.Bump(0.0, 1e-3, direction=-1),
    Corners((0.0, 0.5, 0.5, 1.0), (1.0, 1.0, -1.0, -1.0)),
    ev.CoulombFriction(0.5, load_exponent=-0.1),
    DispersiveLayer(1e-4, (1.0, 2.0), (2.0, 1.0), (2.0, 1.0)),
    DryFriction(0.6, 0.5),
    ev.ElectrovibrationSensation(
        skin=SKIN, law="interface", lag=FrictionLag(), mobility=SkinMobility(), reference_force_n=1e-5,
        criterion="fraction", polarity=Polarity(0.5),
    ),
    ev.Finger(),
    FollowedTexture(ev.Grating(1e-3), duration_s=0.1, ramp_s=0.01, level_unit="V"),
    FORM,
    FrictionLag(),
    ev.Grating(1e-3, "square"),
    ev.GreyImage(1e-3, (0.0, 0.5, 1.0)),
    ev.HeightMap(1e-3, (0.0, 1e-4, 0.0)),
    ev.Layer(1e-6, 2.0, 1e6),
    ev.Noise(100.0, 120.0, 0.1, (1.0, 2.0, 3.0), exponent=-1.0),
    Polarity(0.5),
    SkinMobility(mass_kg=1e-4, stiffness_exponent=0.3, damping_exponent=0.2),
    PowerLawArea(1e-4, 0.3),
    Print(1.0, 0.01, 0.01),
    Region(0.0, 1.0, 0.1),
    FORM.relaxations,
    ev.Skin(gap_m=1e-6, body_resistance_ohm=1e3, tissue=ev.Layer(5e-3, 1e4, 2.0)),
    PIECES,
    Solution(PIECES, FORM.relaxations),
    ev.Stack((ev.Layer(200e-6, 1000.0, 2e4), ev.Layer(1e-6)), 1e3),
    TableArea((1.0, 2.0), (1e-4, 2e-4)),
    Travel(0.05, 0.1, 1e-4),
    ev.Velvet(),
)  # fmt: skip
FUNCTIONS = (
    area_of_prints, power_law_of_prints, ellipse_area_m2, ev.electrostatic_force_n, electrostatic_force_n_at,
    force_form, lagged_friction_n, level_db_re_1v, peak_voltage_v, ev.sliding, ev.stick_slip, straight, sine_voltage_v,
)  # fmt: skip
ARGUMENTS = {
    "amplitudes": PIECES.harmonics_v[:1], "area_m2": 1e-4, "before": None, "damping_n_s_per_m": 1.5, "duration_s": 0.1,
    "electrostatic_n": [1.0], "exponent": 1.0, "factor": 2.0, "finger": ev.Finger(), "force_n": 1.0, "form": FORM,
    "frequency_hz": [60.0], "friction": ev.CoulombFriction(), "high_per_m": 120.0, "index": 0, "lag": FrictionLag(),
    "law": "sc_layer", "layer_v": np.array(V), "length_m": 0.1, "level": 20.0, "low_per_m": 100.0, "n": [1, 2],
    "n_events_max": 1000, "n_highest": 5, "order": 0, "phase": np.array([0.1, 0.5]), "piece": np.array([0]),
    "pieces": PIECES, "polarity": Polarity(0.5), "positions_hz": 1e3, "prints": PRINTS, "rate_hz": 1e4,
    "rng": np.random.default_rng(0), "skin": SKIN, "speed_m_per_s": 0.05, "t_s": T_S, "times_s": [0.0, 1.0, 1.0],
    "travel": Travel(), "unit": "V", "values_v": [0.0, 1.0, 2.0], "voltage_v": V, "way": None, "width_m": [0.01],
    "x_m": np.array([0.0, 1e-4]), "y_m": np.array([0.0, 1e-4]),
}  # fmt: skip
OF_ONE_CALL = {
    "Corners.pieces.frequency_hz": 60.0, "Pieces.value_in.t_s": np.array([0.1]),
    "Pieces.sinusoids.t_s": np.array([0.1]), "Pieces.split_at.times_s": [0.01],
    "Polarity.weighted.force_n": np.array([1.0]), "Polarity.weighted.layer_v": np.array([1.0]),
    "PowerLawArea.area_m2.force_n": [1.0], "TableArea.area_m2.force_n": [1.0], "level_db_re_1v.voltage_v": 10.0,
    "Relaxations.sampled.voltage_v": np.array(V), "Solution.state_at.t_s": np.array(T_S),
    "stick_slip.friction": DryFriction(), "sine_voltage_v.voltage_v": 100.0, "sine_voltage_v.frequency_hz": 60.0,
    "ellipse_area_m2.length_m": 0.01,
}  # fmt: skip


def calls() -> dict[str, Call]:
    """Return a valid call of each constructor, method and function."""
    found = {each.__name__: call_of(each, each.__name__, ARGUMENTS, OF_ONE_CALL) for each in FUNCTIONS}
    for each in INSTANCES:
        kind = type(each).__name__
        found[kind] = Call(type(each), valid_arguments(each))
        for name in methods(type(each)):
            found[f"{kind}.{name}"] = call_of(getattr(each, name), f"{kind}.{name}", ARGUMENTS, OF_ONE_CALL)
    return found


STARTS = {"starts_s": np.array([0.0, 1.0]), "end_s": 2.0, "offsets_v": np.ones(2), "slopes_v_per_s": np.ones(2)}
WAVES = {"frequencies_hz": np.array([1.0]), "amplitudes_v": np.ones((2, 1))}
CALLS = calls() | {"Pieces": Call(Pieces, STARTS | WAVES)}
RESULTS = {Motion, ev.StickSlip}
"""What calls return; nobody makes one."""
PROTOCOLS = {ContactArea, Texture}
UNBOUNDED = {
    "cutoff_hz", "corneum_resistance_ohm", "rate_per_s", "rates_per_s",
    "resistivity_ohm_m", "corneum_resistivity_ohm_m", "tau_s",
}  # fmt: skip
"""What is infinite by definition: a conductor's corner and rate, a lossless skin's resistivity."""


@pytest.mark.parametrize("name", CALLS)
def test_hostile_value_gives_finite_result_or_one_sentence(name: str) -> None:
    function, valid = CALLS[name]
    assert list(faults(function(**valid), name, UNBOUNDED)) == []
    assert complaints(name, function, valid, UNBOUNDED, names=name != "Relaxations") == []


def test_every_public_name_is_in_the_sweep() -> None:
    public = {name for name in ev.__all__ if isclass(getattr(ev, name)) or isfunction(getattr(ev, name))}
    for module in (contact_area, stack):
        public |= {name for name, one in getmembers(module, isfunction) if one.__module__ == module.__name__}
    unswept = {"check_resistivity", *(one.__name__ for one in RESULTS | PROTOCOLS)}
    assert {name for name in public if not name.startswith("_")} - unswept <= set(CALLS)
