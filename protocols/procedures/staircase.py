"""The transformed up-down staircase."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Protocol, Self

from tactometry.arguments.require import finite, numbers, whole
from tactometry.errors import InvalidParameter

from .procedure import Ending, checked_response, finite_level, refuse_finished

COUNTS: Final = ("n_down", "n_reversals", "n_trials", "n_at_bound")


class BoundedTrack(Protocol):
    """What every staircase states."""

    @property
    def start(self) -> float: ...

    @property
    def low(self) -> float: ...

    @property
    def high(self) -> float: ...


def check_rule(rule: BoundedTrack, counts: Sequence[str], **schedules: tuple[float, ...]) -> None:
    """Refuse bounds, a start, counts (by their names) or steps that make no staircase; the sentence opens with the
    class of `rule`."""
    owner = type(rule).__name__
    finite(owner, start=rule.start, low=rule.low, high=rule.high)
    for name, steps in schedules.items():
        numbers(f"{owner}.{name}", steps)
    whole(owner, lowest=1, **{name: getattr(rule, name) for name in counts})
    if not rule.low < rule.high:
        raise InvalidParameter(f"{owner}.low: found {rule.low:g}, expected less than high ({rule.high:g})")
    if not rule.low <= rule.start <= rule.high:
        raise InvalidParameter(
            f"{owner}.start: found {rule.start:g}, expected a level between low ({rule.low:g}) and high ({rule.high:g})"
        )
    for name, steps in schedules.items():
        _check_steps(f"{owner}.{name}", steps, rule.high - rule.low)


def _check_steps(where: str, steps: tuple[float, ...], widest: float) -> None:
    if not steps:
        raise InvalidParameter(f"{where}: found no step, expected at least one")
    for n, step in enumerate(steps):
        if not 0 < step <= widest:
            raise InvalidParameter(
                f"{where}[{n}]: found {step:g}, expected above 0 and at most the range of levels ({widest:g})"
            )


@dataclass(frozen=True)
class Staircase:
    """n-up m-down: `n_down` correct responses in a row lower the level, `n_up` wrong ones in a row raise it.

    The target of 1 up, m down is the level of p = 0.5^(1/m) correct (Levitt, J. Acoust. Soc. Am. 49, 467, 1971, table
    I). Levels are in a unit in which equal steps make sense, such as decibels. Until the first reversal one response
    moves the level (`initial_rule`), as in PsychoPy. Step k is used after k reversals, the last one from then on.

    Differences from PsychoPy's StairHandler: the next level starts from the level that was *delivered*; it ends at
    `n_reversals` reversals or `n_trials` trials, whichever comes first (PsychoPy: when both are reached); and
    `n_at_bound` moves in a row that ask for a level beyond `low` or `high` end it as censored (PsychoPy goes on).

    Raises
    ------
    InvalidParameter
        If bounds, start, steps or counts make no staircase.

    >>> rule = Staircase(start=20.0, steps=(4.0, 2.0), low=0.0, high=40.0, n_down=2, n_reversals=4, n_trials=50)
    >>> rule.after(1).level, rule.after(1).after(0).level
    (16.0, 18.0)
    """

    start: float
    steps: tuple[float, ...]
    low: float
    high: float
    n_up: int = 1
    n_down: int = 2
    n_reversals: int = 8
    n_trials: int = 60
    n_at_bound: int = 3
    initial_rule: bool = True
    levels: tuple[float, ...] = ()
    responses: tuple[bool, ...] = ()
    reversals: tuple[float, ...] = ()
    _asked: float | None = None
    _direction: int = 0
    _run: int = 0
    _n_pinned: int = 0

    name = "staircase"

    def __post_init__(self) -> None:
        if self.levels:
            return
        check_rule(self, ("n_up", *COUNTS), steps=self.steps)

    @property
    def level(self) -> float:
        return self.start if self._asked is None else self._asked

    @property
    def finished(self) -> bool:
        return self.ended is not None

    @property
    def ended(self) -> Ending | None:
        if self._n_pinned >= self.n_at_bound:
            return "censored_above" if self._direction > 0 else "censored_below"
        if len(self.reversals) >= self.n_reversals:
            return "converged"
        return "trials" if len(self.responses) >= self.n_trials else None

    @property
    def step(self) -> float:
        return self.steps[min(len(self.reversals), len(self.steps) - 1)]

    @property
    def threshold(self) -> float | None:
        """`mean_of_reversals` without the first two."""
        return self.mean_of_reversals()

    def mean_of_reversals(self, *, discard: int = 2) -> float | None:
        """The mean level of the reversals without the first `discard`, made even in number; None if there are fewer
        than two of them or the run is censored."""
        kept = self.reversals[discard + (len(self.reversals) - discard) % 2 :]
        censored = self.ended in ("censored_above", "censored_below")
        return None if censored or len(kept) < 2 else math.fsum(kept) / len(kept)

    def after(self, response: int | bool, delivered: float | None = None) -> Self:
        """The staircase after a response to the level that was delivered (default: the one asked for)."""
        correct = checked_response(response, "Staircase")
        refuse_finished(finished=self.finished, procedure="Staircase")
        level = finite_level(self.level if delivered is None else delivered, "Staircase")
        told = replace(
            self,
            levels=(*self.levels, level),
            responses=(*self.responses, correct),
            _run=self._count(correct),
        )
        return told._moved(level, told._direction_asked())

    def _count(self, correct: bool) -> int:
        """Responses in a row of one kind since the last move: above 0 correct, below 0 wrong."""
        same = self._run > 0 if correct else self._run < 0
        return (self._run if same else 0) + (1 if correct else -1)

    def _direction_asked(self) -> int:
        """+1 up, -1 down, 0 stay."""
        first = self.initial_rule and not self.reversals
        if self._run >= (1 if first else self.n_down):
            return -1
        return 1 if -self._run >= (1 if first else self.n_up) else 0

    def _moved(self, level: float, direction: int) -> Self:
        if direction == 0:
            return replace(self, _asked=self._bounded(level))
        turned = self._direction == -direction
        told = replace(
            self,
            reversals=(*self.reversals, level) if turned else self.reversals,
            _direction=direction,
            _run=0,
        )
        wanted = level + direction * told.step
        pinned = level >= self.high if direction > 0 else level <= self.low
        return replace(
            told,
            _asked=self._bounded(wanted),
            _n_pinned=self._n_pinned + 1 if pinned and not turned else int(pinned),
        )

    def _bounded(self, level: float) -> float:
        return min(max(level, self.low), self.high)
