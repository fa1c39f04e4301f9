"""Whether an answer is one that its request can have: one of the options, on the scale, within the bounds."""

from collections.abc import Sequence
from functools import singledispatch

from ..trials.cell_rules import LARGEST_ANSWER
from .answer import Adjusted, Chosen, Filled, Rated
from .request import Adjust, Choose, Enter, Fill, Rate

SLACK = 1e-9
"""Steps from within may miss a bound by a rounding, in parts of the bounds."""


@singledispatch
def flaw(request: object, answer: object) -> str | None:
    """What is wrong with an answer, in words; None where nothing is.

    >>> flaw(Choose("felt", (0, 1), ("no", "yes")), Chosen(2, 0.0, 1.0))
    'the option 2, expected one of 0, 1'
    """
    del request, answer
    return None


@flaw.register
def _(request: Choose, answer: Chosen) -> str | None:
    if answer.option in request.options:
        return None
    return f"the option {answer.option}, expected one of {', '.join(map(str, request.options))}"


@flaw.register
def _(request: Enter, answer: Rated) -> str | None:
    return _beside((answer.value,), request.low, LARGEST_ANSWER if request.high is None else request.high)


@flaw.register
def _(request: Rate, answer: Rated) -> str | None:
    return _beside((answer.value,), request.low, request.high, SLACK)


@flaw.register
def _(request: Fill, answer: Filled) -> str | None:
    if len(answer.values) != len(request.questions):
        return f"{len(answer.values)} values, expected one for each of {len(request.questions)} questions"
    return _beside(answer.values, request.low, request.high, SLACK)


@flaw.register
def _(request: Adjust, answer: Adjusted) -> str | None:
    return _beside((answer.level,), request.low, request.high, SLACK)


def _beside(values: Sequence[float | None], low: float, high: float, slack: float = 0.0) -> str | None:
    """The first value that is beside its bounds."""
    least, most = low - slack * max(abs(low), abs(high)), high + slack * max(abs(low), abs(high))
    for value in values:
        if value is not None and not least <= value <= most:
            return f"the value {value:g}, expected from {low:g} to {high:g}"
    return None
