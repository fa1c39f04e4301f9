"""What a rule does with an answer, as pure functions of plain numbers, written once: a session calls them as they
stand, a batch of thousands of sets calls them as machine code (`tactometry.protocols.batch`).

Each is therefore closed in itself: it calls nothing but what numba knows of Python, and takes

- `numbers`, the rule's: a tuple of numbers and of sequences of numbers;
- `order`, what was drawn for the run before its first answer: a sequence of numbers, empty for most;
- `state`, what the rule keeps in mind: a tuple of numbers, each either whole or not for good;
- `answers` and `levels`, the history with the last answer: sequences of equal length.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, get_args

from .procedure import Ending

Numbers = tuple[Any, ...]
Order = Sequence[float]
State = tuple[Any, ...]
GOES_ON, CONVERGED, TRIALS, CENSORED_ABOVE, CENSORED_BELOW, ABORTED = range(6)
"""What `Transition.ending` returns."""
CENSORED = CENSORED_ABOVE
"""From here on no threshold is told."""
ENDINGS: tuple[Ending, ...] = get_args(Ending)
"""Those after `GOES_ON`."""


def ending_of(code: int) -> Ending | None:
    """
    >>> ending_of(GOES_ON), ending_of(CENSORED_BELOW)
    (None, 'censored_below')
    """
    return ENDINGS[code - 1] if code else None


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

    start: Callable[[Numbers, Order], State]
    level: Callable[[Numbers, Order, State], float]
    after: Callable[[Numbers, Order, State, Sequence[int], Sequence[float]], tuple[State, float]]
    ending: Callable[[Numbers, Order, State, Sequence[int]], int]
    threshold: Callable[[Sequence[float]], float]
