"""The kinds of stimuli and touches that a study can name, with target strings: nothing of a kind is imported here."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from tactometry.stimuli.electrovibration.textures.kinds import TEXTURES
from tactometry.stimuli.electrovibration.waveforms.kinds import WAVEFORMS


@dataclass(frozen=True)
class StimulusKind:
    """Target strings of a stimulus and of the model of what is felt of it, and the fields that both share.

    `stands` says that it is at one place, which a finger that slides would leave; `follows`, that only one that slides
    feels it; `reads`, that it reads a file, if it is to be played. `parts` names the kinds that a table within may
    have, by its key. `surface` is the kind of surface that a scene may have under it; empty where none may.
    """

    stimulus: str
    sensation: str
    shared: tuple[str, ...] = ()
    stands: bool = False
    follows: bool = False
    reads: bool = False
    parts: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    surface: str = "electrovibration"


ELECTROVIBRATION = "tactometry.stimuli.electrovibration.sensation:ElectrovibrationSensation"
FOCUSING = StimulusKind(
    "tactometry.stimuli.time_reversal.stimulus.focus_train:FocusTrain",
    "tactometry.stimuli.time_reversal.stimulus.sensation:TimeReversalSensation",
    ("setup",),
    stands=True,
    surface="time_reversal",
)
OWN = StimulusKind("", ELECTROVIBRATION)
"""A class of one's own, ``module:Class``."""
STIMULI: Mapping[str, StimulusKind] = {
    **{kind: StimulusKind(waveform.target, ELECTROVIBRATION) for kind, waveform in WAVEFORMS.items()},
    "wav": StimulusKind("tactometry.stimuli.electrovibration.waveforms.wav_file:WavFile", ELECTROVIBRATION, reads=True),
    "texture": StimulusKind(
        "tactometry.stimuli.electrovibration.textures.followed_texture:FollowedTexture",
        ELECTROVIBRATION,
        follows=True,
        parts={"texture": {kind: texture.target for kind, texture in TEXTURES.items()}},
    ),
    "focus": FOCUSING,
    "pattern": FOCUSING,
    "measured_focus": StimulusKind(
        FOCUSING.stimulus,
        "tactometry.stimuli.time_reversal.stimulus.sensation:FocusReading",
        FOCUSING.shared,
        stands=True,
        surface="",
    ),
    "foci": StimulusKind(
        "tactometry.stimuli.time_reversal.stimulus.placed_foci:PlacedFoci",
        "tactometry.stimuli.time_reversal.stimulus.placed_foci:FingersSensation",
        ("setup", "places"),
        stands=True,
        surface="time_reversal",
    ),
    "hybrid": StimulusKind(
        "tactometry.stimuli.hybrid:Hybrid",
        "tactometry.stimuli.hybrid:HybridSensation",
        ("setup",),
        surface="hybrid",
    ),
}
DEFAULT_SCENE = "tactometry.stimuli.scenes.default_scenes:default_scene"
_TOUCH = "tactometry.protocols.tasks.touch"
TOUCHES: Mapping[str, str] = {"press": f"{_TOUCH}:Pressing", "slide": f"{_TOUCH}:Sliding"}
