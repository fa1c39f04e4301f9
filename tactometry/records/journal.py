"""The lines of a journal: every request of a session with its answer, and every event, in order, one JSON line each.

The first line is the head of the first sitting; each later sitting, from which the session goes on, has one of its own
where it begins.

Each line ends with the CRC-32 of all that stands before it in the file, so that a damaged line, and a missing one, is
found and named. A trial (a `Record`) is
flushed and fsynced before `append` returns; an unfinished last line is what a crash leaves, and is cut off on resume.
"""

import zlib
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import msgspec

from ..errors import DeviceFailed, InvalidFile
from ..files.durable import read_file
from ..session.answer import Done
from ..session.event import Event, decode_event
from ..session.replay import Replay
from ..session.request import Fact, Record, Request
from ..trials.trial import Trial
from .formats import FORMAT, as_kept
from .head import Head, head_of
from .lines import Entry, decode_entry, kind_of_line


@dataclass(frozen=True)
class Recording:
    """A journal as it was read: `entries` up to the last whole line; `n_torn_bytes` of an unfinished last line.

    `lines` are the numbers of the entries' lines, `events` what happened unasked, `event_lines` their lines; `head` is
    that of the first sitting, `resumed` those of later ones, `resumed_lines` their lines.
    """

    head: Head | None
    entries: tuple[Entry, ...]
    complete: bool
    n_torn_bytes: int = 0
    lines: tuple[int, ...] = ()
    events: tuple[Event, ...] = ()
    event_lines: tuple[int, ...] = ()
    resumed: tuple[Head, ...] = ()
    resumed_lines: tuple[int, ...] = ()

    @property
    def sittings(self) -> tuple[Head, ...]:
        """The heads of all sittings, in order."""
        return () if self.head is None else (self.head, *self.resumed)

    @property
    def format(self) -> int:
        return FORMAT if self.head is None else self.head.format

    @property
    def told(self) -> tuple[Event, ...]:
        """What the table of events holds: the events, and what was aborted with a trial, in their order."""
        aborts = [
            (line, abortion(request, answer))
            for line, (request, answer) in zip(self.lines, self.entries, strict=True)
            if isinstance(request, Record) and request.aborted is not None
        ]
        numbered = [*zip(self.event_lines, self.events, strict=True), *aborts]
        return tuple(event for _, event in sorted(numbered, key=lambda pair: pair[0]))

    def replay(self, where: str) -> Replay:
        """The rig that answers as recorded; `where` names the journal."""
        lasted_s = max((event.at_s for event in self.events), default=0.0)
        return Replay(self.entries, where, self.lines, partial(as_kept, journal_format=self.format), lasted_s)

    @property
    def trials(self) -> tuple[Trial, ...]:
        return tuple(request.trial for request, _ in self.entries if isinstance(request, Record))


def abortion(request: Record, answer: Done) -> Event:
    """What is told of a row with which something ends unfinished."""
    trial = request.trial
    facts: dict[str, Fact] = {"block": trial.block, "trial": trial.trial, "attempt": trial.attempt}
    return Event("abort", answer.at_s, trial.timestamp_utc, {**facts, "text": request.aborted})


def encode(value: dict[str, object], before: int = 0) -> bytes:
    """One line with its checksum, behind lines of the checksum `before`."""
    body = msgspec.json.encode(value)[:-1]
    return b'%s,"crc32":"%08x"}\n' % (body, zlib.crc32(body, before))


def encode_entry(request: Request[Any], answer: object, before: int = 0) -> bytes:
    """One line of a request and its answer.

    Raises
    ------
    DeviceFailed
        If it would not read back as it was (a number that is not finite), or is no answer to that request.
    """
    line = encode({"request": type(request).__name__, "asked": request, "answer": answer}, before)
    try:
        loss = None if decode_entry(msgspec.json.decode(line)) == (request, answer) else "it would be another"
    except msgspec.ValidationError as error:
        loss = str(error)
    if loss is not None:
        raise DeviceFailed(
            f"journal: {request} with {answer} cannot be kept without loss, expected finite numbers and an answer to "
            f"what was asked ({loss}); a device gave something else: check it, then go on with --resume"
        )
    return line


def encode_event(event: Event, before: int = 0) -> bytes:
    """One line of an event."""
    what: dict[str, object] = {"event": event.kind, "at_s": event.at_s, "timestamp_utc": event.timestamp_utc}
    lasting = {} if event.duration_s is None else {"duration_s": event.duration_s}
    return encode({**what, **lasting, "facts": event.facts}, before)


def encode_sitting(head: Head, before: int = 0) -> bytes:
    """One line of the head of a later sitting."""
    return encode({"sitting": asdict(head)}, before)


def _decode(line: bytes, before: int, where: str) -> dict[str, Any]:
    # as text, from behind: the checksum is that of the bytes before it, whatever they hold
    body, mark, tail = line.rpartition(b',"crc32":"')
    if not mark or tail != b'%08x"}' % zlib.crc32(body, before):
        raise InvalidFile(
            f"{where}: the line is damaged, or one before it is missing (its checksum does not fit), expected a line "
            "as the journal wrote it; restore the file from a copy"
        )
    try:
        value: dict[str, Any] = msgspec.json.decode(body + b"}", type=dict[str, Any])
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise InvalidFile(
            f"{where}: found no table in JSON ({error}), expected a line as the journal wrote it"
        ) from None
    return value


def checksum(line: bytes) -> int:
    """The checksum of a line that was written, and of all before it.

    >>> checksum(encode({"end": "complete"})) == int(encode({"end": "complete"})[-11:-3], 16)
    True
    """
    return int(line.rstrip(b"\n")[-10:-2], 16)


def read(path: Path) -> Recording:
    """Read a journal without changing it.

    Raises
    ------
    InvalidFile
        If it cannot be read, or a line but an unfinished last one is damaged or out of place, with its number.
    """
    return decode_journal(read_file(path, "a journal"), path)


def decode_journal(content: bytes, path: Path) -> Recording:
    """As `read`, of the bytes of a journal."""
    *whole, torn = content.split(b"\n")
    head: Head | None = None
    entries: dict[int, Entry] = {}
    events: dict[int, Event] = {}
    resumed: dict[int, Head] = {}
    complete = False
    for number, value in _lines(whole, path):
        where = f"{path}, line {number}"
        if complete:
            raise InvalidFile(f"{where}: found a line behind the end of the session, expected none; remove it")
        try:
            if number == 1:
                head = head_of(value)
                continue
            match kind_of_line(value):
                case "end":
                    complete = True
                case "sitting":
                    resumed[number] = head_of(value["sitting"], head)
                case "event":
                    events[number] = decode_event(value)
                case _:
                    entries[number] = decode_entry(value)
        except msgspec.ValidationError as error:
            raise InvalidFile(
                f"{where}: found {error}, expected {'the head' if number == 1 else 'a request or event'} of a journal "
                f"of format {FORMAT}; read it with the version that wrote it"
            ) from None
    return Recording(
        head,
        tuple(entries.values()),
        complete,
        len(torn),
        tuple(entries),
        tuple(events.values()),
        tuple(events),
        tuple(resumed.values()),
        tuple(resumed),
    )


def _lines(whole: list[bytes], path: Path) -> Iterator[tuple[int, dict[str, Any]]]:
    before = 0
    for number, line in enumerate(whole, 1):
        yield number, _decode(line, before, f"{path}, line {number}")
        before = checksum(line)
