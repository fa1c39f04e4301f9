"""Electrovibration: a voltage on a screen, the attraction and the friction that it causes under a finger."""

from typing import TYPE_CHECKING

from tactometry.lazy import exports

if TYPE_CHECKING:
    from tactometry.stimuli.electrovibration.amplitude_modulated import AmplitudeModulated
    from tactometry.stimuli.electrovibration.contact_area import (
        ContactArea,
        PowerLawArea,
        Print,
        TableArea,
        area_of_prints,
        ellipse_area_m2,
        power_law_of_prints,
    )
    from tactometry.stimuli.electrovibration.corners import Corners
    from tactometry.stimuli.electrovibration.dispersion import DispersiveLayer, periodic_voltages_v
    from tactometry.stimuli.electrovibration.drive import charge_c, charge_c_at, current_a, current_a_at
    from tactometry.stimuli.electrovibration.finger import Finger, Motion, sliding, sliding_many
    from tactometry.stimuli.electrovibration.force import (
        LAWS,
        ForceForm,
        Law,
        electrostatic_force_n,
        electrostatic_force_n_at,
        force_form,
    )
    from tactometry.stimuli.electrovibration.friction import CoulombFriction, FrictionLag, lagged_friction_n
    from tactometry.stimuli.electrovibration.level import level_db_re_1v, peak_voltage_v
    from tactometry.stimuli.electrovibration.offset import WithOffset
    from tactometry.stimuli.electrovibration.periodic_force import periodic_force_n
    from tactometry.stimuli.electrovibration.pieces import Pieces, straight
    from tactometry.stimuli.electrovibration.played_texture import (
        PlayedTexture,
        PositionSensor,
        lateral_modulation_n,
        straight_path_m,
    )
    from tactometry.stimuli.electrovibration.polarity import Polarity
    from tactometry.stimuli.electrovibration.pulse_train import PulseTrain
    from tactometry.stimuli.electrovibration.relaxation import Relaxations
    from tactometry.stimuli.electrovibration.sampled import Sampled
    from tactometry.stimuli.electrovibration.sensation import ElectrovibrationSensation
    from tactometry.stimuli.electrovibration.sine import Sine
    from tactometry.stimuli.electrovibration.skin import Skin
    from tactometry.stimuli.electrovibration.solution import Solution
    from tactometry.stimuli.electrovibration.square import Square
    from tactometry.stimuli.electrovibration.stack import Layer, Stack
    from tactometry.stimuli.electrovibration.step import Step
    from tactometry.stimuli.electrovibration.sticking import DryFriction, StickSlip, Travel, stick_slip
    from tactometry.stimuli.electrovibration.texture import Bump, Grating, Image, Noise, Region, Texture
    from tactometry.stimuli.electrovibration.trapezoid import Trapezoid
    from tactometry.stimuli.electrovibration.triangle import Triangle
    from tactometry.stimuli.electrovibration.velvet import Velvet

__all__ = [
    "LAWS",
    "AmplitudeModulated",
    "Bump",
    "ContactArea",
    "Corners",
    "CoulombFriction",
    "DispersiveLayer",
    "DryFriction",
    "ElectrovibrationSensation",
    "Finger",
    "ForceForm",
    "FrictionLag",
    "Grating",
    "Image",
    "Law",
    "Layer",
    "Motion",
    "Noise",
    "Pieces",
    "PlayedTexture",
    "Polarity",
    "PositionSensor",
    "PowerLawArea",
    "Print",
    "PulseTrain",
    "Region",
    "Relaxations",
    "Sampled",
    "Sine",
    "Skin",
    "Solution",
    "Square",
    "Stack",
    "Step",
    "StickSlip",
    "TableArea",
    "Texture",
    "Trapezoid",
    "Travel",
    "Triangle",
    "Velvet",
    "WithOffset",
    "area_of_prints",
    "charge_c",
    "charge_c_at",
    "current_a",
    "current_a_at",
    "electrostatic_force_n",
    "electrostatic_force_n_at",
    "ellipse_area_m2",
    "force_form",
    "lagged_friction_n",
    "lateral_modulation_n",
    "level_db_re_1v",
    "peak_voltage_v",
    "periodic_force_n",
    "periodic_voltages_v",
    "power_law_of_prints",
    "sliding",
    "sliding_many",
    "stick_slip",
    "straight",
    "straight_path_m",
]

_NAMES = {
    "amplitude_modulated": "AmplitudeModulated",
    "contact_area": "ContactArea PowerLawArea Print TableArea area_of_prints ellipse_area_m2 power_law_of_prints",
    "corners": "Corners",
    "dispersion": "DispersiveLayer periodic_voltages_v",
    "drive": "charge_c charge_c_at current_a current_a_at",
    "finger": "Finger Motion sliding sliding_many",
    "force": "LAWS ForceForm Law electrostatic_force_n electrostatic_force_n_at force_form",
    "friction": "CoulombFriction FrictionLag lagged_friction_n",
    "level": "level_db_re_1v peak_voltage_v",
    "offset": "WithOffset",
    "periodic_force": "periodic_force_n",
    "pieces": "Pieces straight",
    "played_texture": "PlayedTexture PositionSensor lateral_modulation_n straight_path_m",
    "polarity": "Polarity",
    "pulse_train": "PulseTrain",
    "relaxation": "Relaxations",
    "sampled": "Sampled",
    "sensation": "ElectrovibrationSensation",
    "sine": "Sine",
    "skin": "Skin",
    "solution": "Solution",
    "square": "Square",
    "stack": "Layer Stack",
    "step": "Step",
    "sticking": "DryFriction StickSlip Travel stick_slip",
    "texture": "Bump Grating Image Noise Region Texture",
    "trapezoid": "Trapezoid",
    "triangle": "Triangle",
    "velvet": "Velvet",
}
__getattr__, __dir__ = exports(__name__, _NAMES)
