"""The procedure of a study: which ones there are, what their tables hold, what they make."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from tactometry import protocols
from tactometry.arguments.require import expect
from tactometry.config.strict import build, kind_of
from tactometry.errors import rewording
from tactometry.protocols.procedures.practice import Practice
from tactometry.protocols.procedures.procedure import Procedure, Rule


@dataclass(frozen=True)
class ProcedureKind:
    """The class of a table, a table that it takes (levels from 0 to 40), the rule that it makes, and whether tracks can
    learn from each other's answers."""

    table: type
    example: Mapping[str, object]
    rule: Callable[[Any], Rule[Any]] = field(default=lambda table: table)
    can_be_shared: bool = False


_LEVELS: Final = {"low": 0.0, "high": 40.0}
PROCEDURES: Mapping[str, ProcedureKind] = {
    "staircase": ProcedureKind(protocols.Staircase, {"start": 20.0, "steps": [4.0], **_LEVELS}),
    "weighted_staircase": ProcedureKind(
        protocols.WeightedStaircase, {"start": 20.0, "steps_up": [4.0], "steps_down": [2.0], **_LEVELS}
    ),
    "constant_stimuli": ProcedureKind(protocols.ConstantStimuli, {"levels": [1.0], "repeats": 1}),
    "method_of_limits": ProcedureKind(protocols.MethodOfLimits, {"step": 2.0, **_LEVELS}),
    "quest": ProcedureKind(protocols.Quest, {"start": 20.0, "start_sd": 5.0, "step": 1.0, **_LEVELS}),
    "quest_plus": ProcedureKind(
        protocols.QuestPlusSettings,
        {"n_levels": 41, "width_low": 4.0, "width_high": 24.0, **_LEVELS},
        protocols.QuestPlusSettings.procedure,
        can_be_shared=True,
    ),
    "psi": ProcedureKind(
        protocols.PsiSettings,
        {"n_levels": 41, "sd_low": 1.0, "sd_high": 8.0, **_LEVELS},
        protocols.PsiSettings.procedure,
        can_be_shared=True,
    ),
}
"""The kinds of procedures: a new one is its file in `protocols/procedures` and a line here."""


def without(table: Mapping[str, Any], *keys: str) -> dict[str, Any]:
    """A table without some of its keys."""
    return {key: value for key, value in table.items() if key not in keys}


@dataclass(frozen=True)
class ReadyProcedure:
    """A rule as a study states it, and whether the tracks of a block learn from each other's answers."""

    rule: Rule[Any]
    shared: bool = False

    def for_tracks(self, names: Sequence[str], rng: np.random.Generator) -> tuple[Procedure, ...]:
        """One procedure for each track of a block, with an order of its own where it has one."""
        if self.shared:
            return self.rule.begin_together(names)
        return tuple(self.rule.begin(rng) for _ in names)


def rule_of(table: Mapping[str, Any]) -> ReadyProcedure:
    """The table `procedure`, built.

    Raises
    ------
    InvalidParameter
        If it holds what its kind does not know.
    """
    kind: ProcedureKind = kind_of(table, "procedure", PROCEDURES)
    built: Any = build(kind.table, without(table, "kind", "shared"), "procedure")
    with rewording(lambda words: f"procedure: {words}"):
        rule = kind.rule(built)  # some tables make a rule that refuses more than they do themselves
    shared = table.get("shared", False)
    able = " or ".join(name for name, other in PROCEDURES.items() if other.can_be_shared)
    can_be = shared is False or (shared is True and kind.can_be_shared)
    expect(can_be, "procedure.shared", f"{shared!r} with {table['kind']}", f"it with {able} only")
    return ReadyProcedure(rule, shared)


def practice_of(table: Mapping[str, Any]) -> Practice | None:
    """The table `practice`, built; None without one."""
    return build(Practice, table, "practice") if table else None
