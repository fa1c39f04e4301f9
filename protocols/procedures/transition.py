"""Steps of a rule as pure functions, which a session calls in Python and a batch compiles to machine code.

The functions call only what numba knows, and take

- `numbers`: those of the rule, a named tuple of numbers and of sequences of numbers;
- `order`: numbers drawn for the run before its first answer, empty for most rules;
- `state`: a tuple of numbers, each either always whole or never;
- `answers` and `levels`: the history with the last answer, sequences of equal length.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, get_args

from .procedure import Ending

Numbers = tuple[Any, ...]
Order = Sequence[float]
State = tuple[Any, ...]
GOES_ON, CONVERGED, TRIALS, CENSORED_ABOVE, CENSORED_BELOW, ABORTED = range(6)
"""Codes of `Transition.ending`. Runs that end with the last three have no threshold."""


def ending_of(code: int) -> Ending | None:
    """Return the ending of a code.

    >>> ending_of(GOES_ON), ending_of(CENSORED_BELOW)
    (None, 'censored_below')
    """
    endings: tuple[Ending, ...] = get_args(Ending)
    return endings[code - 1] if code else None


def no_answer(numbers: Numbers, order: Order) -> State:
    """Start of a rule whose state is the number of answers."""
    return (0,)


def one_more(
    numbers: Numbers, order: Order, state: State, answers: Sequence[int], levels: Sequence[float]
) -> tuple[State, float]:
    """Count an answer, without a mark."""
    return (state[0] + 1,), math.nan


def no_threshold(marks: Sequence[float]) -> float:
    """Return NaN: the rule makes no estimate."""
    return math.nan


@dataclass(frozen=True)
class Transition:
    """The rule of a kind of procedure.

    - `start`: ``start(numbers, order)``: the state before the first answer.
    - `level`: ``level(numbers, order, state)``: the next level, also of a run that has ended.
    - `after`: ``after(numbers, order, state, answers, levels)``: the state after the last answer, and what that answer
      is marked with: a level that an estimate rests on (a reversal, a transition), else NaN.
    - `ending`: ``ending(numbers, order, state, answers)``: `GOES_ON`, or how it ended.
    - `threshold`: ``threshold(marks)``: the rule's own estimate from the marks of all answers, NaN where there is none.
    """

    start: Callable[..., State]
    level: Callable[..., float]
    after: Callable[..., tuple[State, float]]
    ending: Callable[..., int]
    threshold: Callable[[Sequence[float]], float]
