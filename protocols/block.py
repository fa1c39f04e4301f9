"""A block: procedures on their conditions, alone or interleaved."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from tactometry.arguments.constraints import excerpt
from tactometry.arguments.require import expect, of_kind, some
from tactometry.errors import count_of
from tactometry.session.answer import Intervention, Touched
from tactometry.session.request import Intervene, Record, Show
from tactometry.session.run import Course
from tactometry.trials.tasks import EASY
from tactometry.trials.trial import Trial

from .block_state import BlockOptions, BlockState, PartCourse, Slot, Track, catch_schedule, turns
from .interventions import BETWEEN, heard, not_asked_again
from .tasks.task import Presentation, Reply, Task, TrialOutcome

FEEDBACK_S = 0.7
"""Duration of the feedback page (unverified default)."""
UNTOUCHED = Touched(0.0, None, None)
"""Placeholder touch in the row of a trial without a stimulus."""


@dataclass(frozen=True)
class Block:
    """Tracks that are presented in one block, and how.

    - `tracks`: Tracks of the block. Several tracks are interleaved.
    - `task`: Course of a trial.
    - `options`: Order, repetitions and rests.
    - `practice`: True marks the rows as practice.
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
        """Catch rate of the options, or 0 for a task without catch trials."""
        return self.options.catch_rate if self.task.takes_catch_trials else 0.0

    @property
    def factors(self) -> dict[str, float | str]:
        """Factors with the same level in all tracks."""
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
    """Run a block until every track ends; return the tracks and next trial."""
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
        condition = state.tracks[index].condition
        shown = Presentation(condition.stimulus, slot.level, condition.touch, condition.alternatives)
        outcome = yield from block.task.trial(shown, rng)
        # the row states which tracks its presentation aborts, so the state is updated before the row is recorded
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
    """Show the pages of a rest and return the orders given during it."""
    pages = [] if options.rest_s is None else [Show("resting", duration_s=options.rest_s)]
    return (yield from heard([*pages, Show("rest")]))


def _intervene(
    begun: BlockState, number: int, state: BlockState, wanted: tuple[Intervention, ...]
) -> Course[BlockState]:
    """Carry out all interventions on a state, including those during a rest."""
    while wanted:
        intervention, *later = wanted
        is_open = bool(state.open())
        during_rest: tuple[Intervention, ...] = ()
        match intervention.wanted:
            case "invalidate":
                state, request = _without(begun, number, state, intervention)
                yield request
            case "rest":
                yield Intervene(intervention, "a rest" if is_open else BETWEEN)
                during_rest = (yield from _rest(state.options)) if is_open else ()
            case "skip" | "end":
                how = "skipped" if intervention.wanted == "skip" else "left, and the session ends"
                ended = f"is {how}" if is_open else "had come to its end"
                yield Intervene(intervention, f"block {number} {ended}")
                state = state.skip()
        wanted = (*later, *during_rest)
    return state


def _without(
    begun: BlockState, number: int, state: BlockState, intervention: Intervention
) -> tuple[BlockState, Intervene]:
    """Invalidate a trial, and return the state and its report."""
    of_block, trial, attempt = intervention.trial or (0, 0, 0)
    if of_block != number or any(track.skipped for track in state.tracks):
        return state, not_asked_again(intervention)
    result = state.without(trial, attempt, begun)
    if result is None:
        return state, Intervene(intervention, f"trial {trial} does not count anyway")

    again, (slot, *others) = result
    retracted = tuple((number, each.trial, each.attempt) for each in (slot, *others))
    behind = "".join(f", nor does trial {other.trial}, whose level followed from it" for other in others)
    comes_again = "it is asked again" if slot.track in again.open() else "its track is over, and it is not asked again"
    return again, Intervene(intervention, f"trial {slot.trial} does not count{behind}: {comes_again}", retracted)


def _record_rows(
    block: Block, number: int, slot: Slot, outcome: TrialOutcome, before: BlockState, after: BlockState
) -> Course[tuple[Intervention, ...]]:
    """Record rows, show feedback, and return the interventions given meanwhile."""
    track = before.tracks[slot.track]
    *rows, last = (trial_row(block, number, slot, track, outcome, reply) for reply in outcome.replies or (Reply(),))
    pages: list[Record | Show] = [*map(Record, rows), Record(last, _abortion(number, before, after))]
    if block.options.feedback and outcome.correct is not None:
        pages.append(Show("right" if outcome.correct else "wrong", duration_s=FEEDBACK_S))
    return (yield from heard(pages))


def _abortion(number: int, before: BlockState, after: BlockState) -> str | None:
    """Return which tracks end unfinished and why, or None."""
    pairs = zip(before.tracks, after.tracks, strict=True)
    lost = [then.name for was, then in pairs if then.aborted and not was.aborted]
    if not lost:
        return None
    names = ", ".join(name for name in lost if name)
    of_names = f" ({names})" if names else ""

    options = after.options
    n_lost = count_of(options.n_attempts, "presentation")
    reason = f"{n_lost} in a row, or of one trial, {'was' if options.n_attempts == 1 else 'were'} not valid"
    if options.longest_s is not None and after.late:
        reason = f"it has lasted longer than {options.longest_s:g} s"
    return f"block {number} is aborted{of_names}: {reason}"


def trial_row(block: Block, number: int, slot: Slot, track: Track, outcome: TrialOutcome, reply: Reply) -> Trial:
    """Return the row of a reply. Its touch is the one whose level counts."""
    touch = outcome.stimulus or next(iter(outcome.touches), UNTOUCHED)
    is_catch, answer = slot.level is None, reply.answer
    return Trial(
        block=number,
        trial=slot.trial,
        factors={**track.condition.factors, **outcome.factors},
        procedure=outcome.rule or (EASY if track.procedure.is_easy and not is_catch else track.procedure.name),
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
