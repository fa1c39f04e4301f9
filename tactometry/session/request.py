"""Requests of a protocol to a rig, their answer types, and answer checks.

A request names a stimulus and a level. It never contains samples.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, ClassVar, Final, Generic, Protocol, TypeVar, get_args

from ..trials.cells import LARGEST_ANSWER
from ..trials.trial import Key, Trial
from .answer import Adjusted, Chosen, Done, Filled, Intervention, Played, Rated, Touched

A = TypeVar("A")
Fact = str | int | float | bool | None
Facts = dict[str, Fact]
"""Facts about a display, devices or a clock for the journal, by name."""

TRAJECTORY_M = 0.1
"""One-way length of the path of a slide (unverified default)."""
CONSENT: Final = "agree"
"""Consent question; simulated participants agree."""
MISSED_PRACTICE: Final = "practice_missed"
"""Question to the experimenter after a failed practice."""
AGAIN, GO_ON, END_SESSION = 1, 2, 3
"""Options of this question. A simulated session continues."""
MISSED_LABELS: Final = {AGAIN: "again", GO_ON: "go_on", END_SESSION: "end_session"}
ABOUT: Final = "about."
"""Prefix of questions about the participant, which do not refer to a stimulus."""


class Request(Generic[A]):
    """Request to a rig, which answers with an `A`."""

    answer_type: ClassVar[type]

    def __init_subclass__(cls) -> None:
        for base in vars(cls).get("__orig_bases__", ()):
            (cls.answer_type,) = get_args(base)


class Rig(Protocol):
    """Interface of a rig, such as a bench, a simulation or a recording.

    Only a rig reads a clock. `resume` is called once, before the first live request of a resumed session. Its
    arguments are the recorded rows and the time at which the session stopped.
    """

    def facts(self) -> Facts:
        """Return facts on display, outputs and clock for the head of the journal."""

    def answer(self, request: Request[A]) -> A: ...

    def resume(self, trials: Sequence[Trial], elapsed_s: float) -> None: ...

    def close(self) -> None:
        """Set the output to zero and close the devices. May be called more than once."""


@dataclass(frozen=True)
class Play(Request[Played]):
    """Emit a stimulus without a condition on the finger."""

    stimulus: str
    level: float | None
    duration_s: float
    interval: int | None = None


@dataclass(frozen=True)
class Feel(Request[Touched]):
    """Hold a force for `hold_s`, then feel `level` while holding it.

    The force is `target_n` within `tolerance` (relative). A `level` of None is a blank: the same procedure without a
    signal. `timeout_s` limits the wait for the force.
    """

    stimulus: str
    level: float | None
    duration_s: float
    target_n: float
    tolerance: float
    hold_s: float
    timeout_s: float


@dataclass(frozen=True)
class Press(Feel):
    """`Feel` with a finger that rests."""

    interval: int | None = None


@dataclass(frozen=True)
class Slide(Feel):
    """`Feel` with a finger that follows a cursor.

    The cursor moves to and fro over `length_m` at `speed_m_per_s`. The stimulus plays while the speed is within
    `speed_tolerance` (relative) of its target; None disables this condition.
    """

    speed_m_per_s: float
    interval: int | None = None
    length_m: float = TRAJECTORY_M
    speed_tolerance: float | None = None


@dataclass(frozen=True)
class Choose(Request[Chosen]):
    """Ask for one of `options`.

    `question` names a message, such as ``"felt"``. `stimuli` names the stimulus of each option, if the question is
    which stimulus was felt.
    """

    question: str
    options: tuple[int, ...]
    labels: tuple[str, ...]
    stimuli: tuple[str, ...] = ()


@dataclass(frozen=True)
class Enter(Request[Rated]):
    """Ask for a number from `low` to `high` (None: no maximum)."""

    question: str
    low: float
    high: float | None = None


@dataclass(frozen=True)
class Question:
    """Item of a questionnaire.

    `words` contains, by language, the statement (may be empty) and the left and right labels. `reversed` means that
    the left end is the favourable one.
    """

    item: str
    words: Mapping[str, tuple[str, str, str]]
    reversed: bool = False


@dataclass(frozen=True)
class Fill(Request[Filled]):
    """Ask all questions of a questionnaire page.

    Answers range from `low` (left) to `high` in `steps` (None: continuous). `given` contains earlier answers to this
    page. The page is number `page` of `n_pages` with the same `stem` (by language). Fields that only affect the
    display are not compared.
    """

    form: str
    questions: tuple[Question, ...]
    low: float
    high: float
    steps: int | None
    stem: Mapping[str, str] = field(default_factory=dict, compare=False)
    page: int = field(default=1, compare=False)
    n_pages: int = field(default=1, compare=False)
    given: tuple[float | None, ...] = field(default=(), compare=False)


@dataclass(frozen=True)
class Adjust(Request[Adjusted]):
    """Let the participant set a level.

    The level begins at `start` and changes in steps of `step` within the bounds. `target_n` and `speed_m_per_s`
    state the touch that is asked of the participant, without a gate.
    """

    stimulus: str
    start: float
    step: float
    low: float
    high: float
    target_n: float | None = None
    speed_m_per_s: float | None = None

    def level(self, n_steps: int) -> float:
        return self.start + n_steps * self.step


@dataclass(frozen=True)
class Wait(Request[Done]):
    """Let time pass."""

    duration_s: float


@dataclass(frozen=True)
class Show(Request[Done]):
    """Show a page until it is left, or for `duration_s`."""

    message: str
    values: Mapping[str, str | int | float] = field(default_factory=dict)
    duration_s: float | None = None


@dataclass(frozen=True)
class Record(Request[Done]):
    """Record a finished trial. When it is answered, the row is on the disk.

    `aborted` is the reason if the track or block ends unfinished.
    """

    trial: Trial
    aborted: str | None = None


@dataclass(frozen=True)
class Intervene(Request[Done]):
    """Report the result `said` of an intervention.

    Rows of `retracted` trials no longer count.
    """

    intervention: Intervention
    said: str
    retracted: tuple[Key, ...] = ()


REQUESTS: Mapping[str, type[Request[Any]]] = {
    kind.__name__: kind for kind in (Play, Press, Slide, Choose, Enter, Fill, Adjust, Wait, Show, Record, Intervene)
}


_TRACE = re.compile(r"traces/[\w-]+\.tsv\.gz", re.ASCII)
SLACK = 1e-9
"""Rounding error allowed at a bound, relative to the bounds."""


def flaw(request: object, answer: object) -> str | None:
    """Return what is wrong with an answer, or None.

    >>> flaw(Choose("felt", (0, 1), ("no", "yes")), Chosen(2, 0.0, 1.0))
    'the option 2, expected one of 0, 1'
    """
    for part in getattr(answer, "trace", ()):
        if not _TRACE.fullmatch(part.file) or part.first_byte < 0 or part.n_bytes <= 0:
            return f"a trace in {part.file!r}, expected a part of a file in the folder traces"
    match request, answer:
        case Choose(options=options), Chosen(option) if option not in options:
            return f"the option {option}, expected one of {', '.join(map(str, options))}"
        case Enter(low=low, high=high), Rated(value):
            return _out_of_range((value,), low, LARGEST_ANSWER if high is None else high)
        case Fill(questions=questions), Filled(values) if len(values) != len(questions):
            return f"{len(values)} values, expected one for each of {len(questions)} questions"
        case Fill(low=low, high=high), Filled(values):
            return _out_of_range(values, low, high, SLACK)
        case Adjust(low=low, high=high), Adjusted(level):
            return _out_of_range((level,), low, high, SLACK)
    return None


def _out_of_range(values: Sequence[float | None], low: float, high: float, slack: float = 0.0) -> str | None:
    """Describe the first value that is out of range."""
    least, most = low - slack * max(abs(low), abs(high)), high + slack * max(abs(low), abs(high))
    for value in values:
        if value is not None and not least <= value <= most:
            return f"the value {value:g}, expected from {low:g} to {high:g}"
    return None


def value_at(place: int, n_places: int, low: float, high: float) -> float:
    """Return the value of a position on a scale, correctly rounded.

    >>> value_at(2, 7, low=1, high=7), value_at(1, 11, low=0.0, high=1.0)
    (3.0, 0.1)
    """
    return float(Fraction(low) + (Fraction(high) - Fraction(low)) * place / (n_places - 1))
