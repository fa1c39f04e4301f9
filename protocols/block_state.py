"""State of a block: tracks, repeated presentations and turns."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from typing import Annotated, Any, Literal, get_args

import numpy as np
from annotated_types import Interval

from tactometry.arguments.constraints import Positive, constrained
from tactometry.arguments.require import expect, one_of
from tactometry.session.run import Course

from .procedures.practice import Practice
from .procedures.procedure import Count, FixedOrder, Procedure, Run, after_answer
from .tasks.task import Alternative, TrialOutcome
from .tasks.touch import Touch

Interleaving = Literal["random", "balanced"]
LEAST_RATE = 1e-6
"""Smallest rate of catch trials. With a smaller rate, no session would be long enough to contain one."""


@dataclass(frozen=True)
class Condition:
    """Constants of a track: factors, stimulus (by name) and touch."""

    factors: Mapping[str, float | str]
    stimulus: str
    level_unit: str
    touch: Touch
    speed_m_per_s: float | None = None
    alternatives: tuple[Alternative, ...] = ()


@dataclass(frozen=True)
class Track:
    """Procedure on a condition, with a name if it is interleaved.

    A track has not `begun` if the session had no time for its block. It is `skipped` if the experimenter ended it.
    """

    condition: Condition
    procedure: Procedure
    name: str | None = None
    aborted: bool = False
    begun: bool = True
    skipped: bool = False

    @property
    def missed_practice(self) -> Practice | None:
        """Return the practice whose track ended without its criterion, or None."""
        rule = self.procedure.rule if isinstance(self.procedure, Run) else self.procedure
        return rule if isinstance(rule, Practice) and self.ending in ("trials", "aborted") else None

    @property
    def ending(self) -> str | None:
        if not self.begun:
            return "not begun"
        if self.skipped:
            return "skipped"
        return "aborted" if self.aborted else self.procedure.ending


PartCourse = Course[tuple[tuple[Track, ...], int]]
"""Course of a part of a session. Returns its tracks at their end and the number of the next trial."""


@dataclass(frozen=True)
@constrained
class BlockOptions:
    """Order, repetitions and rests of a block: keys of `task` for all tasks.

    - `catch_rate`: Fraction of catch trials (without a stimulus) in a track, if the task has them.
    - `n_attempts`: A track is aborted after this number of invalid presentations in a row, or of attempts at one trial.
      Until then, an invalid presentation is repeated: at the end of the block if the procedure has a fixed order, else
      at the track's next turn.
    - `interleaving`: With ``random`` each trial draws one of the unfinished tracks. With ``balanced`` each round
      presents all of them once, in random order.
    - `feedback`: Show after each answer whether it was right.
    - `rest_after`: Number of valid trials between two rests.
    - `rest_every_s`: Time from the last rest, or from the start of the block, to the next rest. The rest follows the
      first valid trial that begins after this time.
    - `rest_s`: Minimum duration of a rest, shown as a countdown.
    - `longest_s`: Longest duration of a block. Unfinished tracks are then aborted.
    """

    catch_rate: Annotated[float, Interval(ge=0, le=0.5)] = 0.0
    n_attempts: Count = 5
    interleaving: Interleaving = "random"
    feedback: bool = False
    rest_after: Count | None = None
    rest_s: Positive | None = None
    longest_s: Positive | None = None
    rest_every_s: Positive | None = None

    def __post_init__(self) -> None:
        is_rate = self.catch_rate == 0 or self.catch_rate >= LEAST_RATE
        expect(is_rate, "BlockOptions.catch_rate", f"{self.catch_rate:g}", f"0, or at least {LEAST_RATE:g}")
        one_of("BlockOptions.interleaving", self.interleaving, get_args(Interleaving))

    def rests(self, n_valid: int, since_s: float) -> bool:
        """Return True if a rest is due.

        `n_valid` is the number of valid trials in the block, `since_s` the time since the last rest.

        >>> BlockOptions(rest_after=20).rests(40, since_s=0.0), BlockOptions(rest_every_s=600.0).rests(7, since_s=610.0)
        (True, True)
        """
        by_number = self.rest_after is not None and not n_valid % self.rest_after
        return by_number or (self.rest_every_s is not None and since_s >= self.rest_every_s)


@dataclass(frozen=True)
class Slot:
    """Presentation of a track: trial number and level (None: catch trial)."""

    track: int
    trial: int
    level: float | None
    attempt: int = 1


@dataclass(frozen=True)
class BlockState:
    """State of a block: tracks, presentations to repeat, and time.

    `log` contains all presentations with their outcomes, or None for a retracted presentation. The state follows
    from it.
    """

    options: BlockOptions
    tracks: tuple[Track, ...]
    next_trial: int
    again: tuple[Slot, ...] = ()
    n_invalid_in_a_row: Mapping[int, int] = field(default_factory=dict)
    begun_s: float | None = None
    n_valid: int = 0
    late: bool = False
    log: tuple[tuple[Slot, TrialOutcome | None], ...] = ()

    def open(self) -> list[int]:
        """Return the tracks with presentations left."""
        owed = {slot.track for slot in self.again if isinstance(self.tracks[slot.track].procedure, FixedOrder)}
        going = (n for n, track in enumerate(self.tracks) if not (track.aborted or track.skipped))
        return [n for n in going if n in owed or not self.tracks[n].procedure.finished]

    def due(self, index: int) -> Slot | None:
        """Return the presentation to repeat now, or at the end of a fixed order."""
        procedure = self.tracks[index].procedure
        owed = (slot for slot in self.again if slot.track == index)
        return next(owed, None) if isinstance(procedure, FixedOrder) == procedure.finished else None

    def after(self, slot: Slot, outcome: TrialOutcome | None) -> "BlockState":
        """Return the state after a presentation. A None outcome means retracted."""
        state = replace(
            self,
            again=tuple(other for other in self.again if other.trial != slot.trial),
            next_trial=max(self.next_trial, slot.trial + 1),
            log=(*self.log, (slot, outcome)),
        )
        if outcome is None:
            return state._put_back(slot)
        state = replace(state, begun_s=outcome.onset_s if self.begun_s is None else self.begun_s)
        state = state._count(slot, outcome) if outcome.valid else state._lose(slot)

        longest_s = self.options.longest_s
        if longest_s is None or outcome.onset_s - (state.begun_s or 0.0) <= longest_s:
            return state
        tracks = (track if track.procedure.finished else replace(track, aborted=True) for track in state.tracks)
        return replace(state, tracks=tuple(tracks), late=True)

    def skip(self) -> "BlockState":
        """Skip all tracks with presentations left."""
        still_open = self.open()
        tracks = (replace(track, skipped=n in still_open) for n, track in enumerate(self.tracks))
        return replace(self, tracks=tuple(tracks))

    def without(self, trial: int, attempt: int, begun: "BlockState") -> tuple["BlockState", tuple[Slot, ...]] | None:
        """Retract a presentation and those whose level depends on its answer.

        The result is None if the presentation does not count.

        In an adaptive track, later levels depend on the answer. Their presentations are retracted too, and this one
        is repeated at its own level. `begun` is the state before the first trial.
        """
        counting = [n for n, (_, outcome) in enumerate(self.log) if outcome is not None and outcome.valid]
        place = next((n for n in counting if (self.log[n][0].trial, self.log[n][0].attempt) == (trial, attempt)), None)
        if place is None:
            return None
        answered = self.log[place][0]
        followed = {n for n in range(place + 1, len(self.log)) if self._follows(self.log[n][0], answered)}
        entries = (
            (slot, None if n == place else outcome) for n, (slot, outcome) in enumerate(self.log) if n not in followed
        )
        state = reduce(lambda state, entry: state.after(*entry), entries, begun)
        taken_back = (self.log[n][0] for n in counting if n == place or n in followed)
        return replace(state, next_trial=self.next_trial), tuple(taken_back)

    def _follows(self, slot: Slot, answered: Slot) -> bool:
        """Return True if a presentation's level depends on an earlier answer."""
        if slot.level is None or answered.level is None:  # catch trials depend on nothing
            return False
        procedure, learner = (self.tracks[each.track].procedure for each in (answered, slot))
        if slot.track == answered.track:
            return not isinstance(procedure, FixedOrder)
        return learner.learning_from(procedure) is not learner

    def _count(self, slot: Slot, outcome: TrialOutcome) -> "BlockState":
        tracks = self.tracks if slot.level is None else self._answer(slot, outcome)
        in_a_row = {**self.n_invalid_in_a_row, slot.track: 0}
        return replace(self, tracks=tracks, n_invalid_in_a_row=in_a_row, n_valid=self.n_valid + 1)

    def _answer(self, slot: Slot, outcome: TrialOutcome) -> tuple[Track, ...]:
        """Return all tracks after an answer on one of them."""
        procedure = self.tracks[slot.track].procedure
        if isinstance(procedure, FixedOrder):
            then = procedure if slot.attempt > 1 else procedure.skip()  # a repeated level was skipped earlier
            return self._with(slot.track, procedure=then if outcome.success is None else then.take(outcome.success))
        delivered = None if outcome.stimulus is None else outcome.stimulus.level_delivered
        success = outcome.success is not False  # a task without right answers counts as a success
        procedures = after_answer([track.procedure for track in self.tracks], slot.track, success, delivered)
        pairs = zip(self.tracks, procedures, strict=True)
        return tuple(replace(track, procedure=procedure) for track, procedure in pairs)

    def _lose(self, slot: Slot) -> "BlockState":
        """Repeat an invalid presentation, or abort its track."""
        n_in_a_row = self.n_invalid_in_a_row.get(slot.track, 0) + 1
        state = replace(self, n_invalid_in_a_row={**self.n_invalid_in_a_row, slot.track: n_in_a_row})
        if max(n_in_a_row, slot.attempt) < self.options.n_attempts:
            return state._put_back(slot)
        return replace(state._owe(slot), tracks=state._with(slot.track, aborted=True))

    def _put_back(self, slot: Slot) -> "BlockState":
        procedure, state = self.tracks[slot.track].procedure, self._owe(slot)
        if not isinstance(procedure, FixedOrder) or slot.attempt > 1 or slot.level is None:
            return state
        return replace(state, tracks=self._with(slot.track, procedure=procedure.skip()))

    def _owe(self, slot: Slot) -> "BlockState":
        return replace(self, again=(*self.again, replace(slot, attempt=slot.attempt + 1)))

    def _with(self, index: int, **changes: Any) -> tuple[Track, ...]:
        return tuple(replace(track, **changes) if n == index else track for n, track in enumerate(self.tracks))


def catch_schedule(catch_rate: float, rng: np.random.Generator) -> Iterator[bool]:
    """Yield True for one catch trial in each group of round(1 / catch_rate).

    >>> import itertools
    >>> sum(itertools.islice(catch_schedule(0.2, np.random.default_rng(1)), 50))
    10
    """
    if catch_rate == 0:
        while True:
            yield False
    # one per group: if drawn for each trial, a short track could have none, or several in a row
    n_group = max(round(1 / catch_rate), 1)
    while True:
        caught = int(rng.integers(n_group))
        yield from (n == caught for n in range(n_group))


def turns(interleaving: str, rng: np.random.Generator) -> Callable[[Sequence[int]], int]:
    """Return a function that draws the next of the open tracks.

    >>> turn = turns("balanced", np.random.default_rng(1))
    >>> sorted(turn((0, 1, 2)) for _ in range(3)), turn((2,))
    ([0, 1, 2], 2)
    """
    left: list[int] = []

    def turn(open_: Sequence[int]) -> int:
        nonlocal left
        if interleaving == "random":
            return open_[int(rng.integers(len(open_)))] if len(open_) > 1 else open_[0]
        left = [n for n in left if n in open_] or [open_[int(n)] for n in rng.permutation(len(open_))]
        return left.pop(0)

    return turn
