"""What every rule for the next level is."""

from typing import Literal, Protocol, Self

import numpy as np

from tactometry.errors import InvalidParameter

Ending = Literal["converged", "trials", "censored_above", "censored_below", "aborted"]


class Procedure(Protocol):
    """A frozen, pure rule for the next level.

    `after` gives the procedure that follows a response (1 or True: correct, or "felt") to the level that was
    *delivered*, which counts whether or not it is the one that was asked for. A finished procedure says by `ended` how
    it came to its end.
    """

    @property
    def name(self) -> str: ...

    @property
    def level(self) -> float: ...

    @property
    def finished(self) -> bool: ...

    @property
    def ended(self) -> Ending | None: ...

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


def refuse_finished(*, finished: bool, procedure: str) -> None:
    """Raise if a finished procedure is asked to go on."""
    if finished:
        raise InvalidParameter(f"{procedure}.after: the procedure has finished, expected no further response")
