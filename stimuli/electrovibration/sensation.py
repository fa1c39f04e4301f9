"""Settings of the sensation of a sliding finger."""

from dataclasses import dataclass, field
from typing import Literal

from tactometry.arguments.checked import Positive, checked

from ..defaults import THRESHOLD_M
from .attraction.contact_area import ContactArea, PowerLawArea
from .attraction.force import Law
from .attraction.polarity import Polarity
from .motion.coulomb_friction import CoulombFriction
from .motion.friction_lag import FrictionLag
from .motion.skin_mobility import SkinMobility
from .skin.skin import Skin

Criterion = Literal["absolute", "fraction"]


@checked
@dataclass(frozen=True)
class ElectrovibrationSensation:
    """Settings of a scene of felt friction from electrovibration.

    Each step from the voltage to the thresholds of the receptor channels is an effect of the scene that
    `tactometry.stimuli.scenes.default_scenes.default_scene` builds. Its level is that of the component furthest above
    the lowest threshold.

    Parameters
    ----------
    skin
        Electrical model of electrode and skin.
    law
        Name of the force law: the four published laws differ by a factor near 1000.
    friction
        Friction of the finger as a function of normal force.
    area
        Contact area of the finger as a function of normal force.
    lag : FrictionLag or None
        First-order lag of friction, on by default; None leaves it out.
    mobility : SkinMobility
        How far the skin moves under the friction.
    reference_m : float
        Amplitude of the skin's displacement at the detection threshold, at 250 Hz: 0.1 um, published: 0.01 to 1 um.
        With the default values a square-root carrier of 240 Hz (1.5 N, 50 mm/s) is felt from 31 V peak.
    criterion : {"absolute", "fraction"}
        ``absolute``: `reference_m` applies at any normal force. ``fraction``: it applies at 1 N and is proportional to
        the normal force, so that a fixed fraction of the friction is detected. With areas that grow as ``F^m`` the
        voltage threshold changes with force by ``-10 m log10 F`` dB or by ``10 (1 - m) log10 F`` dB.
    reference_force_n : float, optional
        Amplitude of the friction at threshold, at 250 Hz under 1 N. It replaces `reference_m` in older study files.
    polarity : Polarity or None
        Asymmetry between positive and negative voltages. Default: None, symmetric.

    >>> ElectrovibrationSensation(law="interface").reference_m
    1e-07
    """

    skin: Skin = field(default_factory=Skin)
    law: Law = "sc_layer"
    area: ContactArea = field(default_factory=PowerLawArea)
    friction: CoulombFriction = field(default_factory=CoulombFriction)
    lag: FrictionLag | None = field(default_factory=FrictionLag)
    mobility: SkinMobility = field(default_factory=SkinMobility)
    reference_m: Positive = THRESHOLD_M
    criterion: Criterion = "absolute"
    polarity: Polarity | None = None
    reference_force_n: Positive | None = None
