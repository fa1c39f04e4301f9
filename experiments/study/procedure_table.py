"""The procedure of a study: which ones there are, what their tables hold, what they make."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactometry.arguments.require import expect
from tactometry.config.strict import build, kind_of
from tactometry.errors import rewording
from tactometry.loading import resolve
from tactometry.protocols.procedures.practice import Practice
from tactometry.protocols.procedures.procedure import Procedure, Rule

from .procedure_kinds import PROCEDURES, ProcedureKind


def without(table: Mapping[str, Any], *keys: str) -> dict[str, Any]:
    """A table without some of its keys."""
    return {key: value for key, value in table.items() if key not in keys}


@dataclass(frozen=True)
class SharingTable:
    """What a study says of a procedure beside its own keys.

    Parameters
    ----------
    shared : bool
        Whether interleaved tracks share all that they learn but the threshold.
    """

    shared: bool = False


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
    built: Any = build(resolve(kind.table), without(table, "kind", "shared"), "procedure")
    with rewording(lambda words: f"procedure: {words}"):
        rule = kind.rule_of(built)
    shared = build(SharingTable, {"shared": table.get("shared", False)}, "procedure").shared
    able = " or ".join(name for name, other in PROCEDURES.items() if other.can_be_shared)
    told = f"true with {table['kind']}"
    expect(kind.can_be_shared or not shared, "procedure.shared", told, f"it with {able} only")
    return ReadyProcedure(rule, shared)


def practice_of(table: Mapping[str, Any]) -> Practice | None:
    """The table `practice`, built; None without one."""
    return build(Practice, table, "practice") if table else None
