"""Row of the trials table."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import reduce
from typing import Final, Literal, get_args

from ..errors import count_of
from .cells import Value
from .tasks import FORM_TASK

Key = tuple[int, int, int]
"""Block, trial and attempt, which all rows of one trial share."""
Reason = Literal[
    "too_light",
    "too_heavy",
    "stopped",
    "too_slow",
    "too_fast",
    "lifted",
    "timeout",
    "sensor_lost",
    "output_gap",
    "experimenter",
]
"""Reason why a touch or an answer is invalid."""
REASONS: Final[tuple[str, ...]] = get_args(Reason)


@dataclass(frozen=True)
class Trial:
    """Request and result of one trial. None means not measured (empty cell).

    `factors` have the names and the order of the study file. Times are seconds since the start of the session.
    `timestamp_utc` is ISO 8601, empty in simulated time.
    """

    block: int
    trial: int
    factors: Mapping[str, float | str]
    procedure: str
    level: float | None
    level_unit: str
    task: str
    response: float | str | None
    correct: bool | None = None
    onset_s: float | None = None
    latency_s: float | None = None
    force_mean_n: float | None = None
    force_sd_n: float | None = None
    force_in_band: float | None = None
    valid: bool = True
    timestamp_utc: str | None = None
    track: str | None = None
    attempt: int = 1
    catch: bool | None = None
    item: str | None = None
    level_delivered: float | None = None
    level_measured: float | None = None
    speed_target_m_per_s: float | None = None
    speed_mean_m_per_s: float | None = None
    target: int | None = None
    standard_level: float | None = None
    item_b: str | None = None
    practice: bool | None = None
    speed_in_band: float | None = None
    invalid_reason: Reason | None = None
    n_gaps: int | None = None
    positions_digest: str | None = None
    positions_late: float | None = None
    separation_m: float | None = None
    error_m: float | None = None
    extra: Mapping[str, Value] = field(default_factory=dict)

    @property
    def key(self) -> Key:
        return self.block, self.trial, self.attempt

    @property
    def is_form(self) -> bool:
        """True for an answer to a questionnaire without a stimulus.

        >>> Trial(1, 1, {}, "sus", None, "", "rating", 3.0, item="SUS1").is_form
        True
        """
        return self.task == FORM_TASK and self.level is None


def without(trials: Iterable[Trial], retracted: Collection[Key]) -> tuple[Trial, ...]:
    """Return the rows, with those of `retracted` trials marked as invalid.

    >>> without([Trial(1, 1, {}, "staircase", 5.0, "V", "yes_no", 1, correct=True)], {(1, 1, 1)})[0].invalid_reason
    'experimenter'
    """
    return tuple(
        replace(trial, valid=False, correct=None, invalid_reason="experimenter")
        if trial.valid and trial.key in retracted
        else trial
        for trial in trials
    )


@dataclass(frozen=True)
class Tally:
    """Counts of presentations, trials and answers to questionnaires.

    Several rows of one presentation count once, and repeated attempts are one trial.
    """

    n_presented: int = 0
    n_invalid: int = 0
    n_answers: int = 0
    last: Key | None = None
    n_again: int = 0

    @property
    def n_trials(self) -> int:
        return self.n_presented - self.n_again

    def after(self, trial: Trial) -> "Tally":
        """Add a row."""
        if trial.is_form:
            return replace(self, n_answers=self.n_answers + 1)
        if trial.key == self.last:
            return self
        n_invalid, n_again = self.n_invalid + (not trial.valid), self.n_again + (trial.attempt > 1)
        return Tally(self.n_presented + 1, n_invalid, self.n_answers, trial.key, n_again)

    def __str__(self) -> str:
        invalid = f", {self.n_invalid} of them not valid" if self.n_invalid else ""
        answers = f", and {count_of(self.n_answers, 'answer')} to questionnaires" if self.n_answers else ""
        presented = f" in {count_of(self.n_presented, 'presentation')}" if self.n_again else ""
        return f"{count_of(self.n_trials, 'trial')}{presented}{invalid}{answers}"


def tally(trials: Iterable[Trial]) -> Tally:
    return reduce(Tally.after, trials, Tally())
