"""Time-reversal haptics: plate, focus, driving signals, patterns, finger, sound and energy."""

from typing import TYPE_CHECKING

from tactometry.lazy import exports

if TYPE_CHECKING:
    from tactometry.stimuli.time_reversal.attenuation import Attenuation
    from tactometry.stimuli.time_reversal.closed_reversal import ClosedReversal
    from tactometry.stimuli.time_reversal.contactor import Contactor
    from tactometry.stimuli.time_reversal.decay import tau_estimate
    from tactometry.stimuli.time_reversal.design import Target, Transducers, n_held, recommend
    from tactometry.stimuli.time_reversal.energy import deformation_energy_j, switched_power_w
    from tactometry.stimuli.time_reversal.estimation import alpha_from_resolutions, rigidity_ratio_from_modes
    from tactometry.stimuli.time_reversal.field import grid, movie
    from tactometry.stimuli.time_reversal.finger import Emission, Finger, amplitude_loss
    from tactometry.stimuli.time_reversal.focus_train import FocusTrain
    from tactometry.stimuli.time_reversal.focusing import drive, emitted, focus_amplitude, focus_amplitudes
    from tactometry.stimuli.time_reversal.force_loss import LossRow
    from tactometry.stimuli.time_reversal.glass import A4_SCREEN, GLASSES, Glass
    from tactometry.stimuli.time_reversal.interpolation import interpolated
    from tactometry.stimuli.time_reversal.inverse_filter import inverse_filter_waveform
    from tactometry.stimuli.time_reversal.load import Load, loaded_responses
    from tactometry.stimuli.time_reversal.measured import aligned, inspect, read
    from tactometry.stimuli.time_reversal.merit import (
        area_m2,
        contrast_far_of,
        contrast_temporal_of,
        contrast_whole_of,
        temporal_width_s,
        uniformity,
        width_m,
    )
    from tactometry.stimuli.time_reversal.pattern import PATTERNS, Pattern, pattern_drive
    from tactometry.stimuli.time_reversal.plate import Plate
    from tactometry.stimuli.time_reversal.quantiser import Analogue, OneBit, PulseWidth, Quantiser, SigmaDelta
    from tactometry.stimuli.time_reversal.responses import Responses, impulse_responses
    from tactometry.stimuli.time_reversal.screen import A4_PROTOTYPE, Screen
    from tactometry.stimuli.time_reversal.sensation import TimeReversalSensation
    from tactometry.stimuli.time_reversal.setup import Setup
    from tactometry.stimuli.time_reversal.sound import noise
    from tactometry.stimuli.time_reversal.spectrum import (
        Band,
        Butterworth,
        Hold,
        Measured,
        band_limited,
        inaudible,
        through,
    )
    from tactometry.stimuli.time_reversal.statics import bending_stress_pa, deflection_m
    from tactometry.stimuli.time_reversal.stimulus import TimeReversalStimulus
    from tactometry.stimuli.time_reversal.transducer import Disc, Patch, PointForce, border

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
    "attenuation": "Attenuation",
    "closed_reversal": "ClosedReversal",
    "contactor": "Contactor",
    "decay": "tau_estimate",
    "design": "Target Transducers n_held recommend",
    "energy": "deformation_energy_j switched_power_w",
    "estimation": "alpha_from_resolutions rigidity_ratio_from_modes",
    "field": "grid movie",
    "finger": "Emission Finger amplitude_loss",
    "focus_train": "FocusTrain",
    "focusing": "drive emitted focus_amplitude focus_amplitudes",
    "force_loss": "LossRow",
    "glass": "A4_SCREEN GLASSES Glass",
    "interpolation": "interpolated",
    "inverse_filter": "inverse_filter_waveform",
    "load": "Load loaded_responses",
    "measured": "aligned inspect read",
    "merit": "area_m2 contrast_far_of contrast_temporal_of contrast_whole_of temporal_width_s uniformity width_m",
    "pattern": "PATTERNS Pattern pattern_drive",
    "plate": "Plate",
    "quantiser": "Analogue OneBit PulseWidth Quantiser SigmaDelta",
    "responses": "Responses impulse_responses",
    "screen": "A4_PROTOTYPE Screen",
    "sensation": "TimeReversalSensation",
    "setup": "Setup",
    "sound": "noise",
    "spectrum": "Band Butterworth Hold Measured band_limited inaudible through",
    "statics": "bending_stress_pa deflection_m",
    "stimulus": "TimeReversalStimulus",
    "transducer": "Disc Patch PointForce border",
}
__getattr__, __dir__ = exports(__name__, _NAMES)
