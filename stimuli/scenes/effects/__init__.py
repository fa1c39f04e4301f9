"""Registry of the effects of scenes: kind and import path.

One line registers an effect. The order of the lines is the order in which effects act.
"""

from collections.abc import Mapping

OF_ELECTROVIBRATION: Mapping[str, str] = {
    "carrier": "tactometry.stimuli.scenes.effects.carrier:Carrier",
    "dc_offset": "tactometry.stimuli.scenes.effects.dc_offset:DcOffset",
    "texture": "tactometry.stimuli.electrovibration.textures.cosine_grating:CosineGrating",
    "body_resistance": "tactometry.stimuli.scenes.effects.body_resistance:BodyResistance",
    "skin_leakage": "tactometry.stimuli.scenes.effects.skin_leakage:SkinLeakage",
    "air_gap": "tactometry.stimuli.scenes.effects.air_gap:AirGap",
    "contact_area": "tactometry.stimuli.electrovibration.attraction.contact_area:PowerLawArea",
    "force_law": "tactometry.stimuli.scenes.effects.force_law:ForceLaw",
    "polarity": "tactometry.stimuli.electrovibration.attraction.polarity:Polarity",
    "friction": "tactometry.stimuli.electrovibration.motion.coulomb_friction:CoulombFriction",
    "dry_friction": "tactometry.stimuli.electrovibration.motion.dry_friction:DryFriction",
    "friction_lag": "tactometry.stimuli.electrovibration.motion.friction_lag:FrictionLag",
    "finger_dynamics": "tactometry.stimuli.scenes.effects.finger_dynamics:FingerDynamics",
    "skin_mobility": "tactometry.stimuli.electrovibration.motion.skin_mobility:SkinMobility",
    "weber_fraction": "tactometry.stimuli.scenes.effects.weber_fraction:WeberFraction",
    "sensitivity": "tactometry.stimuli.scenes.effects.sensitivity:Sensitivity",
    "receptors": "tactometry.stimuli.scenes.effects.receptors:Receptors",
    "summation": "tactometry.stimuli.scenes.effects.summation:Summation",
    "masking": "tactometry.stimuli.scenes.effects.masking:Masking",
}
OF_TIME_REVERSAL: Mapping[str, str] = {
    "edges": "tactometry.stimuli.scenes.effects.edges:Edges",
    "shear": "tactometry.stimuli.scenes.effects.shear:Shear",
    "attenuation": "tactometry.stimuli.time_reversal.screen.attenuation:Attenuation",
    "patches": "tactometry.stimuli.scenes.effects.patches:Patches",
    "foci": "tactometry.stimuli.scenes.effects.foci:Foci",
    "temperature_drift": "tactometry.stimuli.scenes.effects.temperature_drift:TemperatureDrift",
    "amplifier": "tactometry.stimuli.scenes.effects.amplifier:Amplifier",
    "audible_filter": "tactometry.stimuli.scenes.effects.audible_filter:AudibleFilter",
    "one_bit": "tactometry.stimuli.time_reversal.focusing.one_bit:OneBit",
    "sigma_delta": "tactometry.stimuli.time_reversal.focusing.sigma_delta:SigmaDelta",
    "pulse_width": "tactometry.stimuli.time_reversal.focusing.pulse_width:PulseWidth",
    "repetition": "tactometry.stimuli.scenes.effects.repetition:Repetition",
    "finger_load": "tactometry.stimuli.scenes.effects.finger_load:FingerLoad",
    "lift_off": "tactometry.stimuli.scenes.effects.lift_off:LiftOff",
    "movie": "tactometry.stimuli.scenes.effects.movie:Movie",
    "airborne_sound": "tactometry.stimuli.scenes.effects.airborne_sound:AirborneSound",
    "drive_energy": "tactometry.stimuli.scenes.effects.drive_energy:DriveEnergy",
    "focus_detection": "tactometry.stimuli.scenes.effects.focus_detection:FocusDetection",
    "masking": "tactometry.stimuli.scenes.effects.masking:Masking",
}
OF_HYBRID: Mapping[str, str] = {
    # effects that both sides share act after all others
    **{kind: target for kind, target in OF_TIME_REVERSAL.items() if kind not in OF_ELECTROVIBRATION},
    **OF_ELECTROVIBRATION,
    "cross_masking": "tactometry.stimuli.scenes.effects.cross_masking:CrossMasking",
}
EFFECTS: Mapping[str, str] = {**OF_ELECTROVIBRATION, **OF_TIME_REVERSAL, **OF_HYBRID}
