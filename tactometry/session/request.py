"""What a protocol may ask of a rig, each with the type of its answer.

A request *describes*: it names a stimulus and a level, never samples. `put_to` calls the one method of the rig that
answers this request, so that no loop and no rig branches on a kind.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, Protocol

from ..trials.trial import Reason, Trial

if TYPE_CHECKING:
    from ..rigs.rig import Rig


TRAJECTORY_M = 0.1
"""Length of the path of a slide, one way (unverified default)."""


@dataclass(frozen=True)
class Done:
    """The answer of a request that has nothing to report but its time (s since the session's start)."""

    at_s: float


@dataclass(frozen=True)
class Played:
    """What an output emitted: `level_delivered` in the stimulus's unit, `digest` of the samples, `n_gaps` in it."""

    onset_s: float
    level_delivered: float | None
    digest: str
    n_gaps: int | None = None


@dataclass(frozen=True)
class Touched:
    """What a finger did while a stimulus played, and what was emitted.

    `force_in_band` is the part (0..1) of the samples whose running mean was inside the band, `speed_in_band` that of
    the speeds. `valid` is false if the touch broke its conditions or the experimenter asked for a repetition, for
    `invalid_reason`: the protocol then asks again. `n_gaps` counts the gaps of the output; None where it cannot tell.
    """

    onset_s: float
    level_delivered: float | None
    digest: str | None
    force_mean_n: float | None = None
    force_sd_n: float | None = None
    force_in_band: float | None = None
    speed_mean_m_per_s: float | None = None
    valid: bool = True
    speed_in_band: float | None = None
    invalid_reason: Reason | None = None
    n_gaps: int | None = None


@dataclass(frozen=True)
class Chosen:
    """One of the options that were offered; `latency_s` from the onset of the question.

    An answer is not `valid` if the experimenter asked for a repetition meanwhile.
    """

    option: int
    onset_s: float
    latency_s: float
    timestamp_utc: str | None = None
    valid: bool = True


@dataclass(frozen=True)
class Rated:
    """A point of a scale, or a number."""

    value: float | None
    onset_s: float
    latency_s: float
    timestamp_utc: str | None = None
    valid: bool = True


@dataclass(frozen=True)
class Filled:
    """The answers of a page of a questionnaire, in the order of its questions; None where one was left open."""

    values: tuple[float | None, ...]
    onset_s: float
    latency_s: float
    timestamp_utc: str | None = None
    valid: bool = True


@dataclass(frozen=True)
class Adjusted:
    """The level that the participant left standing."""

    level: float
    onset_s: float
    latency_s: float
    timestamp_utc: str | None = None
    valid: bool = True
    n_gaps: int | None = None


class Request(Protocol):
    """One thing asked of the rig."""

    answer: ClassVar[type]

    def put_to(self, rig: "Rig") -> object: ...


@dataclass(frozen=True)
class Play:
    """Emit a stimulus, with no condition on the finger."""

    stimulus: str
    level: float | None
    duration_s: float
    interval: int | None = None

    answer: ClassVar[type] = Played

    def put_to(self, rig: "Rig") -> Played:
        return rig.play(self)


@dataclass(frozen=True)
class Press:
    """Hold `target_n` within `tolerance` (relative) for `hold_s`, then feel `level` while the force is held.

    `level` None is a blank: the same course with nothing emitted. `timeout_s` bounds the wait for the held force.
    """

    stimulus: str
    level: float | None
    duration_s: float
    target_n: float
    tolerance: float
    hold_s: float
    timeout_s: float
    interval: int | None = None

    answer: ClassVar[type] = Touched

    def put_to(self, rig: "Rig") -> Touched:
        return rig.press(self)


@dataclass(frozen=True)
class Slide:
    """As `Press`, with a finger that follows a cursor out and back over `length_m` at `speed_m_per_s`.

    The stimulus plays in motion only: while the speed is within `speed_tolerance` (relative) of its target. None
    leaves the speed to the finger.
    """

    stimulus: str
    level: float | None
    duration_s: float
    target_n: float
    tolerance: float
    hold_s: float
    timeout_s: float
    speed_m_per_s: float
    interval: int | None = None
    length_m: float = TRAJECTORY_M
    speed_tolerance: float | None = None

    answer: ClassVar[type] = Touched

    def put_to(self, rig: "Rig") -> Touched:
        return rig.slide(self)


@dataclass(frozen=True)
class Choose:
    """Ask for one of `options`; `question` names a message, e.g. ``"felt"`` or ``"which_interval"``.

    `stimuli` names what each option stands for, where the question is which of several stimuli was felt.
    """

    question: str
    options: tuple[int, ...]
    labels: tuple[str, ...]
    stimuli: tuple[str, ...] = ()

    answer: ClassVar[type] = Chosen

    def put_to(self, rig: "Rig") -> Chosen:
        return rig.choose(self)


@dataclass(frozen=True)
class Rate:
    """Ask for a point between `low` and `high` in `steps` (None: continuous), with a word at each end."""

    item: str
    low: float
    high: float
    steps: int | None
    low_label: str
    high_label: str

    answer: ClassVar[type] = Rated

    def put_to(self, rig: "Rig") -> Rated:
        return rig.rate(self)


@dataclass(frozen=True)
class Enter:
    """Ask for a number of at least `low` and, unless it is None, at most `high`; `question` names a message."""

    question: str
    low: float
    high: float | None = None

    answer: ClassVar[type] = Rated

    def put_to(self, rig: "Rig") -> Rated:
        return rig.enter(self)


@dataclass(frozen=True)
class Question:
    """An item of a questionnaire: by language its statement (may be empty), its left and its right word.

    `reversed` says that the good end is the left one.
    """

    item: str
    words: Mapping[str, tuple[str, str, str]]
    reversed: bool = False


@dataclass(frozen=True)
class Fill:
    """Ask for all questions of a page, each from `low` (left) to `high` in `steps` (None: continuous).

    No question has an answer beforehand; each can be changed until the page is left; a page with open questions is
    left at the second wish only.
    """

    form: str
    questions: tuple[Question, ...]
    low: float
    high: float
    steps: int | None

    answer: ClassVar[type] = Filled

    def put_to(self, rig: "Rig") -> Filled:
        return rig.fill(self)


@dataclass(frozen=True)
class Adjust:
    """Let the participant set the level of a stimulus, from `start` in steps of `step` within the bounds.

    `target_n` and `speed_m_per_s` say how it should be touched meanwhile; nothing is gated on them.
    """

    stimulus: str
    start: float
    step: float
    low: float
    high: float
    target_n: float | None = None
    speed_m_per_s: float | None = None

    def level(self, n_steps: int) -> float:
        """The level so many steps above the start."""
        return self.start + n_steps * self.step

    answer: ClassVar[type] = Adjusted

    def put_to(self, rig: "Rig") -> Adjusted:
        return rig.adjust(self)


@dataclass(frozen=True)
class Wait:
    """Let time pass."""

    duration_s: float

    answer: ClassVar[type] = Done

    def put_to(self, rig: "Rig") -> Done:
        return rig.wait(self)


@dataclass(frozen=True)
class Show:
    """Show a page until it is left, or for `duration_s`. `message` names a text of the study; `values` fill it."""

    message: str
    values: Mapping[str, str | int | float] = field(default_factory=dict)
    duration_s: float | None = None

    answer: ClassVar[type] = Done

    def put_to(self, rig: "Rig") -> Done:
        return rig.show(self)


@dataclass(frozen=True)
class Record:
    """A finished trial. Once it is answered, the row is on the disk.

    `aborted` says why what was under way ends unfinished with it.
    """

    trial: Trial
    aborted: str | None = None

    answer: ClassVar[type] = Done

    def put_to(self, rig: "Rig") -> Done:
        return rig.record(self)


REQUESTS: Mapping[str, type[Request]] = {
    kind.__name__: kind for kind in (Play, Press, Slide, Choose, Rate, Enter, Fill, Adjust, Wait, Show, Record)
}
