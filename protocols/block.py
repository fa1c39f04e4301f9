"""A block: procedures on their conditions, alone or interleaved, until all are finished; and the sessions of blocks."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, Protocol, Self, TypeVar, get_args, runtime_checkable

import numpy as np

from tactometry.arguments.require import given, of_kind, one_of, positive, whole, within
from tactometry.errors import InvalidParameter, counted
from tactometry.session.request import Record, Show
from tactometry.session.run import Course
from tactometry.trials.trial import Trial

from .procedures.procedure import Procedure
from .procedures.shared_learning import answered
from .tasks.task import Alternative, Presentation, Reply, Task, TrialOutcome
from .tasks.touch import Touch

T = TypeVar("T")
Interleaving = Literal["random", "balanced"]
FEEDBACK_S = 0.7
"""How long a page says right or wrong (unverified default)."""
LEAST_RATE = 1e-6
"""Of catch trials: one in more than all trials of a session."""


@dataclass(frozen=True)
class Condition:
    """What stays the same in a track: its factors, the stimulus (by name) and how it is touched."""

    factors: Mapping[str, float | str]
    stimulus: str
    level_unit: str
    touch: Touch
    speed_m_per_s: float | None = None
    alternatives: tuple[Alternative, ...] = ()


@dataclass(frozen=True)
class Track:
    """A procedure on a condition, at the beginning of a block or at its end; `name` tells interleaved ones apart.

    One whose block the session had no time for is not `begun`.
    """

    condition: Condition
    procedure: Procedure
    name: str | None = None
    aborted: bool = False
    begun: bool = True

    @property
    def ended(self) -> str | None:
        if not self.begun:
            return "not begun"
        return "aborted" if self.aborted else self.procedure.ended


@runtime_checkable
class FixedOrder(Procedure, Protocol):
    """A procedure whose order no response changes: it can leave out a level that the block presents later."""

    def skipped(self) -> Self: ...

    def told(self, response: int | bool) -> Self: ...


class Presented(Protocol):
    """How the trials of a block follow each other, see `Block`."""

    @property
    def catch_rate(self) -> float: ...

    @property
    def n_attempts(self) -> int: ...

    @property
    def interleaving(self) -> Interleaving: ...

    @property
    def rest_after(self) -> int | None: ...

    @property
    def rest_s(self) -> float | None: ...

    @property
    def longest_s(self) -> float | None: ...


def check_presenting(each: Presented) -> None:
    """Refuse what makes no course of trials.

    Raises
    ------
    InvalidParameter
        If a number is out of its domain or the interleaving unknown; the sentence opens with the class of `each`.
    """
    owner = type(each).__name__
    within(owner, 0, 0.5, catch_rate=each.catch_rate)
    if 0 < each.catch_rate < LEAST_RATE:
        raise InvalidParameter(f"{owner}.catch_rate: found {each.catch_rate:g}, expected 0, or at least {LEAST_RATE:g}")
    one_of(f"{owner}.interleaving", each.interleaving, get_args(Interleaving))
    whole(owner, lowest=1, n_attempts=each.n_attempts)
    if each.rest_after is not None:
        whole(owner, lowest=1, rest_after=each.rest_after)
    lasting = {"rest_s": each.rest_s, "longest_s": each.longest_s}
    positive(owner, **given(lasting))


@dataclass(frozen=True)
class Block:
    """Tracks that are presented together, and how.

    Parameters
    ----------
    tracks : tuple of Track
        More than one are interleaved: each trial draws one of the unfinished tracks (``random``), or each round
        presents all of them once, in random order (``balanced``).
    task : Task
        What is asked in a trial.
    catch_rate : float
        The part of a track's presentations without stimulus, where the task takes them.
    n_attempts : int
        A presentation that is not valid comes again: at the end of the block if the procedure's order is fixed, else
        when its track is due. So many invalid ones in a row, or attempts at one trial, abort the track.
    feedback : bool
        Say right or wrong after each answer.
    practice : bool
        Mark the rows as practice.
    rest_after : int or None
        So many valid trials lie between two rests.
    rest_s : float or None
        A rest lasts at least so long, counted down.
    longest_s : float or None
        A block that lasts longer ends; what is unfinished is aborted.

    Raises
    ------
    InvalidParameter
        If there is no track, or a number or the interleaving is not as stated.
    """

    tracks: tuple[Track, ...]
    task: Task
    catch_rate: float = 0.0
    n_attempts: int = 5
    interleaving: Interleaving = "random"
    feedback: bool = False
    practice: bool = False
    rest_after: int | None = None
    rest_s: float | None = None
    longest_s: float | None = None

    def __post_init__(self) -> None:
        of_kind("Block", Task, task=self.task)
        if not isinstance(self.tracks, Sequence) or not all(isinstance(each, Track) for each in self.tracks):
            raise InvalidParameter(f"Block.tracks: found {self.tracks!r:.60}, expected tracks")
        if not self.tracks:
            raise InvalidParameter("Block.tracks: found no track, expected at least one")
        check_presenting(self)

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

    def course(self, number: int, first_trial: int, rng: np.random.Generator) -> Course[tuple[tuple[Track, ...], int]]:
        return run_block(self, number, first_trial, rng)


@dataclass(frozen=True)
class Asked:
    """A presentation: of which track, under which number, at which level (None: a catch trial)."""

    track: int
    trial: int
    level: float | None
    attempt: int = 1


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


def turns(interleaving: str, rng: np.random.Generator) -> Callable[[Sequence[int]], int]:
    """Who is next of those that are open: any, or (balanced) each once in every round.

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


@dataclass(frozen=True)
class Standing:
    """How a block stands: its tracks, the presentations that must come again, and what ends it; `late`: its time is
    over."""

    block: Block
    tracks: tuple[Track, ...]
    next_trial: int
    again: tuple[Asked, ...] = ()
    in_a_row: Mapping[int, int] = field(default_factory=dict)
    begun_s: float | None = None
    n_valid: int = 0
    late: bool = False

    def open(self) -> list[int]:
        """The tracks that have something left to present."""
        return [n for n, track in enumerate(self.tracks) if not track.aborted and self._has_more(n, track)]

    def _has_more(self, index: int, track: Track) -> bool:
        owed = isinstance(track.procedure, FixedOrder) and any(asked.track == index for asked in self.again)
        return owed or not track.procedure.finished

    def due(self, index: int) -> Asked | None:
        """The presentation of a track that comes again now: in an adaptive track at once, else when all have been."""
        procedure = self.tracks[index].procedure
        owed = (asked for asked in self.again if asked.track == index)
        return next(owed, None) if isinstance(procedure, FixedOrder) == procedure.finished else None

    def after(self, asked: Asked, outcome: TrialOutcome) -> "Standing":
        """The standing after a presentation."""
        begun_s = outcome.onset_s if self.begun_s is None else self.begun_s
        standing = replace(self, again=tuple(each for each in self.again if each.trial != asked.trial), begun_s=begun_s)
        standing = replace(standing, next_trial=max(self.next_trial, asked.trial + 1))
        standing = standing._kept(asked, outcome) if outcome.valid else standing._put_back(asked)
        late = self.block.longest_s is not None and outcome.onset_s - begun_s > self.block.longest_s
        return replace(standing, tracks=tuple(map(_stopped, standing.tracks)), late=True) if late else standing

    def _kept(self, asked: Asked, outcome: TrialOutcome) -> "Standing":
        standing = self if asked.level is None else self._told(asked, outcome)
        return replace(standing, in_a_row={**self.in_a_row, asked.track: 0}, n_valid=self.n_valid + 1)

    def _told(self, asked: Asked, outcome: TrialOutcome) -> "Standing":
        """The standing after a track has learnt what came of its level."""
        track = self.tracks[asked.track]
        if isinstance(track.procedure, FixedOrder):
            track = replace(track, procedure=_in_order(track.procedure, asked, outcome))
            return replace(self, tracks=_with(self.tracks, asked.track, track))
        delivered = None if outcome.stimulus is None else outcome.stimulus.level_delivered
        success = outcome.success is not False
        procedures = answered([each.procedure for each in self.tracks], asked.track, success, delivered)
        pairs = zip(self.tracks, procedures, strict=True)
        return replace(self, tracks=tuple(replace(each, procedure=procedure) for each, procedure in pairs))

    def _put_back(self, asked: Asked) -> "Standing":
        n_in_a_row = self.in_a_row.get(asked.track, 0) + 1
        track = self.tracks[asked.track]
        if max(n_in_a_row, asked.attempt) >= self.block.n_attempts:
            track = replace(track, aborted=True)
        elif isinstance(track.procedure, FixedOrder) and asked.attempt == 1 and asked.level is not None:
            track = replace(track, procedure=track.procedure.skipped())
        return replace(
            self,
            tracks=_with(self.tracks, asked.track, track),
            again=(*self.again, replace(asked, attempt=asked.attempt + 1)),
            in_a_row={**self.in_a_row, asked.track: n_in_a_row},
        )


def _in_order(procedure: FixedOrder, asked: Asked, outcome: TrialOutcome) -> FixedOrder:
    """The procedure after an answer; it stays where it is if the level was left out before."""
    then = procedure if asked.attempt > 1 else procedure.skipped()
    return then if outcome.success is None else then.told(outcome.success)


def _with(values: tuple[T, ...], index: int, value: T) -> tuple[T, ...]:
    return (*values[:index], value, *values[index + 1 :])


def _stopped(track: Track) -> Track:
    return track if track.procedure.finished else replace(track, aborted=True)


def run_block(
    block: Block, number: int, first_trial: int, rng: np.random.Generator
) -> Course[tuple[tuple[Track, ...], int]]:
    """Present until every track has finished; gives how the tracks stand then, and the number of the next trial."""
    standing = Standing(block, block.tracks, first_trial)
    catch_rate = block.catch_rate if block.task.takes_catch_trials else 0.0
    catches = [catch_schedule(catch_rate, rng) for _ in block.tracks]
    turn = turns(block.interleaving, rng)
    while open_ := standing.open():
        index = turn(open_)
        asked = standing.due(index)
        if asked is None:
            level = None if next(catches[index]) else standing.tracks[index].procedure.level
            asked = Asked(index, standing.next_trial, level)
        outcome = yield from block.task.trial(_presentation(standing.tracks[index], asked), rng)
        before, standing = standing, standing.after(asked, outcome)
        yield from _recorded(number, asked, outcome, before, standing)
        if block.rest_after and outcome.valid and standing.open() and standing.n_valid % block.rest_after == 0:
            if block.rest_s is not None:
                yield Show("resting", duration_s=block.rest_s)
            yield Show("rest")
    return standing.tracks, standing.next_trial


def _presentation(track: Track, asked: Asked) -> Presentation:
    condition = track.condition
    return Presentation(condition.stimulus, asked.level, condition.touch, condition.alternatives)


def _recorded(number: int, asked: Asked, outcome: TrialOutcome, before: Standing, after: Standing) -> Course[None]:
    """The rows of a presentation, the last with what it aborts, and what is said of the answer."""
    block, track = before.block, before.tracks[asked.track]
    *replies, last = outcome.replies or (Reply(),)
    for reply in replies:
        yield Record(trial_row(block, number, asked, track, outcome, reply))
    yield Record(trial_row(block, number, asked, track, outcome, last), _aborted(number, before, after))
    correct = outcome.replies[0].correct if outcome.valid else None
    if block.feedback and correct is not None:
        yield Show("right" if correct else "wrong", duration_s=FEEDBACK_S)


def _aborted(number: int, before: Standing, after: Standing) -> str | None:
    """What ends unfinished, and why; None where nothing does."""
    pairs = zip(before.tracks, after.tracks, strict=True)
    lost = [then.name for was, then in pairs if then.aborted and not was.aborted]
    if not lost:
        return None
    block = before.block
    n_lost = counted(block.n_attempts, "presentation")
    why = f"{n_lost} in a row, or of one trial, {'was' if block.n_attempts == 1 else 'were'} not valid"
    if block.longest_s is not None and after.late:
        why = f"it has lasted longer than {block.longest_s:g} s"
    names = ", ".join(name for name in lost if name)
    return f"block {number} is aborted{f' ({names})' if names else ''}: {why}"


def trial_row(block: Block, number: int, asked: Asked, track: Track, outcome: TrialOutcome, reply: Reply) -> Trial:
    """The row of a reply."""
    felt = outcome.stimulus or next(iter(outcome.touches), None)
    return Trial(
        block=number,
        trial=asked.trial,
        factors={**track.condition.factors, **outcome.factors},
        procedure=outcome.rule or track.procedure.name,
        level=asked.level,
        level_unit=track.condition.level_unit,
        task=block.task.name,
        response=reply.response,
        correct=reply.correct,
        onset_s=outcome.onset_s,
        latency_s=reply.latency_s,
        force_mean_n=felt.force_mean_n if felt else None,
        force_sd_n=felt.force_sd_n if felt else None,
        force_in_band=felt.force_in_band if felt else None,
        valid=outcome.valid,
        timestamp_utc=reply.timestamp_utc,
        track=track.name,
        attempt=asked.attempt,
        catch=(asked.level is None) if block.task.takes_catch_trials else None,
        item=reply.item,
        level_delivered=felt.level_delivered if felt and asked.level is not None else None,
        level_measured=reply.level_measured,
        speed_target_m_per_s=track.condition.speed_m_per_s,
        speed_mean_m_per_s=felt.speed_mean_m_per_s if felt else None,
        target=outcome.target,
        standard_level=outcome.standard_level,
        item_b=reply.item_b,
        practice=block.practice,
        speed_in_band=felt.speed_in_band if felt else None,
        invalid_reason=outcome.invalid_reason,
        n_gaps=outcome.n_gaps,
    )
