"""Hostile values for one argument at a time of every public callable.

The result is finite or an error of one clear sentence, which names an argument that is not a finite number.
"""

import warnings
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from inspect import getmembers, isclass, isfunction, signature
from types import ModuleType
from typing import Any

import corneum_closed_form as closed_form
import numpy as np
import pytest

from tactometry.errors import TactometryError
from tactometry.signal import Signal
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
from tactometry.stimuli.electrovibration.attraction.force import ForceForm, electrostatic_force_n_at, force_form
from tactometry.stimuli.electrovibration.attraction.offset import WithOffset
from tactometry.stimuli.electrovibration.attraction.polarity import Polarity
from tactometry.stimuli.electrovibration.motion.dry_friction import DryFriction
from tactometry.stimuli.electrovibration.motion.finger import Motion
from tactometry.stimuli.electrovibration.motion.friction_lag import FrictionLag, lagged_friction_n
from tactometry.stimuli.electrovibration.motion.skin_mobility import SkinMobility
from tactometry.stimuli.electrovibration.motion.stick_slip import Travel
from tactometry.stimuli.electrovibration.skin import stack
from tactometry.stimuli.electrovibration.skin.relaxation import Relaxations, Solution
from tactometry.stimuli.electrovibration.skin.stack import DispersiveLayer
from tactometry.stimuli.electrovibration.textures.followed_texture import FollowedTexture
from tactometry.stimuli.electrovibration.textures.texture import Region, Texture
from tactometry.stimuli.electrovibration.waveforms.pieces import Corners, Pieces, straight
from tactometry.stimuli.electrovibration.waveforms.sampled import Sampled
from tactometry.stimuli.electrovibration.waveforms.waveform import level_db_re_1v, peak_voltage_v

NAN, INF = float("nan"), float("inf")
HOSTILE: tuple[Any, ...] = (
    None, "text", "", NAN, INF, -INF, -1, 0, 1e-320, -1e-320, 1e-200, 1e200, 1e308, [], [NAN], [1e308, -1e308],
    [1.0, None], True, 1j, 10**400, -(10**30), {}, object(),
)  # fmt: skip

NO_NUMBERS = (None, "text", NAN, INF)
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

Call = tuple[Callable[..., Any], dict[str, Any]]

CONSTRUCTORS: dict[str, Call] = {
    "AmplitudeModulated": (ev.AmplitudeModulated, {
        "frequency_hz": 240.0, "carrier_hz": 2e3, "duration_s": 0.1, "ramp_s": 0.0, "rate_hz": 2e4,
        "modulation": "full", "level_unit": "V"}),
    "Bump": (ev.Bump, {"centre_m": 0.0, "width_m": 1e-3, "height_sign": 1, "direction": -1}),
    "Corners": (Corners, {"phases": (0.0, 0.5, 0.5, 1.0), "values": (1.0, 1.0, -1.0, -1.0)}),
    "CoulombFriction": (ev.CoulombFriction, {"coefficient": 0.5, "load_exponent": -0.1, "slip_speed_m_per_s": 1e-3}),
    "DispersiveLayer": (DispersiveLayer, {
        "thickness_m": 1e-4, "frequencies_hz": (1.0, 2.0), "permittivities": (2.0, 1.0),
        "resistivities_ohm_m": (2.0, 1.0)}),
    "DryFriction": (DryFriction, {"static": 0.6, "kinetic": 0.5, "gated": True}),
    "ElectrovibrationSensation": (ev.ElectrovibrationSensation, {
        "skin": SKIN, "law": "interface", "area": PowerLawArea(), "friction": ev.CoulombFriction(),
        "lag": FrictionLag(), "mobility": SkinMobility(), "reference_m": 1e-7, "reference_force_n": 1e-5,
        "criterion": "fraction", "polarity": Polarity(0.5)}),
    "Finger": (ev.Finger, {"mass_kg": 1e-3, "stiffness_n_per_m": 200.0, "damping_n_s_per_m": 0.05}),
    "FollowedTexture": (FollowedTexture, {
        "texture": ev.Grating(1e-3), "carrier_hz": 2e3, "duration_s": 0.1, "ramp_s": 0.01, "rate_hz": 2e4,
        "rise_s": 1e-3, "turn_m": 1e-4, "level_unit": "V"}),
    "ForceForm": (ForceForm, {"relaxations": FORM.relaxations, "newton_per_v2": 1e-5}),
    "FrictionLag": (FrictionLag, {"slope_hz_per_m_per_s": 1e4, "intercept_hz": 1.0, "floor_hz": 100.0}),
    "Grating": (ev.Grating, {"period_m": 1e-3, "shape": "square", "duty": 0.5}),
    "GreyImage": (ev.GreyImage, {
        "pixel_m": 1e-3, "values": (0.0, 0.5, 1.0), "path": None, "sha256": None, "row": 0}),
    "HeightMap": (ev.HeightMap, {
        "pixel_m": 1e-3, "values": (0.0, 1e-4, 0.0), "path": None, "sha256": None, "row": 0, "direction": 1}),
    "Layer": (ev.Layer, {"thickness_m": 1e-6, "permittivity": 2.0, "resistivity_ohm_m": 1e6}),
    "Noise": (ev.Noise, {
        "low_per_m": 100.0, "high_per_m": 120.0, "length_m": 0.1, "phases_rad": (1.0, 2.0, 3.0), "exponent": -1.0,
        "n_rms": 3.0}),
    "Pieces": (Pieces, {
        "starts_s": np.array([0.0, 1.0]), "end_s": 2.0, "offsets_v": np.ones(2), "slopes_v_per_s": np.ones(2),
        "frequencies_hz": np.array([1.0]), "amplitudes_v": np.ones((2, 1))}),
    "Polarity": (Polarity, {"positive_share": 0.5}),
    "SkinMobility": (SkinMobility, {
        "stiffness_n_per_m": 1000.0, "damping_n_s_per_m": 1.5, "mass_kg": 1e-4, "stiffness_exponent": 0.3,
        "damping_exponent": 0.2}),
    "PowerLawArea": (PowerLawArea, {"area_at_1n_m2": 1e-4, "exponent": 0.3}),
    "Print": (Print, {"force_n": 1.0, "length_m": 0.01, "width_m": 0.01}),
    "PulseTrain": (ev.PulseTrain, {
        "frequency_hz": 60.0, "width_s": 1e-3, "duration_s": 0.1, "ramp_s": 0.0, "rate_hz": 2e4,
        "polarity": "biphasic", "band_limited": False, "level_unit": "V"}),
    "Region": (Region, {"left_m": 0.0, "right_m": 1.0, "edge_m": 0.1}),
    "Relaxations": (Relaxations, {"gains": (0.5,), "rates_per_s": (100.0,), "dc_gain": 0.0}),
    "Sampled": (Sampled, {"shape": (0.0, 1.0, -1.0, 0.0), "rate_hz": 1e3, "ramp_s": 0.0, "level_unit": "V"}),
    "Sine": (ev.Sine, {
        "frequency_hz": 60.0, "duration_s": 0.1, "ramp_s": 0.0, "rate_hz": 2e4, "phase_rad": 1.0, "level_unit": "V"}),
    "Skin": (ev.Skin, {
        "insulator_thickness_m": 1e-6, "insulator_permittivity": 3.9, "corneum_thickness_m": 2e-4,
        "corneum_permittivity": 1e3, "corneum_resistivity_ohm_m": 2e4, "gap_m": 1e-6, "body_resistance_ohm": 1e3,
        "tissue": ev.Layer(5e-3, 1e4, 2.0)}),
    "Solution": (Solution, {"pieces": PIECES, "relaxations": FORM.relaxations}),
    "Square": (ev.Square, {
        "frequency_hz": 60.0, "duration_s": 0.1, "ramp_s": 0.0, "rate_hz": 2e4, "duty": 0.5, "band_limited": False,
        "level_unit": "V"}),
    "Stack": (ev.Stack, {"layers": (LEAKY, ev.Layer(1e-6)), "resistance_ohm": 1e3}),
    "Step": (ev.Step, {
        "onset_s": 0.01, "rise_s": 0.0, "fall_s": 0.0, "duration_s": 0.1, "rate_hz": 2e4, "level_unit": "V"}),
    "TableArea": (TableArea, {"forces_n": (1.0, 2.0), "areas_m2": (1e-4, 2e-4)}),
    "Trapezoid": (ev.Trapezoid, {
        "rise_s": 1e-3, "high_s": 1e-3, "fall_s": 1e-3, "low_s": 1e-3, "low_ratio": -1.0, "duration_s": 0.1,
        "ramp_s": 0.0, "rate_hz": 2e4, "band_limited": False, "level_unit": "V"}),
    "Travel": (Travel, {"speed_m_per_s": 0.05, "acceleration_m_per_s2": 0.1, "stretch_m": 1e-4}),
    "Triangle": (ev.Triangle, {
        "frequency_hz": 60.0, "duration_s": 0.1, "ramp_s": 0.0, "rate_hz": 2e4, "band_limited": True,
        "level_unit": "V"}),
    "Velvet": (ev.Velvet, {
        "with_pile": 0.3, "against_pile": 0.9, "reversal_m": 2e-3, "tuft_period_m": 1e-3, "tuft_depth": 0.3}),
    "WithOffset": (WithOffset, {"waveform": SINE, "ratio": 0.5}),
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
    "step_voltage_v": (closed_form.step_voltage_v, {"t_s": T_S, "voltage_v": 100.0, "skin": SKIN}),
    "step_impulse_n_s": (closed_form.step_impulse_n_s, {"voltage_v": 100.0, "skin": SKIN, "area_m2": AREA_M2}),
    "rise_peak_v": (closed_form.rise_peak_v, {"rise_s": T_S, "voltage_v": 100.0, "skin": SKIN}),
    "sine_voltage_v": (closed_form.sine_voltage_v, {
        "t_s": T_S, "frequency_hz": 60.0, "voltage_v": 100.0, "skin": SKIN}),
    "sine_mean_force_n": (closed_form.sine_mean_force_n, {
        "frequency_hz": [60.0], "voltage_v": 100.0, "skin": SKIN, "area_m2": AREA_M2}),
    "square_edge_v": (closed_form.square_edge_v, {"frequency_hz": [60.0], "voltage_v": 100.0, "skin": SKIN}),
    "square_mean_force_n": (closed_form.square_mean_force_n, {
        "frequency_hz": [60.0], "voltage_v": 100.0, "skin": SKIN, "area_m2": AREA_M2}),
    "square_harmonic_force_n": (closed_form.square_harmonic_force_n, {
        "n_harmonic": [1, 2], "frequency_hz": 60.0, "voltage_v": 100.0, "skin": SKIN, "area_m2": AREA_M2}),
}  # fmt: skip

STACK = CONSTRUCTORS["Stack"][0](**CONSTRUCTORS["Stack"][1])
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
for _name in ("AmplitudeModulated", "PulseTrain", "Sampled", "Sine", "Square", "Step", "Trapezoid", "Triangle",
              "WithOffset"):  # fmt: skip
    _stimulus = CONSTRUCTORS[_name][0](**CONSTRUCTORS[_name][1])
    METHODS |= {f"{_name}.{verb}": (getattr(_stimulus, verb), {"level": 20.0}) for verb in ("at", "pieces")}

CALLS = CONSTRUCTORS | FUNCTIONS | METHODS
RESULTS = {Motion, ev.StickSlip}
"""What calls return; nobody makes one."""
PROTOCOLS = {ContactArea, Texture}
UNBOUNDED = {
    "cutoff_hz", "corneum_resistance_ohm", "Skin.corneum_resistance_ohm", "rate_per_s", "rates_per_s",
    "resistivity_ohm_m", "corneum_resistivity_ohm_m", "tau_s",
}  # fmt: skip
"""What is infinite by definition: a conductor's corner and rate, a lossless skin's resistivity."""


def spoilt(value: Any, hostile: tuple[Any, ...]) -> Iterator[Any]:
    """Return hostile values for an argument and for its elements."""
    yield from hostile
    if isinstance(value, list | tuple) and value:
        yield from (type(value)((bad, *value[1:])) for bad in hostile)
    if isinstance(value, dict):
        yield from ({**value, next(iter(value)): bad} for bad in hostile)


def numbers(found: Any, where: str, depth: int = 0) -> Iterator[tuple[str, Any]]:
    """Yield every number in a result, with the name of its container."""
    if isinstance(found, int | float | complex | np.ndarray | np.generic) and not isinstance(found, np.void):
        yield where, found
    elif isinstance(found, Signal):
        yield where, found.samples
    elif isinstance(found, tuple | list):
        for one in found:
            yield from numbers(one, where, depth)
    elif is_dataclass(found) and depth < 2:
        names = [field.name for field in fields(found)]
        names += [name for name, _ in getmembers(type(found), lambda one: isinstance(one, property))]
        for name in names:
            yield from numbers(getattr(found, name), name, depth + 1)


def check_finite(found: Any, where: str) -> None:
    for name, value in numbers(found, where):
        array = np.asarray(value)
        if array.dtype.kind not in "iufcb":
            continue
        assert not np.isnan(array).any(), f"{name} is NaN"
        assert name in UNBOUNDED or np.isfinite(array).all(), f"{name} is infinite"


def check_sentence(message: str, named: str) -> None:
    assert named in message
    assert "found" in message
    assert "expected" in message
    assert "\n" not in message
    assert len(message) < 600


def complaint(name: str, call: Callable[..., Any], arguments: dict[str, Any], named: str) -> str | None:
    """Return what is wrong with the answer to hostile arguments, or None.

    A refusal contains `named`.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            check_finite(call(**arguments), name)
    except TactometryError as refusal:
        try:
            check_sentence(str(refusal), named)
        except AssertionError:
            return f"unclear: {str(refusal)[:200]}"
    except (Exception, Warning) as raw:
        return f"{type(raw).__name__}: {str(raw)[:150]}"
    return None


def complaints(name: str, call: Callable[..., Any], valid: dict[str, Any], hostile: tuple[Any, ...]) -> list[str]:
    found = []
    for argument, value in valid.items():
        for bad in spoilt(value, hostile):
            is_number = all(bad is not one for one in NO_NUMBERS)
            named = "" if is_number or name == "Relaxations" else argument
            wrong = complaint(name, call, {**valid, argument: bad}, named)
            found += [f"{name}({argument}={bad!s:.40}): {wrong}"] if wrong else []
    return found


@pytest.mark.parametrize("name", CALLS)
def test_hostile_value_gives_finite_result_or_one_sentence(name: str) -> None:
    call, valid = CALLS[name]
    check_finite(call(**valid), name)
    assert complaints(name, call, valid, HOSTILE) == []


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
    modules = [public_functions(module) for module in (closed_form, contact_area, stack)]
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
