"""Time-reversal haptics: plate, focus, driving signals, patterns, finger, sound and energy."""

from typing import TYPE_CHECKING

from tactometry.loading import exports

if TYPE_CHECKING:
    from tactometry.stimuli.time_reversal.design.guide import Target, Transducers, n_held, recommend
    from tactometry.stimuli.time_reversal.field.energy import deformation_energy_j, switched_power_w
    from tactometry.stimuli.time_reversal.field.field import grid, movie
    from tactometry.stimuli.time_reversal.field.merit import (
        area_m2,
        contrast_far_of,
        contrast_temporal_of,
        contrast_whole_of,
        temporal_width_s,
        uniformity,
        width_m,
    )
    from tactometry.stimuli.time_reversal.field.sound import noise
    from tactometry.stimuli.time_reversal.finger.contactor import Contactor
    from tactometry.stimuli.time_reversal.finger.finger import Emission, Finger, amplitude_loss
    from tactometry.stimuli.time_reversal.finger.force_loss import LossRow
    from tactometry.stimuli.time_reversal.focusing.closed_reversal import ClosedReversal
    from tactometry.stimuli.time_reversal.focusing.focusing import drive, emitted, focus_amplitude, focus_amplitudes
    from tactometry.stimuli.time_reversal.focusing.interpolation import interpolated
    from tactometry.stimuli.time_reversal.focusing.inverse_filter import inverse_filter_waveform
    from tactometry.stimuli.time_reversal.focusing.pattern import PATTERNS, Pattern, pattern_drive
    from tactometry.stimuli.time_reversal.focusing.quantiser import Analogue, OneBit, PulseWidth, Quantiser, SigmaDelta
    from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN, GLASSES, Glass
    from tactometry.stimuli.time_reversal.plate.plate import Plate
    from tactometry.stimuli.time_reversal.plate.statics import bending_stress_pa, deflection_m
    from tactometry.stimuli.time_reversal.responses.decay import tau_estimate
    from tactometry.stimuli.time_reversal.responses.filtering import (
        Band,
        Butterworth,
        Hold,
        Measured,
        band_limited,
        inaudible,
        through,
    )
    from tactometry.stimuli.time_reversal.responses.load import Load, loaded_responses
    from tactometry.stimuli.time_reversal.responses.material_constants import (
        alpha_from_resolutions,
        rigidity_ratio_from_modes,
    )
    from tactometry.stimuli.time_reversal.responses.measured import aligned, inspect, read
    from tactometry.stimuli.time_reversal.responses.responses import Responses, impulse_responses
    from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
    from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE, Screen
    from tactometry.stimuli.time_reversal.screen.transducer import Disc, Patch, PointForce, border
    from tactometry.stimuli.time_reversal.stimulus.family import TimeReversalStimulus
    from tactometry.stimuli.time_reversal.stimulus.focus_train import FocusTrain
    from tactometry.stimuli.time_reversal.stimulus.sensation import TimeReversalSensation
    from tactometry.stimuli.time_reversal.stimulus.setup import Setup

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
