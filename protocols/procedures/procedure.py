"""What every rule for the next level is."""

from typing import Literal, Protocol, Self

import numpy as np

from tactometry.arguments.require import is_number
from tactometry.errors import InvalidParameter

MOST_TRIALS = 1_000_000
"""More make no session: at 5 s each they last 58 days."""
Ending = Literal["converged", "trials", "censored_above", "censored_below", "aborted"]


class Procedure(Protocol):
    """A frozen, pure rule for the next level.

    `after` gives the procedure that follows a response (1 or True: correct, or "felt") to the level that was
    *delivered*, which counts whether or not it is the one that was asked for. A finished procedure says by `ended` how
    it came to its end. `threshold` is what the rule itself makes of the answers so far; None where it makes nothing of
    them, or they only bound it.
    """

    @property
    def name(self) -> str: ...

    @property
    def level(self) -> float: ...

    @property
    def finished(self) -> bool: ...

    @property
    def ended(self) -> Ending | None: ...

    @property
    def threshold(self) -> float | None: ...

    def after(self, response: int | bool, delivered: float | None = None) -> Self: ...


def checked_response(response: object, procedure: str) -> bool:
    """`response` as a truth value.

    Raises
    ------
    InvalidParameter
        If it is anything but 0, 1, False or True: an unanswered trial must be asked again, not counted as wrong.
    """
    if isinstance(response, int | float | np.bool_ | np.number) and response in (0, 1):
        return bool(response)
    raise InvalidParameter(
        f"{procedure}.after: found the response {response!r}, expected 1 (correct, felt) or 0; ask the trial again if "
        "it was not answered"
    )


def checked_outcome(response: object, n_outcomes: int, procedure: str) -> int:
    """`response` as the number of an outcome, from 0.

    Raises
    ------
    InvalidParameter
        If it is none of them.
    """
    if n_outcomes == 2:
        return int(checked_response(response, procedure))
    if isinstance(response, int | np.integer) and 0 <= response < n_outcomes:
        return int(response)
    raise InvalidParameter(
        f"{procedure}.after: found the response {response!r}, expected a whole number from 0 to {n_outcomes - 1}"
    )


def finite_level(level: float, procedure: str) -> float:
    """`level`, if it is a finite number.

    Raises
    ------
    InvalidParameter
        If it is not.
    """
    if is_number(level):
        return level
    raise InvalidParameter(f"{procedure}.after: found the delivered level {level!r:.60}, expected a finite number")


def refuse_finished(*, finished: bool, procedure: str) -> None:
    """Raise if a finished procedure is asked to go on."""
    if finished:
        raise InvalidParameter(f"{procedure}.after: the procedure has finished, expected no further response")
