"""Electrovibration: a voltage on a screen, the attraction and the friction that it causes under a finger."""

from tactometry.stimuli.electrovibration.amplitude_modulated import AmplitudeModulated
from tactometry.stimuli.electrovibration.contact_area import ContactArea, PowerLawArea, ellipse_area_m2
from tactometry.stimuli.electrovibration.force import LAWS, Law, electrostatic_force_n
from tactometry.stimuli.electrovibration.friction import CoulombFriction, FrictionLag
from tactometry.stimuli.electrovibration.level import level_db_re_1v, peak_voltage_v
from tactometry.stimuli.electrovibration.relaxation import Relaxations
from tactometry.stimuli.electrovibration.sensation import ElectrovibrationSensation
from tactometry.stimuli.electrovibration.sine import Sine
from tactometry.stimuli.electrovibration.skin import Skin

__all__ = [
    "LAWS",
    "AmplitudeModulated",
    "ContactArea",
    "CoulombFriction",
    "ElectrovibrationSensation",
    "FrictionLag",
    "Law",
    "PowerLawArea",
    "Relaxations",
    "Sine",
    "Skin",
    "electrostatic_force_n",
    "ellipse_area_m2",
    "level_db_re_1v",
    "peak_voltage_v",
]
