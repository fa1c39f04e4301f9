"""Events of a session: pauses, remarks, clocks, stimuli, frame statistics."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, Literal, Protocol, get_args

import msgspec

from ..errors import InvalidParameter
from ..safety.limits import Exposure
from ..signal import FloatArray
from ..trials.columns import Column
from ..trials.tasks import PRACTICE_MISSED
from .answer import WANTED, Intervention, Marked, TracePart
from .request import MISSED_LABELS, Fact, Request

Kind = Literal[
    "trial",
    "clock",
    "pause",
    "resume",
    "remark",
    "repeat",
    "stop",
    "abort",
    "stimulus",
    "stimulus_end",
    "order",
    "intervention",
    "dry_run",
]
KINDS: Final[tuple[str, ...]] = get_args(Kind)
TraceKind = Literal["force", "position", "emitted"]
"""Kinds of samples of a touch. `force` and `position` have a time stamp (s of the session) and values (N, or m along
each axis). `emitted` is the output (V on each channel) from the onset, without time stamps."""
TRACE_KINDS: Final[tuple[TraceKind, ...]] = get_args(TraceKind)

FACTS: Final = (
    Column("block", "Number of the block"),
    Column("trial", "Number of the trial"),
    Column("attempt", "Number of the attempt at this trial, from 1"),
    Column("n_frames", "Frames of the screen since the trial or the questionnaire before"),
    Column("n_dropped_frames", "Frames that were not shown in time: whole periods that an interval was too long"),
    Column("frame_interval_median_s", "Median interval between frames", "s"),
    Column("frame_interval_p99_s", "99th percentile of the intervals between frames", "s"),
    Column("frame_interval_max_s", "Longest interval between frames", "s"),
    Column(
        "gate_delay_s", "From the stamp of the sample that opened the gate to the decision, longest of the trial", "s"
    ),
    Column("key_to_record_s", "From the last key or touch of the trial to its row on the disk", "s"),
    Column("device", "Whose clock, of a row of kind clock: a sensor, output, keyboard or utc"),
    Column("clock_offset_s", "Session's clock (time.perf_counter) minus that of the device", "s"),
    Column("clock_drift", "Seconds that the session's clock gained per second since the first such row of the sitting"),
    Column(
        "charge_c",
        "Charge through the leak of the load: of kind stimulus the largest that any beginning of it passes, of kind "
        "stimulus_end what it passed",
        "C",
    ),
    Column(
        "text",
        "The remark; who or what caused a pause, a repetition or a stop; what ends unfinished, and why; what is wanted "
        "of the course of the session, and what came of it; which touch was tried in a dry run, and how it went",
    ),
)
COLUMNS: Final = (
    Column("onset", "When it happened since the start of the session", "s"),
    Column("duration", "How long a stimulus lasts unless something stops it; n/a: a moment", "s"),
    Column("trial_type", f"One of {', '.join(KINDS)}"),
    *FACTS,
    Column("timestamp_utc", "Coordinated universal time, ISO 8601"),
)
"""Columns of an events file, named as in BIDS."""


@dataclass(frozen=True)
class Event:
    """Moment of a session, or a stimulus of `duration_s`.

    The names of `facts` are those of `FACTS`. Raises `InvalidParameter` if a fact has another name, or a number is not
    finite.

    >>> Event("remark", 12.5, facts={"text": "coughed"}).cells()[:3]
    ['12.5', 'n/a', 'remark']
    """

    kind: Kind
    at_s: float
    timestamp_utc: str | None = None
    facts: Mapping[str, Fact] = field(default_factory=dict)
    duration_s: float | None = None

    def __post_init__(self) -> None:
        names = {column.name for column in FACTS}
        wrong = {
            name: value
            for name, value in self.facts.items()
            if name not in names or (isinstance(value, float) and not math.isfinite(value))
        }
        if wrong:
            raise InvalidParameter(f"event {self.kind!r}: found {wrong}, expected names in FACTS and finite numbers")
        if self.duration_s is not None and not 0 <= self.duration_s < math.inf:
            raise InvalidParameter(f"event {self.kind!r}: found a duration of {self.duration_s} s, expected at least 0")

    def cells(self, columns: Sequence[Column] = COLUMNS) -> list[str]:
        """Return the event's row of an events file, with n/a for unknown values."""
        known: dict[str, Fact] = {
            "onset": self.at_s,
            "duration": self.duration_s,
            "trial_type": self.kind,
            "timestamp_utc": self.timestamp_utc,
            **self.facts,
        }
        return [_cell(known.get(column.name)) for column in columns]


def trial_facts(intervention: Intervention) -> dict[str, Fact]:
    """Return the trial of an intervention as facts of an event."""
    return dict(zip(("block", "trial", "attempt"), intervention.trial or (), strict=False))


def order_facts(intervention: Intervention) -> dict[str, Fact]:
    """Return an intervention as facts of an event of kind ``order``."""
    return {**trial_facts(intervention), "text": intervention.wanted}


def missed_text(option: int) -> str:
    """Return the text of the event for the choice after a failed practice.

    >>> missed_text(2)
    'the practice missed its criterion: go on'
    """
    return f"{PRACTICE_MISSED}{MISSED_LABELS[option].replace('_', ' ')}"


def intervention_of(event: Event) -> Intervention | None:
    """Return the intervention of an event of kind ``order``, or None.

    >>> intervention_of(Event("order", 1.0, facts=order_facts(Intervention("invalidate", (1, 7, 1)))))
    Intervention(wanted='invalidate', trial=(1, 7, 1))
    """
    if event.kind != "order" or event.facts.get("text") not in WANTED:
        return None
    key = tuple(event.facts.get(name) for name in ("block", "trial", "attempt"))
    try:
        return msgspec.convert({"wanted": event.facts["text"], "trial": None if None in key else key}, Intervention)
    except msgspec.ValidationError:
        return None


OnRequest = Callable[[Request[Any], Any], None]
"""Callback for a request and its answer."""
OnEvent = Callable[[Event], None]


class EventLog(Protocol):
    """Store of events, used by rigs from any thread.

    `recorded_s` is the time at which the last trial was on the disk (s on `time.perf_counter`).
    """

    @property
    def recorded_s(self) -> float | None: ...

    @property
    def wanted(self) -> tuple[Intervention, ...]:
        """Interventions of an earlier sitting that were not carried out."""

    def exposure(self) -> Exposure:
        """Return the duration of this session and the charge that it passed."""

    def note(self, event: Event) -> None: ...

    def follow(self, on_request: OnRequest, on_event: OnEvent) -> None:
        """Report everything recorded so far, and then each new record."""

    def keep_path(self, digest: str, lines: bytes) -> None:
        """Store times (s) and positions (m) of a finger under their digest."""

    def keep_trace(self, kind: TraceKind, table: FloatArray, rate_hz: float) -> TracePart:
        """Store samples (n_rows, n_columns) of a touch and return their place."""

    def keep_marks(self, marked: Marked) -> None:
        """Store marks of a questionnaire page, for a session interrupted there."""


def _cell(value: Fact) -> str:
    if value is None:
        return "n/a"
    return " ".join(str(int(value) if isinstance(value, bool) else value).split()) or "n/a"


def events_tsv(events: Sequence[Event], columns: Sequence[Column] = COLUMNS) -> bytes:
    """Format the events file of a session: a header, and a row for each event."""
    rows = [[column.name for column in columns], *(event.cells(columns) for event in events)]
    return "".join("\t".join(row) + "\n" for row in rows).encode()


def decode_event(value: Mapping[str, object]) -> Event:
    """Decode an event from a line of a journal.

    Raises `msgspec.ValidationError`.
    """
    try:
        return msgspec.convert({**value, "kind": value["event"]}, Event)
    except InvalidParameter as error:
        raise msgspec.ValidationError(str(error)) from None
