"""A block: procedures on their conditions, alone or interleaved, until all are finished."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from tactometry.arguments.constraints import excerpt
from tactometry.arguments.require import expect, of_kind, some
from tactometry.errors import count_of
from tactometry.session.answer import Touched
from tactometry.session.intervention import Intervention
from tactometry.session.request import Intervene, Record, Show
from tactometry.session.run import Course
from tactometry.trials.tasks import EASY
from tactometry.trials.trial import Trial

from .block_state import BlockOptions, BlockState, PartCourse, Slot, Track, catch_schedule, turns
from .interventions import BETWEEN, heard, not_asked_again
from .procedures.procedure import Procedure
from .tasks.task import Presentation, Reply, Task, TrialOutcome

FEEDBACK_S = 0.7
"""How long a page says right or wrong (unverified default)."""
UNTOUCHED = Touched(0.0, None, None)
"""What a row holds of the finger where nothing was felt."""


@dataclass(frozen=True)
class Block:
    """Tracks that are presented together, and how.

    - `tracks`: More than one are interleaved.
    - `task`: What is asked in a trial.
    - `options`: How the trials follow each other.
    - `practice`: Mark the rows as practice.

    Raises `InvalidParameter` if there is no track, or something else in the place of one or of the task.
    """

    tracks: tuple[Track, ...]
    task: Task
    options: BlockOptions = field(default_factory=BlockOptions)
    practice: bool = False

    def __post_init__(self) -> None:
        of_kind("Block", Task, task=self.task)
        of_kind("Block", BlockOptions, options=self.options)
        are_tracks = isinstance(self.tracks, Sequence) and all(isinstance(track, Track) for track in self.tracks)
        expect(are_tracks, "Block.tracks", excerpt(self.tracks), "tracks")
        some("Block.tracks", self.tracks)

    @property
    def catch_rate(self) -> float:
        """That of the options, where the task takes catch trials."""
        return self.options.catch_rate if self.task.takes_catch_trials else 0.0

    @property
    def factors(self) -> dict[str, float | str]:
        """The factors that all tracks share."""
        first, *others = (track.condition.factors for track in self.tracks)
        return {name: level for name, level in first.items() if all(other.get(name) == level for other in others)}

    @property
    def instructions(self) -> str:
        return f"instructions_{self.task.name}"

    @property
    def page(self) -> str:
        return "practice" if self.practice else "block"

    def course(self, number: int, first_trial: int, rng: np.random.Generator) -> PartCourse:
        return run_block(self, number, first_trial, rng)


def run_block(block: Block, number: int, first_trial: int, rng: np.random.Generator) -> PartCourse:
    """Present until every track has finished; gives how the tracks stand then, and the number of the next trial."""
    state = begun = BlockState(block.options, block.tracks, first_trial)
    catches = [catch_schedule(block.catch_rate, rng) for _ in block.tracks]
    turn = turns(block.options.interleaving, rng)
    rested_s: float | None = None
    while open_ := state.open():
        index = turn(open_)
        slot = state.due(index)
        if slot is None:
            level = None if next(catches[index]) else state.tracks[index].procedure.level
            slot = Slot(index, state.next_trial, level)
        outcome = yield from block.task.trial(_presentation(state.tracks[index], slot), rng)
        # A row names what its presentation aborts: the state moves on before the row is recorded.
        before, state = state, state.after(slot, outcome)
        wanted = yield from _record_rows(block, number, slot, outcome, before, state)
        rested_s = outcome.onset_s if rested_s is None else rested_s
        since_s = outcome.onset_s - rested_s
        if outcome.valid and state.open() and block.options.rests(state.n_valid, since_s):  # none after the last trial
            wanted += yield from _rest(block.options)
            rested_s = None
        state = yield from _intervene(begun, number, state, wanted)
    return state.tracks, state.next_trial


def _rest(options: BlockOptions) -> Course[tuple[Intervention, ...]]:
    """A rest, and what the experimenter wanted in it."""
    pages = [] if options.rest_s is None else [Show("resting", duration_s=options.rest_s)]
    return (yield from heard([*pages, Show("rest")]))


def _intervene(
    begun: BlockState, number: int, state: BlockState, wanted: tuple[Intervention, ...]
) -> Course[BlockState]:
    """The state after all that the experimenter wants, also in a rest that was wanted."""
    while wanted:
        intervention, *later = wanted
        changed = _changed(begun, number, state, intervention)
        yield changed.request
        resting = intervention.wanted == "rest" and bool(state.open())
        said = (yield from _rest(state.options)) if resting else ()
        state, wanted = changed.state, (*later, *said)
    return state


class _Changed(NamedTuple):
    """What comes of an intervention."""

    state: BlockState
    request: Intervene


def _changed(begun: BlockState, number: int, state: BlockState, intervention: Intervention) -> _Changed:
    match intervention.wanted:
        case "skip" | "end":
            how = "skipped" if intervention.wanted == "skip" else "left, and the session ends"
            said = f"block {number} is {how}" if state.open() else f"block {number} had come to its end"
            return _Changed(state.skip(), Intervene(intervention, said))
        case "rest":
            said = "a rest" if state.open() else BETWEEN
            return _Changed(state, Intervene(intervention, said))
    of_block, trial, attempt = intervention.trial or (0, 0, 0)
    if of_block != number or any(track.skipped for track in state.tracks):
        return _Changed(state, not_asked_again(intervention))
    found = state.without(trial, attempt, begun)
    if found is None:
        return _Changed(state, Intervene(intervention, f"trial {trial} does not count anyway"))
    again, (slot, *others) = found
    retracted = tuple((number, each.trial, each.attempt) for each in (slot, *others))
    behind = "".join(f", nor does trial {other.trial}, whose level followed from it" for other in others)
    comes_again = "it is asked again" if slot.track in again.open() else "its track is over, and it is not asked again"
    return _Changed(
        again, Intervene(intervention, f"trial {slot.trial} does not count{behind}: {comes_again}", retracted)
    )


def _presentation(track: Track, slot: Slot) -> Presentation:
    condition = track.condition
    return Presentation(condition.stimulus, slot.level, condition.touch, condition.alternatives)


def _record_rows(
    block: Block, number: int, slot: Slot, outcome: TrialOutcome, before: BlockState, after: BlockState
) -> Course[tuple[Intervention, ...]]:
    """The rows of a presentation, the last with what it aborts, and what is said of the answer: what the experimenter
    wanted meanwhile."""
    track = before.tracks[slot.track]
    *replies, last = outcome.replies or (Reply(),)
    rows = [Record(trial_row(block, number, slot, track, outcome, reply)) for reply in replies]
    last_row = Record(trial_row(block, number, slot, track, outcome, last), _abortion(number, before, after))
    pages: list[Record | Show] = [*rows, last_row]
    if block.options.feedback and outcome.correct is not None:
        pages.append(Show("right" if outcome.correct else "wrong", duration_s=FEEDBACK_S))
    return (yield from heard(pages))


def _abortion(number: int, before: BlockState, after: BlockState) -> str | None:
    """What ends unfinished, and why; None where nothing does."""
    pairs = zip(before.tracks, after.tracks, strict=True)
    lost = [then.name for was, then in pairs if then.aborted and not was.aborted]
    if not lost:
        return None
    names = ", ".join(name for name in lost if name)
    of_names = f" ({names})" if names else ""
    return f"block {number} is aborted{of_names}: {_reason(after)}"


def _reason(state: BlockState) -> str:
    options = state.options
    if options.longest_s is not None and state.late:
        return f"it has lasted longer than {options.longest_s:g} s"
    n_lost = count_of(options.n_attempts, "presentation")
    return f"{n_lost} in a row, or of one trial, {'was' if options.n_attempts == 1 else 'were'} not valid"


def trial_row(block: Block, number: int, slot: Slot, track: Track, outcome: TrialOutcome, reply: Reply) -> Trial:
    """The row of a reply."""
    # Where no touch is the one whose level counts, the first stands for the trial.
    touch = outcome.stimulus or next(iter(outcome.touches), UNTOUCHED)
    is_catch, answer = slot.level is None, reply.answer
    return Trial(
        block=number,
        trial=slot.trial,
        factors={**track.condition.factors, **outcome.factors},
        procedure=outcome.rule or _rule_name(track.procedure, is_catch=is_catch),
        level=slot.level,
        level_unit=track.condition.level_unit,
        task=block.task.name,
        response=reply.response,
        correct=outcome.correct,
        onset_s=outcome.onset_s,
        latency_s=None if answer is None else answer.latency_s,
        force_mean_n=touch.force_mean_n,
        force_sd_n=touch.force_sd_n,
        force_in_band=touch.force_in_band,
        valid=outcome.valid,
        timestamp_utc=None if answer is None else answer.timestamp_utc,
        track=track.name,
        attempt=slot.attempt,
        catch=is_catch if block.task.takes_catch_trials else None,
        item=reply.item,
        level_delivered=None if is_catch else touch.level_delivered,
        level_measured=reply.level_measured,
        speed_target_m_per_s=track.condition.speed_m_per_s,
        speed_mean_m_per_s=touch.speed_mean_m_per_s,
        target=outcome.target,
        standard_level=outcome.standard_level,
        item_b=reply.item_b,
        practice=block.practice,
        speed_in_band=touch.speed_in_band,
        invalid_reason=outcome.invalid_reason,
        n_gaps=outcome.n_gaps,
        positions_digest=None if is_catch else touch.positions_digest,
        positions_late=None if is_catch else touch.positions_late,
        separation_m=outcome.separation_m,
        error_m=outcome.error_m,
    )


def _rule_name(procedure: Procedure, *, is_catch: bool) -> str:
    """What chose the level of a presentation, as the column `procedure` has it."""
    return EASY if procedure.is_easy and not is_catch else procedure.name
