"""What a rig may answer, each the type of the answer to one or several kinds of request."""

from dataclasses import dataclass

from ..trials.trial import Reason
from .intervention import Intervention


@dataclass(frozen=True)
class Done:
    """The answer of a request that has nothing to report but its time (s since the session's start), and what the
    experimenter wanted meanwhile."""

    at_s: float
    interventions: tuple[Intervention, ...] = ()


@dataclass(frozen=True)
class TracePart:
    """Where samples of a touch are kept: `n_bytes` from `first_byte` of a `file` of the data set, and their digest.

    `rate_hz` is that of samples whose first one is that of the onset; None where each row has a stamp of its own.
    """

    file: str
    first_byte: int
    n_bytes: int
    digest: str
    rate_hz: float | None = None


@dataclass(frozen=True)
class Played:
    """What an output emitted: `level_delivered` in the stimulus's unit, `digest` of the samples, `n_gaps` in it.

    `trace` says where samples of the sensors are kept, and what was emitted if it followed a finger.
    """

    onset_s: float
    level_delivered: float | None
    digest: str
    n_gaps: int | None = None
    trace: tuple[TracePart, ...] = ()


@dataclass(frozen=True)
class Touched:
    """What a finger did while a stimulus played, and what was emitted.

    `force_in_band` is the part (0..1) of the samples whose running mean was inside the band, `speed_in_band` that of
    the speeds. `valid` is false if the touch broke its conditions or the experimenter asked for a repetition, for
    `invalid_reason`: the protocol then asks again. `n_gaps` counts the gaps of the output; None where it cannot tell.
    Of a stimulus that followed the finger `positions_digest` is that of the places, `positions_late` the part (0..1) of
    the samples whose place came too late. `gate_s` is the stamp of the sample that opened the gate, None without one;
    `trace` as in `Played`.
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
        """Whether it came to its stimulus, or to the blank in place of one: behind a gate that stayed shut it did not.

        >>> from dataclasses import replace
        >>> lost = Touched(0.0, None, None, valid=False, invalid_reason="sensor_lost")
        >>> lost.played, replace(lost, gate_s=1.0).played, replace(lost, invalid_reason="timeout").played
        (False, True, False)
        """
        is_shut = self.gate_s is None and self.digest is None
        return self.invalid_reason != "timeout" and not (self.invalid_reason == "sensor_lost" and is_shut)


class Answer:
    """What a participant answered to a question; it is put again unless this is `valid`."""

    onset_s: float
    latency_s: float
    timestamp_utc: str | None
    valid: bool
    n_gaps: int | None = None

    @property
    def invalid_reason(self) -> Reason | None:
        """Why it does not count: its stimulus had gaps, or else the experimenter asked for a repetition."""
        if self.valid:
            return None
        return "output_gap" if self.n_gaps else "experimenter"


@dataclass(frozen=True)
class Chosen(Answer):
    """One of the options that were offered; `latency_s` from the onset of the question.

    An answer is not `valid` if the experimenter asked for a repetition meanwhile.
    """

    option: int
    onset_s: float
    latency_s: float
    timestamp_utc: str | None = None
    valid: bool = True


@dataclass(frozen=True)
class Rated(Answer):
    """A point of a scale, or a number."""

    value: float | None
    onset_s: float
    latency_s: float
    timestamp_utc: str | None = None
    valid: bool = True


@dataclass(frozen=True)
class Filled(Answer):
    """The answers of a page of a questionnaire, in the order of its questions; None where one was left open.

    `back`: it was left for the page before, and comes again.
    """

    values: tuple[float | None, ...]
    onset_s: float
    latency_s: float
    timestamp_utc: str | None = None
    valid: bool = True
    back: bool = False


@dataclass(frozen=True)
class Marked:
    """What stood at `at_s` on a page of the questionnaire `form` that nobody has left yet."""

    form: str
    values: tuple[float | None, ...]
    at_s: float


@dataclass(frozen=True)
class Adjusted(Answer):
    """The level that the participant left standing."""

    level: float
    onset_s: float
    latency_s: float
    timestamp_utc: str | None = None
    valid: bool = True
    n_gaps: int | None = None
    trace: tuple[TracePart, ...] = ()
