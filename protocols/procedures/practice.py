"""Practice until a criterion is met."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, get_args

from tactometry.arguments.constraints import constrained
from tactometry.arguments.require import expect, numbers, one_of, some
from tactometry.trials.tasks import PRACTICE_CRITERION

from .procedure import Count
from .stepping import CONVERGED, GOES_ON, TRIALS, Order, State, SteppingRule, Transition


class PracticeNumbers(NamedTuple):
    """Numbers of the rule, whose state is the number of answers."""

    levels: tuple[float, ...]
    n_correct: int
    n_of: int
    n_trials: int


def _level(numbers: PracticeNumbers, order: Order, state: State) -> float:
    n_answers: int = state[0]
    return numbers.levels[n_answers % len(numbers.levels)]


def _ending(numbers: PracticeNumbers, order: Order, state: State, answers: Sequence[int]) -> int:
    if sum(answers[-numbers.n_of :]) >= numbers.n_correct:
        return CONVERGED
    return TRIALS if len(answers) >= numbers.n_trials else GOES_ON


OnMiss = Literal["go_on", "ask"]


@dataclass(frozen=True)
@constrained
class Practice(SteppingRule[Any]):
    """Easy levels in turn until `n_correct` of the last `n_of` are right.

    It ends as ``converged`` if the criterion was met, else as ``trials``.

    - `levels`: Easy levels, presented in turn.
    - `n_correct`: Number of correct answers among the last `n_of` at which the practice ends.
    - `n_of`: Number of most recent answers in which correct ones are counted.
    - `n_trials`: Largest number of trials. The practice then ends without its criterion.
    - `on_miss`: What happens after a failed practice. With ``ask``, the experimenter chooses to repeat it, to continue,
      or to end the session. With ``go_on`` the session continues.

    >>> rule = Practice(levels=(40.0, 30.0), n_correct=2, n_of=3, n_trials=10)
    >>> rule.after(1).level, rule.after(1).after(0).after(1).ending
    (30.0, 'converged')
    """

    levels: tuple[float, ...]
    n_correct: Count = PRACTICE_CRITERION[0]
    n_of: Count = PRACTICE_CRITERION[1]
    n_trials: Count = 20
    on_miss: OnMiss = "go_on"

    name = "practice"
    transition = Transition(_level, _ending)
    _named = PracticeNumbers
    unreplayed = "practice measures nothing"

    def __post_init__(self) -> None:
        numbers("Practice.levels", self.levels)
        some("Practice.levels", self.levels)
        one_of("Practice.on_miss", self.on_miss, get_args(OnMiss))
        for name, most in (("n_correct", "n_of"), ("n_of", "n_trials")):
            number, highest = getattr(self, name), getattr(self, most)
            possible = f"from 1 to {highest}, {most}; it must be possible to meet the criterion"
            expect(number <= highest, f"Practice.{name}", number, possible)
