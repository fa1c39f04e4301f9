"""Electrovibration: a voltage on a screen, the attraction and the friction that it causes under a finger."""

from typing import TYPE_CHECKING

from tactometry.loading import exports

if TYPE_CHECKING:
    from .attraction.contact_area import (
        ContactArea as ContactArea,
        PowerLawArea as PowerLawArea,
        Print as Print,
        TableArea as TableArea,
        area_of_prints as area_of_prints,
        ellipse_area_m2 as ellipse_area_m2,
        power_law_of_prints as power_law_of_prints,
    )
    from .attraction.force import (
        LAWS as LAWS,
        ForceForm as ForceForm,
        Law as Law,
        electrostatic_force_n as electrostatic_force_n,
        electrostatic_force_n_at as electrostatic_force_n_at,
        force_form as force_form,
    )
    from .attraction.offset import WithOffset as WithOffset
    from .attraction.polarity import Polarity as Polarity
    from .motion.coulomb_friction import CoulombFriction as CoulombFriction
    from .motion.dry_friction import DryFriction as DryFriction
    from .motion.finger import Motion as Motion, sliding as sliding
    from .motion.friction_lag import FrictionLag as FrictionLag, lagged_friction_n as lagged_friction_n
    from .motion.pad import Finger as Finger
    from .motion.skin_mobility import SkinMobility as SkinMobility
    from .motion.stick_slip import (
        StickSlip as StickSlip,
        Travel as Travel,
        stick_slip as stick_slip,
    )
    from .sensation import ElectrovibrationSensation as ElectrovibrationSensation
    from .skin.relaxation import Relaxations as Relaxations, Solution as Solution
    from .skin.skin import Skin as Skin
    from .skin.stack import (
        DispersiveLayer as DispersiveLayer,
        Layer as Layer,
        Stack as Stack,
    )
    from .textures.followed_texture import FollowedTexture as FollowedTexture
    from .textures.maps import GreyImage as GreyImage, HeightMap as HeightMap
    from .textures.texture import (
        Bump as Bump,
        Grating as Grating,
        Noise as Noise,
        Region as Region,
        Texture as Texture,
        Velvet as Velvet,
    )
    from .waveforms.amplitude_modulated import AmplitudeModulated as AmplitudeModulated
    from .waveforms.periodic import (
        PulseTrain as PulseTrain,
        Square as Square,
        Trapezoid as Trapezoid,
        Triangle as Triangle,
    )
    from .waveforms.pieces import Corners as Corners, Pieces as Pieces, straight as straight
    from .waveforms.sampled import Sampled as Sampled
    from .waveforms.sine import Sine as Sine
    from .waveforms.step import Step as Step
    from .waveforms.waveform import level_db_re_1v as level_db_re_1v, peak_voltage_v as peak_voltage_v

__getattr__, __dir__ = exports(__name__, __file__)
