"""What holds of an electrode under a finger as long as no effect of the slot says otherwise."""

from collections.abc import Mapping

from ...composition.effect import Stage

ASSUMES: Mapping[str, str] = {
    "body": "no resistance of body and source",
    "leakage": "a corneum without losses",
    "gap": "no air between insulator and skin",
    "area": "a contact area that no force changes",
    "mobility": "a pulp of unverified stiffness, damping and mass, where finger_dynamics does not move the skin",
    "polarity": "the same attraction at either sign of the voltage",
}

AREA_M2 = 1e-4
"""Of a contact; unverified default."""

SKIN_MOTION = Stage(
    "skin_motion",
    ("components", "contact"),
    "skin_components",
    "tactometry.stimuli.electrovibration.motion.skin_mobility:SkinMobility",
)
"""The skin moves as `SkinMobility` has it by default."""
