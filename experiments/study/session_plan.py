"""Parts of a session, by study, participant number, session and seed.

Each random stream depends on participant, session and purpose, but never on earlier draws.
"""

import itertools
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactometry.arguments.require import expect
from tactometry.protocols import Block, Condition, Track, order
from tactometry.protocols.order import Crossing, combinations
from tactometry.protocols.procedures.practice import Practice
from tactometry.protocols.session import Inquiry, Part
from tactometry.protocols.tasks.task import Alternative, Place
from tactometry.questionnaire import ChoiceForm, Questionnaire
from tactometry.signal import Stimulus
from tactometry.trials.cells import cell as cell_text

from .cells import WiredCell
from .study import Levels, Study
from .task_table import TaskTable

Factors = Mapping[str, float | str]
Key = tuple[tuple[str, float | str], ...]


def key_of(factors: Factors) -> Key:
    """Return the key of a cell."""
    return tuple(sorted(factors.items()))


def nested_levels(study: Study) -> dict[str, dict[float | str, dict[str, Levels]]]:
    """Return nested levels by level, instead of by its text in the file."""
    return {
        factor: {level: by_name[cell_text(level)] for level in study.factors[factor] if cell_text(level) in by_name}
        for factor, by_name in study.nested.items()
    }


def crossing_of(study: Study, over: str | None, factors: Mapping[str, Sequence[float | str]]) -> Crossing[float | str]:
    """Return the crossing of factors. Factors of sessions vary slowest."""
    plan = study.plan
    slow = [*plan.between, *plan.sessions, *study.counterbalance]
    rest = [name for name in factors if name not in plan.interleave]
    names = [name for name in dict.fromkeys([*slow, *rest, *plan.interleave]) if name != over]
    rules = {**dict.fromkeys(study.counterbalance, "williams"), **plan.rules}
    return Crossing({name: factors[name] for name in names}, rules, nested_levels(study))


def session_cells(
    study: Study, over: str | None, number: int, n_session: int, seed: int
) -> list[dict[str, float | str]]:
    """Return the ordered cells of a session, without the factor `over`.

    Raises `InvalidParameter` if the number is below 1, or the study has no such session.
    """
    expect(number >= 1, "participant number", number, "a number from 1; state --number")
    sessions = all_sessions(study, over, number, seed)
    if not study.plan.sessions:
        return sessions[0]  # all sessions are the same
    expect(n_session <= len(sessions), "--session", n_session, f"from 1 to {len(sessions)}, the sessions of the plan")
    return sessions[n_session - 1]


def all_sessions(study: Study, over: str | None, number: int, seed: int) -> list[list[dict[str, float | str]]]:
    """Return the cells of each distinct session of a participant."""
    plan = study.plan
    groups = combinations({name: study.factors[name] for name in plan.between})
    # Participants are assigned to groups in turn, and within a group to the rows of its orders.
    row, group = divmod(number - 1, len(groups))
    factors = {**study.factors, **{name: (level,) for name, level in groups[group].items()}}
    cells = crossing_of(study, over, factors).cells(row, stream(seed, "order", number))
    # Factors of sessions vary slowest, so the cells of one session are consecutive.
    by_session = itertools.groupby(cells, lambda cell: [cell[name] for name in plan.sessions])
    return [list(of_session) for _, of_session in by_session]


@dataclass(frozen=True)
class SessionPlan:
    """Plan of a study's sessions, from its cells and its forms by inquiry."""

    study: Study
    table: TaskTable
    cells: Mapping[Key, WiredCell]
    practice: Practice | None
    forms: Mapping[str, Questionnaire | ChoiceForm]

    def parts(self, number: int, rng: np.random.Generator, n_session: int = 1, seed: int = 0) -> tuple[Part, ...]:
        """Return practice, blocks and questionnaires of a session, in order.

        `rng` draws the orders within blocks.
        """
        factors = session_cells(self.study, self.table.over, number, n_session, seed)
        blocks = [self._block(list(group), rng) for _, group in itertools.groupby(factors, self._slow)]
        parts: list[Part] = [*self._inquiries("start", {}), *self._practice(blocks[0])]
        for block in blocks:
            parts += [block, *self._inquiries("block", block.factors)]
        return (*parts, *self._inquiries("session", {}))

    def _slow(self, factors: Factors) -> list[float | str]:
        return [level for name, level in factors.items() if name not in self.study.plan.interleave]

    def _inquiries(self, after: str, condition: Factors) -> Iterator[Inquiry]:
        empty = dict.fromkeys(self.study.factors, "")
        for name, table in self.study.inquiries.items():
            if table.after == after:
                order = {"first": after == "start", "of_block": after == "block"}
                yield Inquiry(self.forms[name], table.shuffled, empty, condition, **order)

    def _practice(self, first: Block) -> list[Block]:
        """Return the practice: one track of the first block, with feedback."""
        if self.practice is None:
            return []
        track = replace(first.tracks[0], procedure=self.practice, name=None)
        options = replace(first.options, feedback=True, rest_after=None)
        return [replace(first, tracks=(track,), options=options, practice=True)]

    def _block(self, group: Sequence[Factors], rng: np.random.Generator) -> Block:
        """Return a block of interleaved cells, with the first cell's procedure."""
        conditions = dict(named for factors in group for named in self._conditions(factors))
        procedures = self._cell(group[0]).procedure.for_tracks(list(conditions), rng)
        tracks = [
            Track(condition, procedure, name if len(conditions) > 1 else None)
            for (name, condition), procedure in zip(conditions.items(), procedures, strict=True)
        ]
        return Block(tuple(tracks), self.table.task, self.table.options)

    def _cell(self, factors: Factors) -> WiredCell:
        over = self.table.over  # alternatives share the touch and procedure of the first alternative
        full = factors if over is None else {**factors, over: self.study.factors[over][0]}
        return self.cells[key_of(full)]

    def _conditions(self, factors: Factors) -> Iterator[tuple[str, Condition]]:
        """Yield the conditions of a cell, with the names of their tracks."""
        condition, over = self._cell(factors).condition, self.table.over
        name = ", ".join(f"{key}={cell_text(factors[key])}" for key in self.study.plan.interleave)
        if over is None:
            yield name, condition
            return
        alternatives = [self._alternative(factors, over, level) for level in self.study.factors[over]]
        n_together = self.table.task_kind.n_together
        for chosen in itertools.combinations(alternatives, n_together or len(alternatives)):
            labels = " - ".join(alternative.label for alternative in chosen) if n_together else ""
            chosen_over = replace(condition, factors={**factors, over: ""}, alternatives=chosen)
            yield ", ".join(filter(None, (name, labels))), chosen_over

    def _alternative(self, factors: Factors, over: str, level: float | str) -> Alternative:
        cell = self.cells[key_of({**factors, over: level})]
        return Alternative(cell.condition.stimulus, cell_text(level), {over: level}, places_of(cell.stimulus))


def places_of(stimulus: Stimulus) -> tuple[Place, ...]:
    """Return the places at which a stimulus is presented, if it has any."""
    return getattr(stimulus, "places_made_m", ())


def all_cells(study: Study) -> list[dict[str, float | str]]:
    """Return all cells of the design, over all groups and sessions."""
    crossing = Crossing[float | str](study.factors, {}, nested_levels(study))
    cells = crossing.cells(0, np.random.default_rng(0))  # all orders are fixed, so nothing is drawn
    return [{name: cell[name] for name in study.factors} for cell in cells]


def stream(seed: int, *keys: str | int) -> np.random.Generator:
    """Return the random generator for a seed and keys.

    Equal keys give equal streams, different keys independent ones.

    >>> stream(1, "P01", 1, "protocol").integers(1000) == stream(1, "P01", 1, "protocol").integers(1000)
    np.True_
    """
    words = tuple(key if isinstance(key, int) else zlib.crc32(key.encode()) for key in keys)
    return order.stream(seed, *words)
