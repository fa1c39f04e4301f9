"""Whether an answer is one that its request can have: one of the options, on the scale, within the bounds."""

import re
from collections.abc import Sequence
from fractions import Fraction

from ..trials.cell_rules import LARGEST_ANSWER
from .answer import Adjusted, Chosen, Filled, Rated
from .request import Adjust, Choose, Enter, Fill, Rate

_TRACE = re.compile(r"traces/[\w-]+\.tsv\.gz", re.ASCII)
SLACK = 1e-9
"""Steps from within may miss a bound by a rounding, in parts of the bounds."""


def flaw(request: object, answer: object) -> str | None:
    """What is wrong with an answer, in words; None where nothing is.

    >>> flaw(Choose("felt", (0, 1), ("no", "yes")), Chosen(2, 0.0, 1.0))
    'the option 2, expected one of 0, 1'
    """
    for part in getattr(answer, "trace", ()):
        if not _TRACE.fullmatch(part.file) or part.first_byte < 0 or part.n_bytes <= 0:
            return f"a trace in {part.file!r}, expected a place in a file of the folder traces"
    match request, answer:
        case Choose(options=options), Chosen(option) if option not in options:
            return f"the option {option}, expected one of {', '.join(map(str, options))}"
        case Enter(low=low, high=high), Rated(value):
            return _beside((value,), low, LARGEST_ANSWER if high is None else high)
        case Rate(low=low, high=high), Rated(value):
            return _beside((value,), low, high, SLACK)
        case Fill(questions=questions), Filled(values) if len(values) != len(questions):
            return f"{len(values)} values, expected one for each of {len(questions)} questions"
        case Fill(low=low, high=high), Filled(values):
            return _beside(values, low, high, SLACK)
        case Adjust(low=low, high=high), Adjusted(level):
            return _beside((level,), low, high, SLACK)
    return None


def _beside(values: Sequence[float | None], low: float, high: float, slack: float = 0.0) -> str | None:
    """The first value that is beside its bounds."""
    least, most = low - slack * max(abs(low), abs(high)), high + slack * max(abs(low), abs(high))
    for value in values:
        if value is not None and not least <= value <= most:
            return f"the value {value:g}, expected from {low:g} to {high:g}"
    return None


def value_at(place: int, n_places: int, low: float, high: float) -> float:
    """The value of a place (0..n_places-1) on a scale from `low` to `high`, correctly rounded: whole steps stay whole.

    >>> value_at(2, 7, low=1, high=7), value_at(1, 11, low=0.0, high=1.0)
    (3.0, 0.1)
    """
    return float(Fraction(low) + (Fraction(high) - Fraction(low)) * place / (n_places - 1))
