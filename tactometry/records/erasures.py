"""Record of erasures: `erasures.jsonl` with one line for each erasure.

It also contains the plan of an unfinished erasure. A line contains the participant's code, because the laboratory
must prove the requested erasure, and because the code may be assigned again. A code does not identify a person once
it is removed from the list of codes and names.
"""

import os
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import msgspec

from ..errors import InvalidFile, InvalidParameter
from ..files.durable import read_file, write_atomically
from ..trials.cells import PARTICIPANT
from .data_set import Session
from .description import NAME

RECORD: Final = "erasures.jsonl"
LOCK: Final = ".erasures.lock"
"""Lock that allows one erasure at a time. Two erasures at once would lose a line of the record."""


@dataclass(frozen=True)
class Erasure:
    """Erasure of one participant. `files` are those of an unfinished erasure."""

    participant: str
    begun_utc: str
    version: str
    n_sessions: int
    n_files: int
    finished_utc: str | None = None
    files: tuple[str, ...] = ()


def read_erasures(root: Path) -> tuple[Erasure, ...]:
    """Read the record of a data set, empty if nothing was erased."""
    path = root / RECORD
    if not os.path.lexists(path):
        return ()
    lines = read_file(path, "the record of what was erased").splitlines()
    return tuple(_erasure(line, f"{path}, line {number}") for number, line in enumerate(lines, 1))


def _erasure(line: bytes, where: str) -> Erasure:
    """Decode a line. Refuse participants that are not codes, such as hashes."""
    try:
        erasure = msgspec.json.decode(line, type=Erasure)
        if not PARTICIPANT.fullmatch(erasure.participant):
            raise msgspec.ValidationError(f"the participant {erasure.participant!r:.40} is not a code")
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        text = f"found no erasure ({error}), expected a line of tactometry erase; restore it from a copy"
        raise InvalidFile(f"{where}: {text}") from None
    return erasure


def write_erasures(root: Path, erasures: Sequence[Erasure]) -> None:
    write_atomically(root / RECORD, b"".join(msgspec.json.encode(erasure) + b"\n" for erasure in erasures))


def unfinished(erasures: Sequence[Erasure], participant: str) -> Erasure | None:
    return next((e for e in erasures if e.participant == participant and e.finished_utc is None), None)


def refuse_erased(root: Path, codes: Iterable[str], *, allowed: bool = False) -> None:
    """Refuse erased participants, unless that is allowed. Ignores case.

    An unfinished erasure is always refused, because it would erase the new session too.

    Raises `InvalidParameter` if a participant was erased, `InvalidFile` if the record is damaged.
    """
    lines = sorted(enumerate(read_erasures(root), 1), key=lambda line: line[1].finished_utc is None)
    erased = {
        erasure.participant.casefold(): (number, erasure) for number, erasure in lines
    }  # unfinished erasures have priority
    for code in codes if erased else ():
        number, erasure = erased.get(code.casefold(), (0, None))
        if erasure is None or (allowed and erasure.finished_utc is not None):
            continue
        found, expected = f"that {erasure.participant} was erased at {erasure.finished_utc}", "another participant"
        way = "choose another code or --out, or add --allow-erased to record this participant again"
        if erasure.finished_utc is None:
            found, expected = f"an unfinished erasure of {erasure.participant}", "a finished one"
            way = f"repeat tactometry erase {root} --participant {erasure.participant}"
        raise InvalidParameter(f"{root / RECORD}, line {number}: found {found}, expected {expected}; {way}")


class Withdrawal:
    """Files and folders that a session creates, removed if nothing was recorded.

    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     root = Path(folder) / "data"
    ...     withdrawal = Withdrawal(root, Session("P01", 1, "tutorial"))
    ...     (root / "journals").mkdir(parents=True)
    ...     withdrawal.undo()
    ...     root.exists()
    False
    """

    def __init__(self, root: Path, session: Session) -> None:
        events = session.events(root)
        files = (session.trials(root), session.sidecar(root), events, events.with_suffix(".json"))
        self._journal = session.journal(root)
        folders = (self._journal.parent, root / "data")
        # a folder that another session uses is not empty: keep it and its parents
        ordered = (*files, self._journal, *folders, root / "study.toml", root / NAME, root)
        self._created = tuple(path for path in ordered if not path.exists())

    def undo(self) -> None:
        """Remove what was created since the start, unless the journal has a line."""
        if self._journal.exists() and self._journal.stat().st_size:
            return
        with suppress(OSError):  # files and folders in use stay
            for path in self._created:
                if path.is_dir():
                    path.rmdir()
                else:
                    path.unlink(missing_ok=True)
