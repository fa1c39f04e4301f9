"""Hostile values for one argument at a time of every public callable."""

from collections.abc import Callable
from inspect import getmembers, isclass, isfunction, signature
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from corneum_closed_form import sine_voltage_v
from hostile import complaints, faults, valid_arguments

from tactometry.stimuli import electrovibration as ev
from tactometry.stimuli.composition.effect import Effect
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

SKIN, AREA_M2 = ev.Skin(), 1e-4
LEAKY = ev.Layer(200e-6, 1000.0, 2e4)
TABLE = stack.DispersiveLayer(200e-6, (10.0, 1000.0), (1e4, 1e2), (1e5, 1e3))
SINE = ev.Sine(frequency_hz=60.0, duration_s=0.1)
PIECES = SINE.pieces(40.0)
FORM = force_form("sc_layer", SKIN, AREA_M2)
T_S = [0.0, 0.01, 0.05]
V = [0.0, 1.0, -2.0]
PRINTS = [Print(1.0, 0.012, 0.01), Print(2.0, 0.014, 0.011)]
MOVING = {"t_s": T_S, "form": FORM, "finger": ev.Finger(), "friction": ev.CoulombFriction(), "force_n": 0.5}
SHORT = {"duration_s": 0.1, "ramp_s": 0.0, "level_unit": "V"}

Call = tuple[Callable[..., Any], dict[str, Any]]

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
    Solution(PIECES, FORM.relaxations),
    ev.Stack((LEAKY, ev.Layer(1e-6)), 1e3),
    TableArea((1.0, 2.0), (1e-4, 2e-4)),
    Travel(0.05, 0.1, 1e-4),
    ev.Velvet(),
)  # fmt: skip
CONSTRUCTORS: dict[str, Call] = {
    type(each).__name__: (type(each), valid_arguments(each)) for each in INSTANCES
} | {
    "Pieces": (Pieces, {
        "starts_s": np.array([0.0, 1.0]), "end_s": 2.0, "offsets_v": np.ones(2), "slopes_v_per_s": np.ones(2),
        "frequencies_hz": np.array([1.0]), "amplitudes_v": np.ones((2, 1))}),
}  # fmt: skip

SAMPLED = {"voltage_v": V, "rate_hz": 1e4, "skin": SKIN, "area_m2": AREA_M2}
AT = {"t_s": T_S, "pieces": PIECES, "skin": SKIN, "area_m2": AREA_M2}

FUNCTIONS: dict[str, Call] = {
    "area_of_prints": (area_of_prints, {"prints": PRINTS}),
    "power_law_of_prints": (power_law_of_prints, {"prints": PRINTS}),
    "ellipse_area_m2": (ellipse_area_m2, {"length_m": 0.01, "width_m": [0.01]}),
    "electrostatic_force_n": (ev.electrostatic_force_n, {
        **SAMPLED, "law": "sc_layer", "polarity": Polarity(0.5)}),
    "electrostatic_force_n_at": (electrostatic_force_n_at, {
        **AT, "law": "sc_layer", "polarity": Polarity(0.5)}),
    "force_form": (force_form, {"law": "interface", "skin": SKIN, "area_m2": AREA_M2}),
    "lagged_friction_n": (lagged_friction_n, {
        "t_s": T_S, "pieces": PIECES, "form": FORM, "lag": FrictionLag(), "friction": ev.CoulombFriction(),
        "force_n": 0.5, "speed_m_per_s": 0.05}),
    "level_db_re_1v": (level_db_re_1v, {"voltage_v": 10.0}),
    "peak_voltage_v": (peak_voltage_v, {"level": 10.0, "unit": "V"}),
    "sliding": (ev.sliding, {"pieces": PIECES, **MOVING}),
    "stick_slip": (ev.stick_slip, {
        "pieces": PIECES, **MOVING, "friction": DryFriction(), "travel": Travel(), "n_events_max": 1000}),
    "straight": (straight, {"times_s": [0.0, 1.0, 1.0], "values_v": [0.0, 1.0, 2.0]}),
    "sine_voltage_v": (sine_voltage_v, {"t_s": T_S, "frequency_hz": 60.0, "voltage_v": 100.0, "skin": SKIN}),
}  # fmt: skip

STACK = ev.Stack((LEAKY, ev.Layer(1e-6)), 1e3)
CORNERS = ev.Square(frequency_hz=60.0).corners
FOLLOWED = FollowedTexture(ev.Grating(1e-3), duration_s=0.1, ramp_s=0.01)

METHODS: dict[str, Call] = {
    "Corners.at": (CORNERS.at, {"phase": [0.5, 9.0]}),
    "Corners.pieces": (CORNERS.pieces, {"frequency_hz": 60.0, "duration_s": 0.1}),
    "Corners.harmonics": (CORNERS.harmonics, {"n": [1, 2]}),
    "Corners.band_limited": (CORNERS.band_limited, {"phase": np.array([0.1, 0.5]), "n_highest": 5}),
    "CoulombFriction.at_speed": (ev.CoulombFriction().at_speed, {"speed_m_per_s": 0.05}),
    "CoulombFriction.coefficient_at": (ev.CoulombFriction(0.5, -0.1).coefficient_at, {"force_n": 1.0}),
    "CoulombFriction.modulation_n": (ev.CoulombFriction().modulation_n, {"electrostatic_n": [1.0], "force_n": 1.0}),
    "DispersiveLayer.properties": (TABLE.properties, {"frequency_hz": [0.0, 60.0]}),
    "Finger.at_speed": (ev.Finger.at_speed, {"speed_m_per_s": 0.05, "damping_n_s_per_m": 1.5}),
    "ForceForm.force_n": (FORM.force_n, {"layer_v": np.array(V), "polarity": Polarity(0.5)}),
    "FrictionLag.cutoff_hz": (FrictionLag().cutoff_hz, {"speed_m_per_s": 0.05}),
    "FrictionLag.gain": (FrictionLag().gain, {"frequency_hz": [60.0], "speed_m_per_s": 0.05}),
    "FollowedTexture.at": (FOLLOWED.at, {"level": 20.0}),
    "FollowedTexture.check_motion": (FOLLOWED.check_motion, {"speed_m_per_s": 0.05, "positions_hz": 1e3}),
    "FollowedTexture.parts": (FOLLOWED.parts, {"x_m": np.array([0.0, 1e-4]), "before": None}),
    "FollowedTexture.pieces": (FOLLOWED.pieces, {"level": 20.0}),
    "GreyImage.force_share": (ev.GreyImage(1e-3, (0.0, 1.0)).force_share, {"x_m": [0.1]}),
    "HeightMap.force_share": (ev.HeightMap(1e-3, (0.0, 1.0)).force_share, {"x_m": [0.1]}),
    "SkinMobility.gain_m_per_n": (SkinMobility().gain_m_per_n, {"frequency_hz": [60.0], "force_n": 1.0}),
    "SkinMobility.under": (SkinMobility().under, {"force_n": 1.0}),
    "Velvet.after": (ev.Velvet().after, {"x_m": np.array([0.0, 1e-4]), "y_m": np.array([0.0, 1e-4]), "way": None}),
    "Grating.force_share": (ev.Grating(1e-3).force_share, {"x_m": [0.1]}),
    "Region.force_share": (Region(0.0, 1.0).force_share, {"x_m": [0.1]}),
    "Bump.force_share": (ev.Bump(0.0, 1e-3).force_share, {"x_m": [0.1]}),
    "Noise.force_share": (ev.Noise(100.0, 110.0, 0.1, (1.0, 2.0)).force_share, {"x_m": [0.1]}),
    "Noise.height": (ev.Noise(100.0, 110.0, 0.1, (1.0, 2.0)).height, {"x_m": [0.1]}),
    "Noise.drawn": (ev.Noise.drawn, {
        "low_per_m": 100.0, "high_per_m": 120.0, "length_m": 0.1, "rng": np.random.default_rng(0), "exponent": 1.0}),
    "Velvet.force_share_along": (ev.Velvet().force_share_along, {"x_m": [0.0, 0.1]}),
    "Pieces.index": (PIECES.index, {"t_s": T_S}),
    "Pieces.at": (PIECES.at, {"t_s": T_S}),
    "Pieces.value_in": (PIECES.value_in, {"piece": np.array([0]), "t_s": np.array([0.1])}),
    "Pieces.sinusoids": (PIECES.sinusoids, {"t_s": np.array([0.1]), "amplitudes": PIECES.harmonics_v[:1]}),
    "Pieces.scaled": (PIECES.scaled, {"factor": 2.0}),
    "Pieces.split_at": (PIECES.split_at, {"times_s": [0.01]}),
    "Polarity.weighted": (Polarity(0.5).weighted, {"force_n": np.array([1.0]), "layer_v": np.array([1.0])}),
    "PowerLawArea.area_m2": (PowerLawArea().area_m2, {"force_n": [1.0]}),
    "TableArea.area_m2": (TableArea((1.0,), (1e-4,)).area_m2, {"force_n": [1.0]}),
    "Relaxations.response": (FORM.relaxations.response, {"frequency_hz": [60.0]}),
    "Relaxations.sampled": (FORM.relaxations.sampled, {"voltage_v": np.array(V), "rate_hz": 1e3}),
    "Skin.insulator_capacitance_f": (SKIN.insulator_capacitance_f, {"area_m2": AREA_M2}),
    "Skin.corneum_capacitance_f": (SKIN.corneum_capacitance_f, {"area_m2": AREA_M2}),
    "Skin.corneum_resistance_ohm": (SKIN.corneum_resistance_ohm, {"area_m2": AREA_M2}),
    "Skin.response": (SKIN.response, {"frequency_hz": [60.0], "area_m2": AREA_M2}),
    "Skin.gain": (SKIN.gain, {"frequency_hz": [60.0], "area_m2": AREA_M2}),
    "Skin.relaxations": (SKIN.relaxations, {"area_m2": AREA_M2}),
    "Solution.at": (Solution(PIECES, FORM.relaxations).at, {"t_s": T_S}),
    "Solution.state_at": (Solution(PIECES, FORM.relaxations).state_at, {"order": 0, "t_s": np.array(T_S)}),
    "Stack.relaxations": (STACK.relaxations, {"index": 0, "area_m2": AREA_M2}),
    "Stack.response": (STACK.response, {"frequency_hz": [60.0], "index": 0, "area_m2": AREA_M2}),
    "WithOffset.remark": (WithOffset(SINE, 0.5).remark, {"skin": SKIN, "law": "sc_layer", "area_m2": AREA_M2}),
}  # fmt: skip
for each in STIMULI:
    METHODS |= {f"{type(each).__name__}.{verb}": (getattr(each, verb), {"level": 20.0}) for verb in ("at", "pieces")}

CALLS = CONSTRUCTORS | FUNCTIONS | METHODS
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
    call, valid = CALLS[name]
    assert list(faults(call(**valid), name, UNBOUNDED)) == []
    assert complaints(name, call, valid, UNBOUNDED, names=name != "Relaxations") == []


def public_functions(module: ModuleType) -> set[str]:
    own = (name for name, one in getmembers(module, isfunction) if one.__module__ == module.__name__)
    return {name for name in own if not name.startswith("_")}


def public_methods(cls: type) -> set[str]:
    of_scenes = dir(Effect)  # what a scene asks of an effect is no call of a user
    own = ((name, getattr(cls, name)) for name in dir(cls) if not name.startswith("_") and name not in of_scenes)
    return {
        f"{cls.__name__}.{name}"
        for name, one in own
        if (callable(one) and len(signature(one).parameters) > 1) or isinstance(cls.__dict__.get(name), classmethod)
    }


def test_every_public_callable_is_in_the_sweep() -> None:
    public = {name: getattr(ev, name) for name in ev.__all__}
    classes = {name for name, one in public.items() if isclass(one)} - {one.__name__ for one in RESULTS | PROTOCOLS}
    functions = {name for name, one in public.items() if isfunction(one)}
    modules = [public_functions(module) for module in (contact_area, stack)]
    assert classes <= set(CONSTRUCTORS)
    assert functions.union(*modules) - {"check_resistivity"} <= set(FUNCTIONS)
    assert set().union(*(public_methods(public[name]) for name in classes)) <= set(METHODS)


def test_every_argument_is_in_the_sweep() -> None:
    missing = [
        f"{name}({argument})"
        for name, (call, valid) in CALLS.items()
        for argument in set(signature(call).parameters) - set(valid)
    ]
    assert missing == []
