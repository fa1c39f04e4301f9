"""One row of the trials table."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final, Literal, get_args

Value = str | int | float | bool | None
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
"""Why a touch or an answer does not count."""
REASONS: Final[tuple[str, ...]] = get_args(Reason)
REASON_WORDS: Final[Mapping[Reason, str]] = {
    "too_light": "too light",
    "too_heavy": "too heavy",
    "stopped": "the finger stopped",
    "too_slow": "too slow",
    "too_fast": "too fast",
    "lifted": "the finger left",
    "timeout": "no force was held in time",
    "sensor_lost": "the sensor was silent",
    "output_gap": "a gap in the output",
    "experimenter": "as the experimenter wanted",
}


@dataclass(frozen=True)
class Trial:
    """What one trial asked, and what came back; `None` means not measured (an empty cell).

    `factors` keep their names and order of the study file. Times are seconds since the start of the session on the
    rig's monotonic clock; `timestamp_utc` is ISO 8601, empty for a rig that lives in simulated time.
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
    extra: Mapping[str, Value] = field(default_factory=dict)

    @property
    def is_form(self) -> bool:
        """Whether it is an answer to a questionnaire on its own, which is no trial: nothing was to be felt.

        >>> Trial(1, 1, {}, "sus", None, "", "rating", 3.0, item="SUS1").is_form
        True
        """
        return self.task == "rating" and self.level is None


def validity(trial: Trial) -> str:
    """Whether a trial counts, in words.

    >>> validity(Trial(1, 1, {}, "staircase", 5.0, "V", "yes_no", None, valid=False, invalid_reason="too_light"))
    'not valid: too light'
    """
    if trial.valid:
        return "valid"
    return "not valid" if trial.invalid_reason is None else f"not valid: {REASON_WORDS[trial.invalid_reason]}"


def n_presented(trials: Iterable[Trial]) -> int:
    """How many trials there were: the rows of one are one, and those of questionnaires on their own are none.

    >>> from dataclasses import replace
    >>> item = Trial(1, 1, {}, "sus", 20.0, "dB", "rating", 3.0, item="SUS1")
    >>> n_presented([item, replace(item, item="SUS2"), replace(item, trial=2, level=None)])
    1
    """
    return len({(trial.block, trial.trial, trial.attempt) for trial in trials if not trial.is_form})
