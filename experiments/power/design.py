"""Design of a power analysis: study, effect, participants and trials."""

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np

from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter
from tactometry.records.head import LARGEST_SEED

from .effect import StatedEffect

MOST_NUMBERS: Final = 7
"""Largest number of values tried for a range of participants without a step."""
FEWEST_PARTICIPANTS: Final = 3
MOST_PARTICIPANTS: Final = 999
_RANGE = re.compile(r"\s*(\d+)\s*\.\.\s*(\d+)(?:\s*:\s*(\d+))?\s*")
_WHOLE = re.compile(r"\s*\d{1,9}\s*")


@dataclass(frozen=True)
class Case:
    """Kind of study to simulate. `n_trials` None means: as in the study."""

    n_trials: int | None
    has_effect: bool

    @property
    def name(self) -> str:
        """Stem of the file names of the case.

        >>> Case(40, True).name, Case(None, False).name
        ('trials-40_effect', 'trials-study_none')
        """
        return f"trials-{self.n_trials or 'study'}_{'effect' if self.has_effect else 'none'}"


@dataclass(frozen=True)
class PowerDesign:
    """All inputs that determine a power analysis.

    - `study_toml`: Content of the study file.
    - `where`: Name of the study in errors.
    - `participants`: Numbers of participants to try, in increasing order. Only the largest study is simulated. Smaller
      studies consist of its first participants.
    - `trials`: Numbers of trials per track to try. None: as in the study.
    - `target`: Power to achieve.
    - `alpha`: Significance level of the test.
    - `precision`: Half width of a power's 95 % interval at which sampling stops.
    - `most`, `batch`: Largest number of simulated studies per case, and number of studies between checks whether to
      stop.
    - `dropout_share`: Probability that a participant drops out, at a uniformly drawn trial.
    - `dependent`: Dependent variable. If empty, the first one of the task's analysis.
    - `code_from`: Folder with the code of a custom observer.

    Raises
    ------
    InvalidParameter
        If a number is out of range.
    """

    study_toml: bytes
    where: str
    effect: StatedEffect
    participants: tuple[int, ...]
    trials: tuple[int | None, ...] = (None,)
    seed: int = 0
    target: float = 0.8
    alpha: float = 0.05
    precision: float = 0.05
    most: int = 1000
    batch: int = 20
    dropout_share: float = 0.0
    dependent: str = ""
    code_from: Path | None = None
    cases: tuple[Case, ...] = field(init=False)

    def __post_init__(self) -> None:
        _between_0_and_1("--target", self.target)
        _between_0_and_1("--alpha", self.alpha)
        expect(0 < self.precision < 0.5, "--precision", f"{self.precision:g}", "above 0 and below 0.5")
        expect(0 <= self.dropout_share < 1, "--dropout", f"{self.dropout_share:g}", "a share from 0 to below 1")
        expect(0 <= self.seed <= LARGEST_SEED, "--seed", self.seed, f"a whole number from 0 to {LARGEST_SEED}")
        expect(self.most >= 1, "--most", self.most, "at least 1")
        object.__setattr__(self, "cases", tuple(Case(n, yes) for n in self.trials for yes in (True, False)))

    @property
    def n_participants(self) -> int:
        """Largest number of participants."""
        return self.participants[-1]


def _between_0_and_1(name: str, value: float) -> None:
    expect(0 < value < 1, name, f"{value:g}", "above 0 and below 1")


def participants_of(text: str) -> tuple[int, ...]:
    """Parse numbers of participants: a list, or a range with optional step.

    Raises `InvalidParameter` if the text is invalid, or a range is descending.

    >>> participants_of("6..24"), participants_of("6..24:9"), participants_of("12, 8")
    ((6, 9, 12, 15, 18, 21, 24), (6, 15, 24), (8, 12))
    """
    where, expected = "--participants", "a range such as 6..24 or 6..24:2, or numbers such as 8,12,16"
    if match := _RANGE.fullmatch(text):
        low, high, step = int(match[1]), int(match[2]), int(match[3] or 0)
        expect(low <= high, where, f"{text!r}, a descending range", f"the lower number first, as {high}..{low}")
        numbers = _even_numbers(low, high) if not match[3] else range(low, high + 1, max(step, 1))
        expect(match[3] is None or step > 0, where, f"{text!r}, a step of 0", expected)
    else:
        numbers = _numbers(text, where, expected)
    result = tuple(sorted(set(numbers)))
    for n in result:
        fits = FEWEST_PARTICIPANTS <= n <= MOST_PARTICIPANTS
        expect(fits, where, n, f"from {FEWEST_PARTICIPANTS} to {MOST_PARTICIPANTS}")
    return result


def trials_of(text: str | None) -> tuple[int | None, ...]:
    """Parse numbers of trials, or return (None,) without any.

    >>> trials_of("60,40"), trials_of(None)
    ((40, 60), (None,))
    """
    if text is None:
        return (None,)
    numbers = _numbers(text, "--trials", "numbers such as 40,60")
    for n in numbers:
        expect(n >= 1, "--trials", n, "at least 1")
    return tuple(sorted(set(numbers)))


def _numbers(text: str, where: str, expected: str) -> list[int]:
    parts = text.split(",")
    if not all(map(_WHOLE.fullmatch, parts)):
        raise InvalidParameter(f"{where}: found {text!r}, expected {expected}")
    return [int(part) for part in parts]


def _even_numbers(low: int, high: int) -> list[int]:
    n = min(MOST_NUMBERS, high - low + 1)
    return [round(float(number)) for number in np.linspace(low, high, n)]
