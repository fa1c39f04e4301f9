"""Effects, one file each, by the name that a scene file gives them."""

from collections.abc import Mapping

EFFECTS: Mapping[str, str] = {
    "carrier": "tactometry.stimuli.scenes.effects.carrier:Carrier",
    "dc_offset": "tactometry.stimuli.scenes.effects.dc_offset:DcOffset",
    "texture": "tactometry.stimuli.scenes.effects.texture:Texture",
    "polarity": "tactometry.stimuli.scenes.effects.polarity:Polarity",
    "body_resistance": "tactometry.stimuli.scenes.effects.body_resistance:BodyResistance",
    "skin_leakage": "tactometry.stimuli.scenes.effects.skin_leakage:SkinLeakage",
    "air_gap": "tactometry.stimuli.scenes.effects.air_gap:AirGap",
    "contact_area": "tactometry.stimuli.scenes.effects.contact_area:ContactArea",
    "force_law": "tactometry.stimuli.scenes.effects.force_law:ForceLaw",
    "friction": "tactometry.stimuli.scenes.effects.friction:Friction",
    "dry_friction": "tactometry.stimuli.scenes.effects.dry_friction:DryFriction",
    "friction_lag": "tactometry.stimuli.scenes.effects.friction_lag:FrictionLag",
    "finger_dynamics": "tactometry.stimuli.scenes.effects.finger_dynamics:FingerDynamics",
    "sensitivity": "tactometry.stimuli.scenes.effects.sensitivity:Sensitivity",
}
"""The kind of each effect, and where its class is; it is imported when a scene names it."""
