"""Time-reversal haptics: plate, focus, driving signals, patterns, finger, sound and energy."""

from typing import TYPE_CHECKING

from tactometry.loading import exports

if TYPE_CHECKING:
    from .design.guide import Target as Target, Transducers as Transducers, n_held as n_held, recommend as recommend
    from .field.field import grid as grid, movie as movie
    from .field.merit import (
        area_m2 as area_m2,
        contrast_far_of as contrast_far_of,
        contrast_temporal_of as contrast_temporal_of,
        contrast_whole_of as contrast_whole_of,
        deformation_energy_j as deformation_energy_j,
        switched_power_w as switched_power_w,
        temporal_width_s as temporal_width_s,
        uniformity as uniformity,
        width_m as width_m,
    )
    from .field.sound import noise as noise
    from .filters import Band as Band, Butterworth as Butterworth, Hold as Hold, MeasuredGain as MeasuredGain
    from .finger import (
        Contactor as Contactor,
        Fingertip as Fingertip,
        LossRow as LossRow,
        amplitude_loss as amplitude_loss,
    )
    from .focusing.closed_reversal import ClosedReversal as ClosedReversal
    from .focusing.focusing import (
        Emission as Emission,
        drive as drive,
        emitted as emitted,
        focus_amplitude as focus_amplitude,
        focus_amplitudes as focus_amplitudes,
    )
    from .focusing.interpolation import interpolated as interpolated
    from .focusing.inverse_filter import inverse_filter_waveform as inverse_filter_waveform
    from .focusing.pattern import PATTERNS as PATTERNS, Pattern as Pattern, pattern_drive as pattern_drive
    from .focusing.quantiser import (
        Analogue as Analogue,
        OneBit as OneBit,
        PulseWidth as PulseWidth,
        Quantiser as Quantiser,
        SigmaDelta as SigmaDelta,
    )
    from .plate.glass import A4_SCREEN as A4_SCREEN, GLASSES as GLASSES, Glass as Glass
    from .plate.plate import Plate as Plate
    from .plate.statics import bending_stress_pa as bending_stress_pa, deflection_m as deflection_m
    from .responses.load import PlateLoad as PlateLoad, loaded_responses as loaded_responses
    from .responses.measured import aligned as aligned, inspect as inspect, read as read
    from .responses.plate_constants import (
        alpha_from_resolutions as alpha_from_resolutions,
        rigidity_ratio_from_modes as rigidity_ratio_from_modes,
        tau_estimate as tau_estimate,
    )
    from .responses.responses import (
        Responses as Responses,
        band_limited as band_limited,
        impulse_responses as impulse_responses,
        inaudible as inaudible,
        through as through,
    )
    from .screen.attenuation import Attenuation as Attenuation
    from .screen.screen import A4_PROTOTYPE as A4_PROTOTYPE, Screen as Screen
    from .screen.transducer import DiscPatch as DiscPatch, Patch as Patch, PointForce as PointForce, border as border
    from .stimulus.family import TimeReversalStimulus as TimeReversalStimulus
    from .stimulus.focus_train import FocusTrain as FocusTrain
    from .stimulus.sensation import TimeReversalSensation as TimeReversalSensation
    from .stimulus.setup import Setup as Setup

__getattr__, __dir__ = exports(__name__, __file__)
