"""Answers of a rig to requests, and interventions of the experimenter.

Interventions take effect between two trials.
"""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, Literal, get_args

from ..arguments.require import one_of
from ..trials.trial import Key, Reason

Wanted = Literal["invalidate", "skip", "rest", "end"]
WANTED: Final[tuple[str, ...]] = get_args(Wanted)


@dataclass(frozen=True)
class Intervention:
    """Order of the experimenter: discard a trial, skip the block, rest, or end.

    `trial` identifies the discarded trial: block, number, attempt.
    """

    wanted: Wanted
    trial: Key | None = None

    def __post_init__(self) -> None:
        one_of("Intervention.wanted", self.wanted, WANTED)


def left(wanted: Iterable[Intervention], carried: Iterable[Intervention]) -> tuple[Intervention, ...]:
    """Return the interventions that were not carried out, in order.

    >>> skip, rest = Intervention("skip"), Intervention("rest")
    >>> left([skip, rest, skip], [skip])
    (Intervention(wanted='rest', trial=None), Intervention(wanted='skip', trial=None))
    """
    known = Counter(carried)
    missing = []
    for each in wanted:
        if known[each]:
            known[each] -= 1
        else:
            missing.append(each)
    return tuple(missing)


@dataclass(frozen=True)
class Done:
    """Answer with a time (s since the session's start) and interventions only."""

    at_s: float
    interventions: tuple[Intervention, ...] = ()


@dataclass(frozen=True)
class TracePart:
    """Place of the samples of a touch within a `file` of the data set.

    They are `n_bytes` from `first_byte`, with their digest. `rate_hz` is the rate of samples that begin at the
    onset; None if each row has a time stamp.
    """

    file: str
    first_byte: int
    n_bytes: int
    digest: str
    rate_hz: float | None = None


@dataclass(frozen=True)
class Played:
    """Emission: delivered level in its unit, digest of the samples, and gaps.

    `trace` is the place of the sensor samples, and of the emitted signal if it followed a finger.
    """

    onset_s: float
    level_delivered: float | None
    digest: str
    n_gaps: int | None = None
    trace: tuple[TracePart, ...] = ()


@dataclass(frozen=True)
class Touched:
    """Force and motion of a finger during a stimulus, and the emission.

    - `force_in_band`, `speed_in_band`: Fraction (0..1) of the samples in the band.
    - `valid`, `invalid_reason`: False and the reason for an invalid touch, which is repeated.
    - `n_gaps`: Gaps of the output, or None if they are unknown.
    - `positions_digest`, `positions_late`: For a stimulus that followed the finger, the digest of the positions, and
      the fraction (0..1) that arrived late.
    - `gate_s`: Time stamp of the sample that opened the gate.
    - `trace`: As in `Played`.
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
    positions_digest: str | None = None
    positions_late: float | None = None
    gate_s: float | None = None
    trace: tuple[TracePart, ...] = ()

    @property
    def played(self) -> bool:
        """True if the stimulus or blank was reached, False if the gate never opened.

        >>> from dataclasses import replace
        >>> lost = Touched(0.0, None, None, valid=False, invalid_reason="sensor_lost")
        >>> lost.played, replace(lost, gate_s=1.0).played, replace(lost, invalid_reason="timeout").played
        (False, True, False)
        """
        is_shut = self.gate_s is None and self.digest is None
        return self.invalid_reason != "timeout" and not (self.invalid_reason == "sensor_lost" and is_shut)


class Answer:
    """Answer to a question. If it is not `valid`, the question is repeated."""

    onset_s: float
    latency_s: float
    timestamp_utc: str | None
    valid: bool
    n_gaps: int | None = None

    @property
    def invalid_reason(self) -> Reason | None:
        """Return why the answer is invalid (gaps, or a repetition), or None."""
        if self.valid:
            return None
        return "output_gap" if self.n_gaps else "experimenter"


@dataclass(frozen=True)
class Chosen(Answer):
    """Selected option. `latency_s` counts from the onset of the question."""

    option: int
    onset_s: float
    latency_s: float
    timestamp_utc: str | None = None
    valid: bool = True


@dataclass(frozen=True)
class Rated(Answer):
    """Point on a scale, or a number."""

    value: float | None
    onset_s: float
    latency_s: float
    timestamp_utc: str | None = None
    valid: bool = True


@dataclass(frozen=True)
class Filled(Answer):
    """Answers on a questionnaire page, in the order of its questions.

    An unanswered question is None. `back` means that the participant returned to the previous page, so that this
    page will be shown again.
    """

    values: tuple[float | None, ...]
    onset_s: float
    latency_s: float
    timestamp_utc: str | None = None
    valid: bool = True
    back: bool = False


@dataclass(frozen=True)
class Marked:
    """Marks at `at_s` on an unfinished page of the questionnaire `form`."""

    form: str
    values: tuple[float | None, ...]
    at_s: float


@dataclass(frozen=True)
class Adjusted(Answer):
    """Level that the participant set."""

    level: float
    onset_s: float
    latency_s: float
    timestamp_utc: str | None = None
    valid: bool = True
    n_gaps: int | None = None
    trace: tuple[TracePart, ...] = ()
