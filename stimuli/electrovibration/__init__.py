"""Electrovibration: voltage, attraction and friction under a finger."""

from typing import TYPE_CHECKING

from tactometry.loading import exports

if TYPE_CHECKING:
    from .attraction.force import electrostatic_force_n as electrostatic_force_n
    from .motion.coulomb_friction import CoulombFriction as CoulombFriction
    from .motion.finger import sliding as sliding
    from .motion.pad import Finger as Finger
    from .motion.stick_slip import StickSlip as StickSlip, stick_slip as stick_slip
    from .sensation import ElectrovibrationSensation as ElectrovibrationSensation
    from .skin.skin import Skin as Skin
    from .skin.stack import Layer as Layer, Stack as Stack
    from .textures.maps import GreyImage as GreyImage, HeightMap as HeightMap
    from .textures.texture import Bump as Bump, Grating as Grating, Noise as Noise, Velvet as Velvet
    from .waveforms.amplitude_modulated import AmplitudeModulated as AmplitudeModulated
    from .waveforms.periodic import (
        PulseTrain as PulseTrain,
        Square as Square,
        Trapezoid as Trapezoid,
        Triangle as Triangle,
    )
    from .waveforms.sine import Sine as Sine
    from .waveforms.step import Step as Step

__getattr__, __dir__ = exports(__name__, __file__)
