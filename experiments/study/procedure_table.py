"""The procedure of a study: which ones there are, what their tables hold, what they make."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tactometry.config.strict import build
from tactometry.errors import InvalidParameter, nearest
from tactometry.protocols.bayesian.quest import Quest
from tactometry.protocols.bayesian.quest_plus import QuestPlus
from tactometry.protocols.bayesian.settings import PsiSettings, QuestPlusSettings
from tactometry.protocols.bayesian.shared_quest_plus import SharedQuestPlus
from tactometry.protocols.procedures.constant_stimuli import ConstantStimuli
from tactometry.protocols.procedures.method_of_limits import MethodOfLimits
from tactometry.protocols.procedures.practice import Practice
from tactometry.protocols.procedures.procedure import Procedure
from tactometry.protocols.procedures.staircase import Staircase
from tactometry.protocols.procedures.weighted_staircase import WeightedStaircase


@dataclass(frozen=True)
class ProcedureKind:
    """The class of a table, the fields that hold its state (which no study file sets), and what it makes."""

    table: type
    state: tuple[str, ...] = ()
    made: Callable[[Any], Procedure] = field(default=lambda table: table)


PROCEDURES: Mapping[str, ProcedureKind] = {
    "staircase": ProcedureKind(Staircase, ("levels", "responses", "reversals")),
    "weighted_staircase": ProcedureKind(WeightedStaircase, ("state",)),
    "constant_stimuli": ProcedureKind(ConstantStimuli, ("order", "n_done")),
    "method_of_limits": ProcedureKind(MethodOfLimits, ("starts", "levels", "responses", "transitions", "n_in_series")),
    "quest": ProcedureKind(Quest, ("responses", "delivered", "contradicted", "state", "grid")),
    "quest_plus": ProcedureKind(QuestPlusSettings, (), lambda table: table.procedure()),
    "psi": ProcedureKind(PsiSettings, (), lambda table: table.procedure()),
}


def kind_of(table: Mapping[str, Any], path: str, known: Mapping[str, Any]) -> Any:
    """What the key `kind` of a table names.

    Raises
    ------
    InvalidParameter
        If it is missing, or names nothing that is known.
    """
    kind = table.get("kind")
    if not isinstance(kind, str) or kind not in known:
        found = "no such key" if kind is None else repr(kind)
        raise InvalidParameter(
            f"{path}.kind: found {found}, expected one of {', '.join(known)}{nearest(str(kind), known)}"
        )
    return known[kind]


def without(table: Mapping[str, Any], *keys: str) -> dict[str, Any]:
    """A table without some of its keys."""
    return {key: value for key, value in table.items() if key not in keys}


@dataclass(frozen=True)
class ReadyProcedure:
    """A procedure before its first answer; `shared` tells whether interleaved tracks learn from each other."""

    procedure: Procedure
    shared: bool = False

    def _fresh(self, rng: np.random.Generator) -> Procedure:
        """One for a track of its own, with an order of its own where it has one."""
        procedure = self.procedure
        return procedure.shuffled(rng) if isinstance(procedure, ConstantStimuli | MethodOfLimits) else procedure

    def for_tracks(self, names: Sequence[str], rng: np.random.Generator) -> tuple[Procedure, ...]:
        """One for each track of a block."""
        if self.shared:
            assert isinstance(self.procedure, QuestPlus)
            return SharedQuestPlus(self.procedure, tuple(names)).procedures()
        return tuple(self._fresh(rng) for _ in names)

    @property
    def bounds(self) -> tuple[float, float]:
        """The lowest and the highest level that it may ask for."""
        procedure: Any = self.procedure
        if isinstance(procedure, ConstantStimuli | QuestPlus | Practice):
            return float(min(procedure.levels)), float(max(procedure.levels))
        return float(procedure.low), float(procedure.high)

    @property
    def highest(self) -> float:
        """The highest level that it may ask for."""
        return self.bounds[1]

    @property
    def n_trials_at_most(self) -> int:
        """How many answers it takes at most."""
        procedure: Any = self.procedure
        if isinstance(procedure, ConstantStimuli):
            return len(procedure.order)
        if isinstance(procedure, MethodOfLimits):
            return procedure.n_series * (procedure.n_steps + 1)
        return int(procedure.n_trials)


def rule_of(table: Mapping[str, Any]) -> ReadyProcedure:
    """The table `procedure`, built.

    Raises
    ------
    InvalidParameter
        If it holds what its kind does not know.
    """
    kind: ProcedureKind = kind_of(table, "procedure", PROCEDURES)
    built: Any = build(kind.table, without(table, "kind", "shared"), "procedure", hidden=kind.state)
    try:
        procedure = kind.made(built)
    except InvalidParameter as error:
        raise InvalidParameter(f"procedure: {error}") from None
    shared = table.get("shared", False)
    if not isinstance(shared, bool) or (shared and not isinstance(procedure, QuestPlus)):
        raise InvalidParameter(
            f"procedure.shared: found {shared!r} with {table['kind']}, expected it with quest_plus or psi only"
        )
    return ReadyProcedure(procedure, shared)


def practice_of(table: Mapping[str, Any]) -> ReadyProcedure | None:
    """The table `practice`, built; None without one."""
    return ReadyProcedure(build(Practice, table, "practice", hidden=("responses",))) if table else None
