"""The journal of a session: every request with its answer, and every event, in order, append-only, one JSON line each.

The first line is the head of the first sitting; each later sitting, from which the session goes on, has one of its own
where it begins.

Each line ends with the CRC-32 of all that stands before it in the file, so that a damaged line, and a missing one, is
found and named. A trial (a `Record`) is
flushed and fsynced before `append` returns; an unfinished last line is what a crash leaves, and is cut off on resume.
"""

import math
import os
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import msgspec
import portalocker

from tactometry.errors import DeviceFailed, InvalidFile, SessionInUse
from tactometry.event import Event, Fact, decode_event
from tactometry.files import draft, open_private, put_in_place, read_file, sync_folder, write_whole
from tactometry.formats import FORMAT
from tactometry.request import REQUESTS, Record, Request
from tactometry.rigs.replay import Replay
from tactometry.trial import Trial

Entry = tuple[Request, Any]


@dataclass(frozen=True)
class Head:
    """Of a sitting: what is needed to ask the same again, and where and on what it was asked.

    `begun_s` is the time of the session at which the sitting began.
    """

    study: str
    study_sha256: str
    participant: str
    session: int
    number: int
    seed: int
    rig: str
    versions: dict[str, str]
    facts: dict[str, Fact] = field(default_factory=dict)
    observer: dict[str, Fact] = field(default_factory=dict)
    started_utc: str | None = None
    begun_s: float = 0.0
    format: int = FORMAT


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

    def replay(self, where: str) -> Replay:
        """The rig that answers as recorded; `where` names the journal."""
        lasted_s = max((event.at_s for event in self.events), default=0.0)
        return Replay(self.entries, where, self.lines, self.format, lasted_s)

    @property
    def trials(self) -> tuple[Trial, ...]:
        return tuple(request.trial for request, _ in self.entries if isinstance(request, Record))


def encode(value: dict[str, object], before: int = 0) -> bytes:
    """One line with its checksum, behind lines of the checksum `before`."""
    body = msgspec.json.encode(value)[:-1]
    return b'%s,"crc32":"%08x"}\n' % (body, zlib.crc32(body, before))


def encode_entry(request: Request, answer: object, before: int = 0) -> bytes:
    """One line of a request and its answer.

    Raises
    ------
    DeviceFailed
        If it would not read back as it was (a number that is not finite).
    """
    line = encode({"request": type(request).__name__, "asked": request, "answer": answer}, before)
    if not _reads_back(line, request, answer):
        raise DeviceFailed(
            f"journal: {request} with {answer} cannot be kept without loss, expected finite numbers; a device gave a "
            "value that is not a number: check it, then go on with --resume"
        )
    return line


def encode_event(event: Event, before: int = 0) -> bytes:
    """One line of an event."""
    told: dict[str, object] = {"event": event.kind, "at_s": event.at_s, "timestamp_utc": event.timestamp_utc}
    return encode({**told, "facts": event.facts}, before)


def encode_sitting(head: Head, before: int = 0) -> bytes:
    """One line of the head of a later sitting."""
    return encode({"sitting": asdict(head)}, before)


def _reads_back(line: bytes, request: Request, answer: object) -> bool:
    try:
        return decode_entry(msgspec.json.decode(line)) == (request, answer)
    except msgspec.ValidationError:
        return False


def decode_entry(value: dict[str, Any]) -> Entry:
    kind = REQUESTS[value["request"]]
    return msgspec.convert(value["asked"], kind), msgspec.convert(value["answer"], kind.answer)


def _decode(line: bytes, before: int, where: str) -> dict[str, Any]:
    body, mark, tail = line.rpartition(b',"crc32":"')
    if not mark or tail != b'%08x"}' % zlib.crc32(body, before):
        raise InvalidFile(
            f"{where}: the line is damaged, or one before it is missing (its checksum does not fit), expected a line "
            "as the journal wrote it; restore the file from a copy"
        )
    value: dict[str, Any] = msgspec.json.decode(body + b"}")
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
    return _decoded(read_file(path, "a journal"), path)


def _decoded(content: bytes, path: Path) -> Recording:
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
            elif "end" in value:
                complete = True
            elif "sitting" in value:
                resumed[number] = head_of(value["sitting"])
            elif "event" in value:
                events[number] = decode_event(value)
            else:
                entries[number] = decode_entry(value)
        except (KeyError, msgspec.ValidationError) as error:
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


def head_of(value: object) -> Head:
    """A head from its line. Raises `msgspec.ValidationError`."""
    head = msgspec.convert(value, Head)
    if head.format > FORMAT:
        raise msgspec.ValidationError(f"the format {head.format}")
    return head


def _lines(whole: list[bytes], path: Path) -> Iterator[tuple[int, dict[str, Any]]]:
    before = 0
    for number, line in enumerate(whole, 1):
        yield number, _decode(line, before, f"{path}, line {number}")
        before = checksum(line)


class Journal:
    """A journal that is open for writing, and locked: a second process is refused.

    With `resume`, the journal is cut back to its last recorded trial and `replay` gives what it holds. What was cut
    (the torn line, and the requests of the trial that was under way) is returned by `cut`, and kept in the file
    `interruptions` beside it. Events stay.
    """

    def __init__(self, path: Path, *, resume: bool) -> None:
        self.path = path
        self._file, self._unsynced = _open_locked(path), False
        try:
            _refuse_recorded(path, resume=resume)
            self.recording, self.cut = self._repair()
        except BaseException:
            os.close(self._file)
            raise
        self.head = self.recording.head

    @property
    def interruptions(self) -> Path:
        """Where what interruptions cut off is kept."""
        return self.path.with_name(f"{self.path.stem}_interruptions.jsonl")

    def _repair(self) -> tuple[Recording, bytes]:
        content = read_file(self.path, "a journal")
        recording = _decoded(content, self.path)
        kept = recording if recording.complete else _until_last_trial(recording)
        n_bytes = sum(len(line) + 1 for line in content.split(b"\n")[: _n_lines(kept)])
        self._before = checksum(content[: n_bytes - 1].rpartition(b"\n")[2]) if n_bytes else 0
        cut = content[n_bytes:]
        if cut:
            self.keep(after_trials=len(kept.trials), cut=cut.decode("utf-8", "backslashreplace"))
            self._exchange(content[:n_bytes], _unasked(recording)[len(kept.events) + len(kept.resumed) :])
        os.lseek(self._file, 0, os.SEEK_END)
        return replace(kept, events=recording.events, resumed=recording.resumed), cut

    def keep(self, **lost: object) -> None:
        """Keep beside the journal what would else be lost, as a line of `interruptions`."""
        file = open_private(self.interruptions, os.O_WRONLY)
        try:
            os.lseek(file, 0, os.SEEK_END)
            write_whole(file, msgspec.json.encode(lost) + b"\n", self.interruptions, durable=True)
        finally:
            os.close(file)

    def _exchange(self, kept: bytes, behind: Sequence[Callable[[int], bytes]]) -> None:
        """Put what is kept, and the lines behind it, in the place of the journal; it stays locked."""
        lines = []
        for line in behind:
            lines.append(line(self._before))
            self._before = checksum(lines[-1])
        with draft(self.path, kept + b"".join(lines)) as (file, beside):
            _lock(file, self.path)
            put_in_place(beside, self.path)
        os.close(self._file)
        self._file = file

    @property
    def replay(self) -> Replay:
        return self.recording.replay(str(self.path))

    def begin(self, head: Head) -> None:
        """Write the head of a sitting; one that says nothing new (a simulated one knows no time) is not written."""
        last = self.recording.sittings[-1:]
        if not last:
            self._write(encode(asdict(head), self._before), durable=True)
            sync_folder(self.path.parent)
            self.head = head
        elif head != replace(last[0], begun_s=head.begun_s):
            self._write(encode_sitting(head, self._before), durable=True)

    def append(self, request: Request, answer: object) -> None:
        self._write(encode_entry(request, answer, self._before), durable=isinstance(request, Record))

    def note(self, event: Event) -> None:
        self._write(encode_event(event, self._before), durable=False)

    def finish(self) -> None:
        """Write the last line, once."""
        if not self.recording.complete:
            self._write(encode({"end": "complete"}, self._before), durable=True)

    def close(self) -> None:
        if self._file >= 0:
            if self._unsynced:
                os.fsync(self._file)
            os.close(self._file)
            self._file = -1

    def _write(self, line: bytes, *, durable: bool) -> None:
        write_whole(self._file, line, self.path, durable=durable)
        self._before, self._unsynced = checksum(line), not durable


def _until_last_trial(recording: Recording) -> Recording:
    """Up to the last trial, with the events that follow it before anything else is asked."""
    n_kept = max((n for n, (request, _) in enumerate(recording.entries, 1) if isinstance(request, Record)), default=0)
    end = recording.lines[n_kept] if n_kept < len(recording.lines) else math.inf
    n_events = sum(line < end for line in recording.event_lines)
    n_resumed = sum(line < end for line in recording.resumed_lines)
    return Recording(
        recording.head,
        recording.entries[:n_kept],
        complete=False,
        lines=recording.lines[:n_kept],
        events=recording.events[:n_events],
        event_lines=recording.event_lines[:n_events],
        resumed=recording.resumed[:n_resumed],
        resumed_lines=recording.resumed_lines[:n_resumed],
    )


def _unasked(recording: Recording) -> list[Callable[[int], bytes]]:
    """Every line that answers no request, events and heads of sittings in their order: a line makes itself anew behind
    lines of another checksum."""
    events = zip(recording.event_lines, (partial(encode_event, event) for event in recording.events), strict=True)
    heads = zip(recording.resumed_lines, (partial(encode_sitting, head) for head in recording.resumed), strict=True)
    return [line for _, line in sorted([*events, *heads], key=lambda numbered: numbered[0])]


def _n_lines(recording: Recording) -> int:
    return len(recording.sittings) + len(recording.entries) + len(recording.events) + recording.complete


def _open_locked(path: Path) -> int:
    """The journal, locked: not one that a repair elsewhere has replaced since it was opened."""
    while True:
        file = open_private(path, os.O_RDWR)
        try:
            _lock(file, path)
            if os.path.samestat(os.fstat(file), path.stat()):
                return file
        except FileNotFoundError:
            pass
        except BaseException:
            os.close(file)
            raise
        os.close(file)


def _refuse_recorded(path: Path, *, resume: bool) -> None:
    if not resume and path.stat().st_size > 0:
        raise InvalidFile(
            f"{path}: this session has been recorded already, expected a new one; go on with --resume, or give "
            "another --session number"
        )


def _lock(file: int, path: Path) -> None:
    try:
        portalocker.lock(file, portalocker.LOCK_EX | portalocker.LOCK_NB)
    except portalocker.LockException:
        raise SessionInUse(
            f"{path}: another process is writing this session, expected to be the only one; wait until it ends, or "
            "give another --session number"
        ) from None
