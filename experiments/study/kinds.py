"""Kinds of procedures and stimuli. Their classes are imported when used."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from tactometry.stimuli.electrovibration.textures.kinds import TEXTURES
from tactometry.stimuli.electrovibration.waveforms.kinds import WAVEFORMS

if TYPE_CHECKING:
    from tactometry.protocols.procedures.procedure import Rule


@dataclass(frozen=True)
class ProcedureKind:
    """Kind of procedure: import target, and example with levels of 0 to 40.

    `rule` is the method that returns the rule, if the class itself is not a rule. With `can_be_shared`, tracks can
    share answers. With `takes_easy_trials`, levels depend on the answers, so easy trials can be added.
    """

    table: str
    example: Mapping[str, object]
    rule: str = ""
    can_be_shared: bool = False
    takes_easy_trials: bool = True

    def rule_of(self, table: Any) -> "Rule[Any]":
        """Return the rule of a built table. May raise further errors."""
        rule: Rule[Any] = getattr(table, self.rule)() if self.rule else table
        return rule


_LEVELS: Final = {"low": 0.0, "high": 40.0}
_RULES, _BAYESIAN = "tactometry.protocols.procedures", "tactometry.protocols.bayesian"
PROCEDURES: Mapping[str, ProcedureKind] = {
    "staircase": ProcedureKind(f"{_RULES}.staircase:Staircase", {"start": 20.0, "steps": [4.0], **_LEVELS}),
    "weighted_staircase": ProcedureKind(
        f"{_RULES}.staircase:WeightedStaircase", {"start": 20.0, "steps_up": [4.0], "steps_down": [2.0], **_LEVELS}
    ),
    "constant_stimuli": ProcedureKind(
        f"{_RULES}.constant_stimuli:ConstantStimuli",
        {"levels": [10.0, 20.0, 30.0], "repeats": 10},
        takes_easy_trials=False,
    ),
    "method_of_limits": ProcedureKind(
        f"{_RULES}.method_of_limits:MethodOfLimits", {"step": 2.0, **_LEVELS}, takes_easy_trials=False
    ),
    "quest": ProcedureKind(f"{_BAYESIAN}.quest:Quest", {"start": 20.0, "start_sd": 5.0, "step": 1.0, **_LEVELS}),
    "quest_plus": ProcedureKind(
        f"{_BAYESIAN}.settings:QuestPlusSettings",
        {"n_levels": 41, "width_low": 4.0, "width_high": 24.0, **_LEVELS},
        "procedure",
        can_be_shared=True,
    ),
    "psi": ProcedureKind(
        f"{_BAYESIAN}.settings:PsiSettings",
        {"n_levels": 41, "sd_low": 1.0, "sd_high": 8.0, **_LEVELS},
        "procedure",
        can_be_shared=True,
    ),
}
"""Kinds of procedures. To add a kind, add its file to `protocols/procedures` and an item here."""


@dataclass(frozen=True)
class StimulusKind:
    """Kind of stimulus, with import targets of stimulus and sensation model.

    `shared` lists the fields that stimulus and sensation model share. `stands` marks stimuli at one place, which a
    sliding finger would leave. `follows` marks stimuli that only a sliding finger feels. `reads` marks stimuli that
    read a file when played. `parts` maps the keys of inner tables to their allowed kinds. `surface` is the kind of
    surface in a scene for this stimulus, or empty if no scene supports it.
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
"""Custom class, ``module:Class``."""
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
