"""Time-reversal haptics: plate, focus, driving signals, patterns, finger, sound and energy."""

from typing import TYPE_CHECKING

from tactometry.loading import exports

if TYPE_CHECKING:
    from .design.guide import Target as Target, Transducers as Transducers, n_held as n_held
    from .filters import Band as Band
    from .finger import Contactor as Contactor, amplitude_loss as amplitude_loss
    from .fingertip import Fingertip as Fingertip
    from .focusing.closed_reversal import ClosedReversal as ClosedReversal
    from .focusing.focusing import (
        Emission as Emission,
        drive as drive,
        emitted as emitted,
        focus_amplitude as focus_amplitude,
        focus_amplitudes as focus_amplitudes,
    )
    from .focusing.merit import uniformity as uniformity
    from .focusing.one_bit import OneBit as OneBit
    from .focusing.pattern import Pattern as Pattern, pattern_drive as pattern_drive
    from .focusing.pulse_width import PulseWidth as PulseWidth
    from .focusing.quantiser import Analogue as Analogue
    from .focusing.sigma_delta import SigmaDelta as SigmaDelta
    from .plate.glass import A4_SCREEN as A4_SCREEN, Glass as Glass
    from .plate.plate import Plate as Plate
    from .responses.load import PlateLoad as PlateLoad, loaded_responses as loaded_responses
    from .responses.measured import inspect as inspect
    from .responses.responses import (
        Responses as Responses,
        band_limited as band_limited,
        impulse_responses as impulse_responses,
        inaudible as inaudible,
    )
    from .screen.attenuation import Attenuation as Attenuation
    from .screen.screen import Screen as Screen
    from .screen.transducer import DiscPatch as DiscPatch, Patch as Patch, PointForce as PointForce, border as border
    from .stimulus.focus_train import FocusTrain as FocusTrain, TimeReversalStimulus as TimeReversalStimulus
    from .stimulus.sensation import TimeReversalSensation as TimeReversalSensation
    from .stimulus.setup import Setup as Setup

__getattr__, __dir__ = exports(__name__, __file__)
