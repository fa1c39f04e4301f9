"""Time-reversal haptics: plate, focus, drives, finger and sound."""

from typing import TYPE_CHECKING

from tactometry.loading import exports

if TYPE_CHECKING:
    from .design.guide import Target as Target
    from .filters import Band as Band
    from .fingertip import Fingertip as Fingertip
    from .focusing.focusing import drive as drive, focus_amplitude as focus_amplitude
    from .focusing.pattern import Pattern as Pattern
    from .plate.glass import A4_SCREEN as A4_SCREEN, Glass as Glass
    from .plate.plate import Plate as Plate
    from .responses.responses import Responses as Responses, impulse_responses as impulse_responses
    from .screen.screen import Screen as Screen
    from .screen.transducer import DiscPatch as DiscPatch
    from .stimulus.focus_train import FocusTrain as FocusTrain, TimeReversalStimulus as TimeReversalStimulus
    from .stimulus.sensation import TimeReversalSensation as TimeReversalSensation
    from .stimulus.setup import Setup as Setup

__getattr__, __dir__ = exports(__name__, __file__)
