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

GUESS_RATE_TOLERANCE = 0.05
HIGHEST_FALSE_ALARMS = 0.3
"""Of the guess rates of a rule, against those of its task (unverified defaults)."""
SAYS_YES = ("yes_no", "comparison")
"""Tasks whose guess rate is a rate of false alarms."""


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


def check_guess_rates(procedure: Mapping[str, Any], task: Mapping[str, Any]) -> None:
    """Refuse a rule that looks for its levels on a function with another guess rate than the task has.

    Raises
    ------
    InvalidParameter
        If no rate is within `GUESS_RATE_TOLERANCE` of chance in a forced choice, or all are above
        `HIGHEST_FALSE_ALARMS` where participants say yes or no.
    """
    kind = kind_of(procedure, "procedure", PROCEDURES)
    fields = resolve(kind.table).__dataclass_fields__
    name = next((name for name in ("guess_rates", "guess_rate") if name in fields), None)
    if name is None:
        return
    stated = procedure.get(name, fields[name].default)
    rates = stated if isinstance(stated, list | tuple) else (stated,)
    found = f"{', '.join(f'{rate:g}' for rate in rates)}{'' if name in procedure else ' by default'}"
    found += f" where the task is {task.get('kind')}"
    if task.get("kind") == "forced_choice":
        chance = 1 / task.get("n_intervals", 2)
        is_near = any(abs(rate - chance) <= GUESS_RATE_TOLERANCE for rate in rates)
        expect(is_near, f"procedure.{name}", found, f"chance, {chance:.2g}")
    elif task.get("kind") in SAYS_YES:
        expect(min(rates) <= HIGHEST_FALSE_ALARMS, f"procedure.{name}", found, "the rate of false alarms, as 0.02")


def practice_of(table: Mapping[str, Any]) -> Practice | None:
    """The table `practice`, built; None without one."""
    return build(Practice, table, "practice") if table else None
