"""Open journal: appending, and repair after an interruption."""

import os
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import asdict, replace
from itertools import islice
from pathlib import Path
from typing import Any, Final

import msgspec
import portalocker

from ..errors import InvalidFile, SessionInUse
from ..files.durable import NO_LINK, draft, open_private, put_in_place, read_file, sync_folder, whole_lines, write_whole
from ..session.answer import Marked
from ..session.event import Event
from ..session.replay import Replay
from ..session.request import CONSENT, MISSED_PRACTICE, Choose, Fill, Intervene, Record, Request, Show
from .head import Head
from .journal import Entry, Line, Recording, checksum, decode_journal, encode, encode_entry, encode_line

_IN_USE: Final = (
    "another process is writing this session, expected no other process; wait until it ends, or choose another "
    "--session number"
)
LOCK_TRIES, LOCK_PAUSE_S = 5, 0.02
"""Number of attempts to get a lock, because `is_written` holds it for microseconds."""
LASTING: Final = (Record, Intervene)
"""Requests after which an interrupted journal is cut: everything up to the last one is kept."""


class Journal:
    """Journal that is open for writing, and locked against other processes.

    With `resume`, the journal is cut after its last recorded trial, or after a later page that was read or filled in.
    `cut` contains what was removed, and the file `interruptions` stores it. Events stay, and so do marks of the current
    page.

    Without `syncs_trials` (for simulated participants, who can answer again) only head and end are synced. A killed
    process then loses nothing, but a power failure may lose the last trials.
    """

    def __init__(self, path: Path, *, resume: bool, syncs_trials: bool = True) -> None:
        self.path, self._syncs_trials = path, syncs_trials
        self._file, self._unsynced = _open_locked(path), False
        try:
            if not resume and path.stat().st_size > 0:
                raise InvalidFile(
                    f"{path}: this session has already been recorded, expected a new session; continue with --resume, "
                    "or choose another --session number"
                )
            self.recording, self.cut = self._repair()
        except BaseException:
            os.close(self._file)
            raise
        self.head = self.recording.head

    @property
    def interruptions(self) -> Path:
        return self.path.with_name(f"{self.path.stem}_interruptions.jsonl")

    def _repair(self) -> tuple[Recording, bytes]:
        content = read_file(self.path, "a journal")
        recording = decode_journal(content, self.path)
        kept_kinds = (*LASTING, Fill, Show) if self._syncs_trials else LASTING
        lines = recording.lines if recording.complete else _until_last(kept_kinds, recording.lines)
        kept_lines = islice(whole_lines(content), len(lines) + recording.complete)
        n_bytes = sum(len(line) + 1 for line in kept_lines)
        self._before = checksum(content[: n_bytes - 1].rpartition(b"\n")[2]) if n_bytes else 0
        kept, cut = Recording(lines, recording.complete), content[n_bytes:]
        if cut:
            self.keep(after_trials=len(kept.trials), cut=cut.decode("utf-8", "backslashreplace"))
            # events and marks after the cut are kept
            behind = tuple(line for line in recording.lines[len(lines) :] if not isinstance(line, Entry))
            self._exchange(content[:n_bytes], behind)
            kept = Recording((*lines, *behind), recording.complete)
        os.lseek(self._file, 0, os.SEEK_END)
        return kept, cut

    def keep(self, **lost: object) -> None:
        """Append a line to `interruptions` with data that would be lost."""
        file = open_private(self.interruptions, os.O_WRONLY | NO_LINK)
        try:
            os.lseek(file, 0, os.SEEK_END)
            write_whole(file, msgspec.json.encode(lost) + b"\n", self.interruptions, durable=True)
        finally:
            os.close(file)

    def _exchange(self, kept: bytes, behind: Sequence[Event | Head | Marked]) -> None:
        """Replace the journal by the kept part and later lines, still locked."""
        lines = []
        for line in behind:
            lines.append(encode_line(line, self._before))
            self._before = checksum(lines[-1])
        with draft(self.path, kept + b"".join(lines)) as (file, drafted):
            _lock(file, self.path)  # locked before renaming, so that no other process intervenes
            put_in_place(drafted, self.path)
        os.close(self._file)
        self._file = file

    @property
    def replay(self) -> Replay:
        return self.recording.replay(str(self.path))

    def begin(self, head: Head) -> None:
        """Write the head of a sitting, unless it repeats the last one."""
        last = self.recording.sittings[-1:]
        if not last:
            self._write(encode(asdict(head), self._before), durable=True)
            sync_folder(self.path.parent)
            self.head = head
        elif head != replace(last[0], begun_s=head.begun_s):
            self._write(encode_line(head, self._before), durable=True)

    def append(self, request: Request[Any], answer: object) -> None:
        self._write(
            encode_entry(request, answer, self._before),
            durable=self._syncs_trials and (isinstance(request, LASTING) or _is_decision(request)),
        )

    def note(self, event: Event) -> None:
        self._write(encode_line(event, self._before), durable=False)

    def finish(self) -> None:
        """Write the last line, once."""
        if not self.recording.complete:
            self._write(encode({"end": "complete"}, self._before), durable=True)

    def keep_marks(self, marked: Marked) -> None:
        """Store marks of an unfinished page, without a sync, as this runs in a frame."""
        self._write(encode_line(marked, self._before), durable=False)

    def close(self) -> None:
        if self._file >= 0:
            if self._unsynced:
                os.fsync(self._file)
            os.close(self._file)
            self._file = -1

    def _write(self, line: bytes, *, durable: bool) -> None:
        write_whole(self._file, line, self.path, durable=durable)
        self._before, self._unsynced = checksum(line), not durable


def _until_last(kinds: tuple[type[Request[Any]], ...], lines: Sequence[Line]) -> tuple[Line, ...]:
    """Return the lines to keep of an interrupted journal.

    They end with the last request of these kinds or the last marks, and the events after it.
    """
    entries = [n for n, line in enumerate(lines) if isinstance(line, Entry)]
    last = max((n for n, line in enumerate(lines) if _is_kept(kinds, line)), default=-1)
    return tuple(lines[: next((n for n in entries if n > last), len(lines))])


def _is_kept(kinds: tuple[type[Request[Any]], ...], line: Line) -> bool:
    if isinstance(line, Entry):
        return isinstance(line.request, kinds) or _is_decision(line.request)
    return isinstance(line, Marked)


def _is_decision(request: Request[Any]) -> bool:
    """Return True for a choice that decides how the session continues."""
    return isinstance(request, Choose) and request.question in (CONSENT, MISSED_PRACTICE)


@contextmanager
def held(journals: Iterable[Path]) -> Iterator[None]:
    """Lock journals against other processes."""
    with ExitStack() as stack:
        for path in journals:
            stack.callback(os.close, _open_locked(path))
        yield


def is_written(path: Path) -> bool:
    """Return True while a process has a journal open for writing.

    This locks the journal for a moment. A session that begins at this moment waits.
    """
    try:
        file = os.open(path, os.O_RDONLY)
    except OSError:
        return False
    try:
        portalocker.lock(file, portalocker.LOCK_SH | portalocker.LOCK_NB)
    except portalocker.LockException:
        return True
    finally:
        os.close(file)
    return False


@contextmanager
def alone(path: Path, in_use: str) -> Iterator[None]:
    """Lock a file against other processes, and remove it at the end.

    Raises `SessionInUse`, with the message `in_use`, if another process has locked it.
    """
    file = _open_locked(path, in_use)
    try:
        yield
    finally:
        with suppress(OSError):  # on other systems than POSIX an open file cannot be removed
            path.unlink()  # removed while locked, so that a waiting process notices and creates another
        os.close(file)


def _open_locked(path: Path, in_use: str = _IN_USE) -> int:
    """Open and lock a file; reopen it if it was replaced meanwhile."""
    while True:
        file = open_private(path, os.O_RDWR)
        try:
            _lock(file, path, in_use)
            if os.path.samestat(os.fstat(file), path.stat()):
                return file
        except FileNotFoundError:
            pass
        except BaseException:
            os.close(file)
            raise
        os.close(file)  # the path has been replaced: open the new file


def _lock(file: int, path: Path, in_use: str = _IN_USE) -> None:
    for left in reversed(range(LOCK_TRIES)):
        try:
            portalocker.lock(file, portalocker.LOCK_EX | portalocker.LOCK_NB)
            return
        except portalocker.LockException:
            if not left:
                raise SessionInUse(f"{path}: {in_use}") from None
            time.sleep(LOCK_PAUSE_S)
