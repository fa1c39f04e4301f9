"""Electrovibration: a voltage on a screen, the attraction and the friction that it causes under a finger."""

from typing import TYPE_CHECKING

from tactometry.loading import exports

if TYPE_CHECKING:
    from .attraction.contact_area import (
        ContactArea,
        PowerLawArea,
        Print,
        TableArea,
        area_of_prints,
        ellipse_area_m2,
        power_law_of_prints,
    )
    from .attraction.drawn_current import (
        charge_c,
        charge_c_at,
        current_a,
        current_a_at,
    )
    from .attraction.force import (
        LAWS,
        ForceForm,
        Law,
        electrostatic_force_n,
        electrostatic_force_n_at,
        force_form,
    )
    from .attraction.offset import WithOffset
    from .attraction.periodic_force import periodic_force_n
    from .attraction.polarity import Polarity
    from .motion.finger import Finger, Motion, sliding, sliding_many
    from .motion.friction import CoulombFriction, FrictionLag, lagged_friction_n
    from .motion.stick_slip import DryFriction, StickSlip, Travel, stick_slip
    from .sensation import ElectrovibrationSensation
    from .skin.dispersive_layer import DispersiveLayer, periodic_voltages_v
    from .skin.relaxation import Relaxations
    from .skin.skin import Skin
    from .skin.solution import Solution
    from .skin.stack import Layer, Stack
    from .textures.played_texture import (
        PlayedTexture,
        PositionSensor,
        lateral_modulation_n,
        straight_path_m,
    )
    from .textures.texture import Bump, Grating, Image, Noise, Region, Texture
    from .textures.velvet import Velvet
    from .waveforms.amplitude_modulated import AmplitudeModulated
    from .waveforms.corners import Corners
    from .waveforms.level import level_db_re_1v, peak_voltage_v
    from .waveforms.pieces import Pieces, straight
    from .waveforms.pulse_train import PulseTrain
    from .waveforms.sampled import Sampled
    from .waveforms.sine import Sine
    from .waveforms.square import Square
    from .waveforms.step import Step
    from .waveforms.trapezoid import Trapezoid
    from .waveforms.triangle import Triangle

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
    "waveforms.amplitude_modulated": "AmplitudeModulated",
    "attraction.contact_area": (
        "ContactArea PowerLawArea Print TableArea area_of_prints ellipse_area_m2 power_law_of_prints"
    ),
    "waveforms.corners": "Corners",
    "skin.dispersive_layer": "DispersiveLayer periodic_voltages_v",
    "attraction.drawn_current": "charge_c charge_c_at current_a current_a_at",
    "motion.finger": "Finger Motion sliding sliding_many",
    "attraction.force": "LAWS ForceForm Law electrostatic_force_n electrostatic_force_n_at force_form",
    "motion.friction": "CoulombFriction FrictionLag lagged_friction_n",
    "waveforms.level": "level_db_re_1v peak_voltage_v",
    "attraction.offset": "WithOffset",
    "attraction.periodic_force": "periodic_force_n",
    "waveforms.pieces": "Pieces straight",
    "textures.played_texture": "PlayedTexture PositionSensor lateral_modulation_n straight_path_m",
    "attraction.polarity": "Polarity",
    "waveforms.pulse_train": "PulseTrain",
    "skin.relaxation": "Relaxations",
    "waveforms.sampled": "Sampled",
    "sensation": "ElectrovibrationSensation",
    "waveforms.sine": "Sine",
    "skin.skin": "Skin",
    "skin.solution": "Solution",
    "waveforms.square": "Square",
    "skin.stack": "Layer Stack",
    "waveforms.step": "Step",
    "motion.stick_slip": "DryFriction StickSlip Travel stick_slip",
    "textures.texture": "Bump Grating Image Noise Region Texture",
    "waveforms.trapezoid": "Trapezoid",
    "waveforms.triangle": "Triangle",
    "textures.velvet": "Velvet",
}
__getattr__, __dir__ = exports(__name__, _NAMES)
