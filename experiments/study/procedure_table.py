"""Procedures of a study: kinds, tables and rules."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np
from annotated_types import Interval

from tactometry.arguments.constraints import constrained
from tactometry.arguments.require import expect
from tactometry.config.strict import build, check_keys, fields_of, kind_of
from tactometry.errors import rewording
from tactometry.loading import resolve
from tactometry.protocols.procedures.easy import with_easy_trials
from tactometry.protocols.procedures.practice import Practice
from tactometry.protocols.procedures.procedure import Procedure, Rule

from .kinds import PROCEDURES, ProcedureKind

GUESS_RATE_TOLERANCE = 0.05
HIGHEST_FALSE_ALARMS = 0.3
"""Largest difference of a procedure's guess rate from chance, and largest guess rate for "yes" answers (unverified
defaults)."""
SAYS_YES = {
    "yes_no": "the false-alarm rate, such as 0.02",
    "comparison": "the rate of 'more' far below the standard, such as 0.02",
}
"""Expected guess rate of tasks without a chance level."""


def without(table: Mapping[str, Any], *keys: str) -> dict[str, Any]:
    """Return a table without some of its keys."""
    return {key: value for key, value in table.items() if key not in keys}


@dataclass(frozen=True)
@constrained
class TracksTable:
    """Settings for the tracks of a procedure, alongside its own keys.

    - `shared`: Share all parameters except the threshold between interleaved tracks (QUEST+ and psi).
    - `easy_share`: Share of trials far above threshold, which reveal the lapse rate (adaptive procedures). Each group
      of round(1 / `easy_share`) trials contains one easy trial. Easy trials count as trials of the track.
    - `easy_level`: Level of easy trials, by default the highest level.
    """

    shared: bool = False
    easy_share: Annotated[float, Interval(ge=0, le=0.5)] = 0.0
    easy_level: float | None = None


@dataclass(frozen=True)
class ReadyProcedure:
    """Rule of a study, and settings for its tracks."""

    rule: Rule[Any]
    tracks: TracksTable = field(default_factory=TracksTable)

    def for_tracks(self, names: Sequence[str], rng: np.random.Generator) -> tuple[Procedure, ...]:
        """Return a procedure for each track, with separate random orders."""
        begun = self.rule.begin_together(names) if self.tracks.shared else tuple(self.rule.begin(rng) for _ in names)
        share, level = self.tracks.easy_share, self.tracks.easy_level
        if not share:
            return begun
        highest = self.rule.bounds[1]
        return tuple(with_easy_trials(each, share, highest if level is None else level, rng) for each in begun)


def rule_of(table: Mapping[str, Any]) -> ReadyProcedure:
    """Build the rule of the table `procedure`. Raises `InvalidParameter`."""
    kind: ProcedureKind = kind_of(table, "procedure", PROCEDURES)
    reader, of_tracks = resolve(kind.table), fields_of(TracksTable)
    check_keys(table, (*fields_of(reader), *of_tracks, "kind"), "procedure", read_by=reader)
    built: Any = build(reader, without(table, "kind", *of_tracks), "procedure")
    with rewording(lambda words: f"procedure: {words}"):
        rule = kind.rule_of(built)
    tracks = build(TracksTable, {key: table[key] for key in of_tracks if key in table}, "procedure")
    _check_tracks(tracks, table["kind"], rule)
    return ReadyProcedure(rule, tracks)


def _check_tracks(tracks: TracksTable, name: str, rule: Rule[Any]) -> None:
    able = " or ".join(other for other, kind in PROCEDURES.items() if kind.can_be_shared)
    may_share = PROCEDURES[name].can_be_shared or not tracks.shared
    expect(may_share, "procedure.shared", f"true with {name}", f"it only with {able}")
    share, level = tracks.easy_share, tracks.easy_level
    adaptive = "0, as its levels do not depend on the answers; add an easy level instead"
    expect(PROCEDURES[name].takes_easy_trials or not share, "procedure.easy_share", f"{share:g} with {name}", adaptive)
    expect(level is None or share > 0, "procedure.easy_level", f"{level} without easy_share", "a share of easy trials")
    low, high = rule.bounds
    within = f"a level of the procedure, from {low:g} to {high:g}"
    expect(level is None or low <= level <= high, "procedure.easy_level", f"{level}", within)


def check_guess_rates(procedure: Mapping[str, Any], task: Mapping[str, Any]) -> None:
    """Reject a rule whose guess rate contradicts that of the task.

    Raises `InvalidParameter` if no rate is within `GUESS_RATE_TOLERANCE` of chance in a forced choice, or all rates
    exceed `HIGHEST_FALSE_ALARMS` in a task without a chance level.
    """
    kind = kind_of(procedure, "procedure", PROCEDURES)
    fields = resolve(kind.table).__dataclass_fields__
    name = next((name for name in ("guess_rates", "guess_rate") if name in fields), None)
    if name is None:
        return
    stated = procedure.get(name, fields[name].default)
    rates = stated if isinstance(stated, list | tuple) else (stated,)
    found = f"{', '.join(f'{rate:g}' for rate in rates)}{'' if name in procedure else ' by default'}"
    found += f" in the task {task.get('kind')}"
    if task.get("kind") == "forced_choice":
        chance = 1 / task.get("n_intervals", 2)
        is_near = any(abs(rate - chance) <= GUESS_RATE_TOLERANCE for rate in rates)
        expect(is_near, f"procedure.{name}", found, f"chance, {chance:.2g}")
    elif task.get("kind") in SAYS_YES:
        expect(min(rates) <= HIGHEST_FALSE_ALARMS, f"procedure.{name}", found, SAYS_YES[task["kind"]])


def practice_of(table: Mapping[str, Any]) -> Practice | None:
    """Build the table `practice`, or return None without one."""
    return build(Practice, table, "practice") if table else None
