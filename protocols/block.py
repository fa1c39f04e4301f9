"""A block: one procedure on one condition, until it is finished; and a session: blocks in their order."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tactometry.protocols.procedure import Procedure
from tactometry.protocols.task import Outcome, Presentation, Task
from tactometry.protocols.touch import Touch
from tactometry.request import Record, Show
from tactometry.run import Course
from tactometry.trial import Trial


@dataclass(frozen=True)
class Condition:
    """What stays the same in a block: its factors, the stimulus (by name) and how it is touched."""

    factors: Mapping[str, float | str]
    stimulus: str
    level_unit: str
    touch: Touch
    speed_m_per_s: float | None = None


@dataclass(frozen=True)
class Block:
    """A condition with its procedure. `catch_rate` is the part of presentations without stimulus; `n_attempts` invalid
    attempts in a row end the block as aborted."""

    condition: Condition
    task: Task
    procedure: Procedure
    catch_rate: float = 0.0
    n_attempts: int = 5


@dataclass(frozen=True)
class Track:
    """How a block's procedure stood at its end."""

    block: Block
    procedure: Procedure
    aborted: bool = False

    @property
    def ended(self) -> str | None:
        return "aborted" if self.aborted else self.procedure.ended


def catch_schedule(catch_rate: float, rng: np.random.Generator) -> Iterator[bool]:
    """Whether each presentation is a catch trial: in each group of round(1 / catch_rate) exactly one is.

    >>> import itertools
    >>> sum(itertools.islice(catch_schedule(0.2, np.random.default_rng(1)), 50))
    10
    """
    if catch_rate == 0:
        while True:
            yield False
    n_group = max(round(1 / catch_rate), 1)
    while True:
        caught = int(rng.integers(n_group))
        yield from (n == caught for n in range(n_group))


def run_block(block: Block, number: int, first_trial: int, rng: np.random.Generator) -> Course[tuple[Track, int]]:
    """Present until the procedure has finished; gives its end and the number of the next trial."""
    procedure, trial = block.procedure, first_trial
    catches = catch_schedule(block.catch_rate if block.task.takes_catch_trials else 0.0, rng)
    while not procedure.finished:
        catch = next(catches)
        level = None if catch else procedure.level
        outcome = yield from _attempts(block, number, trial, level, rng)
        trial += 1
        if not outcome.valid:
            return Track(block, procedure, aborted=True), trial
        if not catch:
            procedure = procedure.after(bool(outcome.correct), _delivered(outcome))
    return Track(block, procedure), trial


def _delivered(outcome: Outcome) -> float | None:
    return None if outcome.stimulus is None else outcome.stimulus.level_delivered


def _attempts(block: Block, number: int, trial: int, level: float | None, rng: np.random.Generator) -> Course[Outcome]:
    shown = Presentation(block.condition.stimulus, level, block.condition.touch)
    outcome = Outcome((), None)
    for attempt in range(1, block.n_attempts + 1):
        outcome = yield from block.task.trial(shown, rng)
        yield Record(trial_row(block, number, trial, level, outcome, attempt))
        if outcome.valid:
            break
    return outcome


def trial_row(block: Block, number: int, trial: int, level: float | None, outcome: Outcome, attempt: int) -> Trial:
    """The row of one attempt."""
    felt, choice, condition = outcome.stimulus or outcome.touches[0], outcome.choice, block.condition
    return Trial(
        block=number,
        trial=trial,
        factors=condition.factors,
        procedure=block.procedure.name,
        level=level,
        level_unit=condition.level_unit,
        task=block.task.name,
        response=choice.option if choice is not None else None,
        correct=outcome.correct,
        onset_s=outcome.touches[0].onset_s,
        latency_s=choice.latency_s if choice is not None else None,
        force_mean_n=felt.force_mean_n,
        force_sd_n=felt.force_sd_n,
        force_in_band=felt.force_in_band,
        valid=outcome.valid,
        timestamp_utc=choice.timestamp_utc if choice is not None else None,
        attempt=attempt,
        catch=(level is None) if block.task.takes_catch_trials else None,
        level_delivered=felt.level_delivered,
        speed_target_m_per_s=condition.speed_m_per_s,
        speed_mean_m_per_s=felt.speed_mean_m_per_s,
        target=outcome.target,
    )


def session(blocks: Sequence[Block], rng: np.random.Generator) -> Course[tuple[Track, ...]]:
    """All blocks in their order, with a page before each, the tasks' instructions first, and a last page."""
    yield Show("welcome", {"n_blocks": len(blocks)})
    for name in dict.fromkeys(block.task.name for block in blocks):
        yield Show(f"instructions_{name}")
    tracks: list[Track] = []
    trial = 1
    for number, block in enumerate(blocks, 1):
        yield Show("block", {"block": number, "n_blocks": len(blocks), **block.condition.factors})
        track, trial = yield from run_block(block, number, trial, rng)
        tracks.append(track)
    yield Show("end")
    return tuple(tracks)
