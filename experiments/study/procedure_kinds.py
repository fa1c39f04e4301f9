"""The kinds of procedures that a study can name, with target strings: nothing of a kind is imported here."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from tactometry.protocols.procedures.procedure import Rule


@dataclass(frozen=True)
class ProcedureKind:
    """Target string of the class of a table, a table that it takes (levels from 0 to 40), its method that makes the
    rule, where it is none itself, whether tracks can learn from each other's answers, and whether levels follow the
    answers, so that easy trials can be among them."""

    table: str
    example: Mapping[str, object]
    rule: str = ""
    can_be_shared: bool = False
    takes_easy_trials: bool = True

    def rule_of(self, table: Any) -> "Rule[Any]":
        """The rule of a table that is built: some make one that refuses more than they do themselves."""
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
"""The kinds of procedures: a new one is its file in `protocols/procedures` and a line here."""
