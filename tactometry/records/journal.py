"""Lines of a journal: all requests with answers, and all events, as JSON.

The first line is the head of the first sitting, and each later sitting begins with a head too. Each line ends with
the CRC-32 of everything before it, so that damaged and missing lines are detected. A trial (`Record`) is flushed and
fsynced before `append` returns. An unfinished last line is removed on resume.
"""

import zlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import partial
from itertools import takewhile
from pathlib import Path
from typing import Any, Final, NamedTuple, TypeVar

import msgspec

from ..errors import DeviceFailed, InvalidFile
from ..files.durable import read_file, whole_lines
from ..session.answer import Chosen, Done, Intervention, Marked, left
from ..session.event import Event, decode_event, intervention_of, missed_text, trial_facts
from ..session.replay import Replay, rows
from ..session.request import MISSED_PRACTICE, REQUESTS, Choose, Fact, Intervene, Record, Request, flaw
from ..trials.trial import Trial
from .head import FORMAT, Head, as_kept, head_of

T = TypeVar("T")
_KEYS: Final = {
    "request": {"request", "asked", "answer"},
    "event": {"event", "at_s", "timestamp_utc", "facts"},
    "sitting": {"sitting"},
    "marked": {"marked"},
    "end": {"end"},
}
_MAY: Final[Mapping[str, set[str]]] = {"event": {"duration_s"}}
"""Optional keys of lines."""


class Entry(NamedTuple):
    """Request with its answer."""

    request: Request[Any]
    answer: Any


Line = Head | Entry | Event | Marked


@dataclass(frozen=True)
class Recording:
    """Journal up to its last complete line, followed by `n_torn_bytes`.

    `lines` begin with the head of the first sitting. `complete` is True if the session has ended.
    """

    lines: tuple[Line, ...]
    complete: bool
    n_torn_bytes: int = 0

    @property
    def sittings(self) -> tuple[Head, ...]:
        return tuple(line for line in self.lines if isinstance(line, Head))

    @property
    def head(self) -> Head | None:
        """Head of the first sitting."""
        return next(iter(self.sittings), None)

    @property
    def format(self) -> int:
        return FORMAT if self.head is None else self.head.format

    @property
    def entries(self) -> tuple[Entry, ...]:
        return tuple(line for line in self.lines if isinstance(line, Entry))

    @property
    def events(self) -> tuple[Event, ...]:
        return tuple(line for line in self.lines if isinstance(line, Event))

    @property
    def event_rows(self) -> tuple[Event, ...]:
        """Rows of the events table: events, and those that follow from requests."""
        events = (line if isinstance(line, Event) else consequence(line) for line in self.lines)
        return tuple(event for event in events if event is not None)

    def replay(self, where: str) -> Replay:
        """Return a rig that answers as recorded. `where` names the journal."""
        lasted_s = max((event.at_s for event in self.events), default=0.0)
        numbers = [number for number, line in enumerate(self.lines, 1) if isinstance(line, Entry)]
        kept = partial(as_kept, journal_format=self.format)
        return Replay(self.entries, where, numbers, kept, lasted_s, self.marked)

    @property
    def marked(self) -> Marked | None:
        """Marks on the unfinished page of a questionnaire."""
        behind = takewhile(lambda line: not isinstance(line, Entry), reversed(self.lines))
        return next((line for line in behind if isinstance(line, Marked)), None)

    @property
    def trials(self) -> tuple[Trial, ...]:
        """Rows of the trials table. A retracted trial is not valid."""
        return rows(entry.request for entry in self.entries)

    @property
    def rows_at_first(self) -> tuple[Trial, ...]:
        return tuple(entry.request.trial for entry in self.entries if isinstance(entry.request, Record))

    @property
    def wanted(self) -> tuple[Intervention, ...]:
        """Interventions that the session never carried out."""
        interventions = (intervention_of(event) for event in self.events)
        answers = (entry.answer for entry in self.entries if isinstance(entry.answer, Done))
        carried = (each for answer in answers for each in answer.interventions)
        return left((each for each in interventions if each is not None), carried)


def consequence(line: Line) -> Event | None:
    """Return the event that follows from a request, or None.

    Such requests abort something, are interventions, or decide on a failed practice.
    """
    match line:
        case Entry(Record(trial, aborted), Done(at_s)) if aborted is not None:
            facts: dict[str, Fact] = {"block": trial.block, "trial": trial.trial, "attempt": trial.attempt}
            return Event("abort", at_s, trial.timestamp_utc, {**facts, "text": aborted})
        case Entry(Intervene(intervention, said), Done(at_s)):
            return Event("intervention", at_s, None, {**trial_facts(intervention), "text": said})
        case Entry(Choose(question), Chosen() as chosen) if question == MISSED_PRACTICE:
            at_s = round(chosen.onset_s + chosen.latency_s, 6)
            return Event("intervention", at_s, chosen.timestamp_utc, {"text": missed_text(chosen.option)})
    return None


def encode(value: dict[str, object], before: int = 0) -> bytes:
    """Encode a line with its checksum, after lines with the checksum `before`."""
    body = msgspec.json.encode(value)[:-1]
    return b'%s,"crc32":"%08x"}\n' % (body, zlib.crc32(body, before))


def encode_entry(request: Request[Any], answer: object, before: int = 0) -> bytes:
    """Encode a request and its answer.

    Raises `DeviceFailed` if decoding would not restore them, or if the answer does not match the request.
    """
    line = encode({"request": type(request).__name__, "asked": request, "answer": answer}, before)
    try:
        loss = None if decode_entry(msgspec.json.decode(line)) == (request, answer) else "decoding would change it"
    except msgspec.ValidationError as error:
        loss = str(error)
    if loss is not None:
        raise DeviceFailed(
            f"journal: {request} with {answer} cannot be stored without loss, expected finite numbers and an answer "
            f"to the request ({loss}); check the device that returned it, then continue with --resume"
        )
    return line


def encode_line(line: Event | Head | Marked, before: int = 0) -> bytes:
    """Encode an event, marks on a page, or the head of a later sitting."""
    if isinstance(line, Head):
        return encode({"sitting": asdict(line)}, before)
    if isinstance(line, Marked):
        return encode({"marked": asdict(line)}, before)
    what: dict[str, object] = {"event": line.kind, "at_s": line.at_s, "timestamp_utc": line.timestamp_utc}
    lasting = {} if line.duration_s is None else {"duration_s": line.duration_s}
    return encode({**what, **lasting, "facts": line.facts}, before)


def _table(line: bytes, before: int, where: str) -> dict[str, Any]:
    # search from the end, as the line may contain any text before its checksum
    body, mark, tail = line.rpartition(b',"crc32":"')
    if not mark or tail != b'%08x"}' % zlib.crc32(body, before):
        raise InvalidFile(
            f"{where}: the line is damaged, or an earlier line is missing (wrong checksum), expected a line as "
            "the journal wrote it; restore the file from a copy"
        )
    try:
        value: dict[str, Any] = msgspec.json.decode(body + b"}", type=dict[str, Any])
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise InvalidFile(f"{where}: found no JSON object ({error}), expected a line as the journal wrote it") from None
    return value


def checksum(line: bytes) -> int:
    """Return the checksum of a written line and all lines before it."""
    return int(line.rstrip(b"\n")[-10:-2], 16)


def read(path: Path) -> Recording:
    """Read a journal without changing it.

    An unfinished last line is allowed. Raises `InvalidFile` if the file cannot be read, or another line is damaged
    or out of place.
    """
    return decode_journal(read_file(path, "a journal"), path)


def decode_journal(content: bytes, path: Path) -> Recording:
    lines, place = decode_on(content, path)
    return Recording(lines, place.complete, len(content) - place.n_bytes)


@dataclass(frozen=True)
class Reached:
    """Position in a journal, and what was read before it.

    It consists of bytes, lines, checksum, first head, and whether the session has ended.
    """

    n_bytes: int = 0
    n_lines: int = 0
    checksum: int = 0
    head: Head | None = None
    complete: bool = False


def decode_on(content: bytes, path: Path, place: Reached = Reached()) -> tuple[tuple[Line, ...], Reached]:
    """Decode the complete lines after a position. Return also the new position.

    Raises `InvalidFile` if a line is damaged or out of place.
    """
    lines: list[Line] = []
    for whole in whole_lines(content):
        line, place = _next_line(whole, path, place)
        if line is not None:
            lines.append(line)
    return tuple(lines), place


def _next_line(whole: bytes, path: Path, place: Reached) -> tuple[Line | None, Reached]:
    """Decode the next line (None: the end) and return the new position."""
    where = f"{path}, line {place.n_lines + 1}"
    if place.complete:
        raise InvalidFile(f"{where}: found a line after the end of the session, expected none; remove it")
    table = _table(whole, place.checksum, where)
    try:
        line = _decode_line(table, place.head)
    except msgspec.ValidationError as error:
        raise InvalidFile(
            f"{where}: found {error}, expected {'a request or event' if place.n_lines else 'the head'} of a journal "
            f"of format {FORMAT}; use the version that wrote it"
        ) from None
    head = line if place.head is None and isinstance(line, Head) else place.head
    return line, Reached(place.n_bytes + len(whole) + 1, place.n_lines + 1, checksum(whole), head, line is None)


def _decode_line(table: dict[str, Any], head: Head | None) -> Line | None:
    """Decode a line; None is the end. Raises `msgspec.ValidationError`."""
    if head is None:
        return head_of(table)
    kind = next((kind for kind in _KEYS if kind in table), "")
    keys = table.keys() - _MAY.get(kind, set())
    if not kind or keys != _KEYS[kind] or table.get("end", "complete") != "complete":
        raise msgspec.ValidationError(f"a line of {', '.join(map(repr, table)) or 'nothing'}")
    match kind:
        case "sitting":
            return head_of(table["sitting"], head)
        case "event":
            return decode_event(table)
        case "marked":
            return _strictly(table["marked"], Marked)
        case "request":
            return decode_entry(table)
    return None


def decode_entry(value: dict[str, Any]) -> Entry:
    """Decode a request and its answer.

    Raises `msgspec.ValidationError` if either is invalid, or if they do not match.
    """
    kind = REQUESTS.get(str(value.get("request")))
    if kind is None:
        raise msgspec.ValidationError(f"the request {value.get('request')!r}")
    request = _strictly(value.get("asked"), kind)
    answer: Any = _strictly(value.get("answer"), kind.answer_type)
    wrong = flaw(request, answer)
    if wrong is not None:
        raise msgspec.ValidationError(wrong)
    return Entry(request, answer)


def _strictly(value: Any, kind: type[T]) -> T:
    """Convert a value to a class, and refuse keys that are not its fields."""
    built = msgspec.convert(value, kind)
    _refuse_unknown(value, built)  # msgspec ignores unknown keys of a dataclass
    if isinstance(built, Record):
        _refuse_unknown(value["trial"], built.trial)
    return built


def _refuse_unknown(table: Mapping[str, object], built: Any) -> None:
    known = built.__dataclass_fields__.keys()
    if not table.keys() <= known:
        raise msgspec.ValidationError(f"the key {min(table.keys() - known)!r}")
