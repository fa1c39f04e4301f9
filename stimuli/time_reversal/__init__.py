"""Time-reversal haptics: plate, focus, driving signals, patterns, finger, sound and energy."""

from typing import TYPE_CHECKING

from tactometry.loading import exports

if TYPE_CHECKING:
    from .design.guide import Target, Transducers, n_held, recommend
    from .field.energy import deformation_energy_j, switched_power_w
    from .field.field import grid, movie
    from .field.merit import (
        area_m2,
        contrast_far_of,
        contrast_temporal_of,
        contrast_whole_of,
        temporal_width_s,
        uniformity,
        width_m,
    )
    from .field.sound import noise
    from .finger.contactor import Contactor
    from .finger.finger import Emission, Finger, amplitude_loss
    from .finger.force_loss import LossRow
    from .focusing.closed_reversal import ClosedReversal
    from .focusing.focusing import drive, emitted, focus_amplitude, focus_amplitudes
    from .focusing.interpolation import interpolated
    from .focusing.inverse_filter import inverse_filter_waveform
    from .focusing.pattern import PATTERNS, Pattern, pattern_drive
    from .focusing.quantiser import Analogue, OneBit, PulseWidth, Quantiser, SigmaDelta
    from .plate.glass import A4_SCREEN, GLASSES, Glass
    from .plate.plate import Plate
    from .plate.statics import bending_stress_pa, deflection_m
    from .responses.decay import tau_estimate
    from .responses.filtering import (
        Band,
        Butterworth,
        Hold,
        Measured,
        band_limited,
        inaudible,
        through,
    )
    from .responses.load import Load, loaded_responses
    from .responses.material_constants import (
        alpha_from_resolutions,
        rigidity_ratio_from_modes,
    )
    from .responses.measured import aligned, inspect, read
    from .responses.responses import Responses, impulse_responses
    from .screen.attenuation import Attenuation
    from .screen.screen import A4_PROTOTYPE, Screen
    from .screen.transducer import Disc, Patch, PointForce, border
    from .stimulus.family import TimeReversalStimulus
    from .stimulus.focus_train import FocusTrain
    from .stimulus.sensation import TimeReversalSensation
    from .stimulus.setup import Setup

__all__ = [
    "A4_PROTOTYPE",
    "A4_SCREEN",
    "GLASSES",
    "PATTERNS",
    "Analogue",
    "Attenuation",
    "Band",
    "Butterworth",
    "ClosedReversal",
    "Contactor",
    "Disc",
    "Emission",
    "Finger",
    "FocusTrain",
    "Glass",
    "Hold",
    "Load",
    "LossRow",
    "Measured",
    "OneBit",
    "Patch",
    "Pattern",
    "Plate",
    "PointForce",
    "PulseWidth",
    "Quantiser",
    "Responses",
    "Screen",
    "Setup",
    "SigmaDelta",
    "Target",
    "TimeReversalSensation",
    "TimeReversalStimulus",
    "Transducers",
    "aligned",
    "alpha_from_resolutions",
    "amplitude_loss",
    "area_m2",
    "band_limited",
    "bending_stress_pa",
    "border",
    "contrast_far_of",
    "contrast_temporal_of",
    "contrast_whole_of",
    "deflection_m",
    "deformation_energy_j",
    "drive",
    "emitted",
    "focus_amplitude",
    "focus_amplitudes",
    "grid",
    "impulse_responses",
    "inaudible",
    "inspect",
    "interpolated",
    "inverse_filter_waveform",
    "loaded_responses",
    "movie",
    "n_held",
    "noise",
    "pattern_drive",
    "read",
    "recommend",
    "rigidity_ratio_from_modes",
    "switched_power_w",
    "tau_estimate",
    "temporal_width_s",
    "through",
    "uniformity",
    "width_m",
]

_NAMES = {
    "screen.attenuation": "Attenuation",
    "focusing.closed_reversal": "ClosedReversal",
    "finger.contactor": "Contactor",
    "responses.decay": "tau_estimate",
    "design.guide": "Target Transducers n_held recommend",
    "field.energy": "deformation_energy_j switched_power_w",
    "responses.material_constants": "alpha_from_resolutions rigidity_ratio_from_modes",
    "field.field": "grid movie",
    "finger.finger": "Emission Finger amplitude_loss",
    "stimulus.focus_train": "FocusTrain",
    "focusing.focusing": "drive emitted focus_amplitude focus_amplitudes",
    "finger.force_loss": "LossRow",
    "plate.glass": "A4_SCREEN GLASSES Glass",
    "focusing.interpolation": "interpolated",
    "focusing.inverse_filter": "inverse_filter_waveform",
    "responses.load": "Load loaded_responses",
    "responses.measured": "aligned inspect read",
    "field.merit": "area_m2 contrast_far_of contrast_temporal_of contrast_whole_of temporal_width_s uniformity width_m",
    "focusing.pattern": "PATTERNS Pattern pattern_drive",
    "plate.plate": "Plate",
    "focusing.quantiser": "Analogue OneBit PulseWidth Quantiser SigmaDelta",
    "responses.responses": "Responses impulse_responses",
    "screen.screen": "A4_PROTOTYPE Screen",
    "stimulus.sensation": "TimeReversalSensation",
    "stimulus.setup": "Setup",
    "field.sound": "noise",
    "responses.filtering": "Band Butterworth Hold Measured band_limited inaudible through",
    "plate.statics": "bending_stress_pa deflection_m",
    "stimulus.family": "TimeReversalStimulus",
    "screen.transducer": "Disc Patch PointForce border",
}
__getattr__, __dir__ = exports(__name__, _NAMES)
