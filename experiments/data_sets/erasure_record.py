"""What was erased from a data set: a line of `erasures.jsonl` for each time, and the plan of one that is under way.

A line holds the participant's code, when it was, by which version, and how many sessions and files there were. It holds
the code because the laboratory has to show that it erased what it was asked to, and because the code's number is free
again for counterbalancing; a code alone says nothing once the list that links codes and names has lost it too.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import msgspec

from tactometry.errors import InvalidFile
from tactometry.files.durable import read_file, write_atomically

RECORD: Final = "erasures.jsonl"
LOCK: Final = ".erasures.lock"
"""Of one erasure at a time: two that write the record would lose a line of it."""


@dataclass(frozen=True)
class Erasure:
    """One participant, erased once. Until it is finished, `files` are those that it began with."""

    participant: str
    begun_utc: str
    version: str
    n_sessions: int
    n_files: int
    finished_utc: str | None = None
    files: tuple[str, ...] = ()


def read_erasures(root: Path) -> tuple[Erasure, ...]:
    """The record of a data set; empty where nothing was erased.

    Raises
    ------
    InvalidFile
        If it is damaged.
    """
    path = root / RECORD
    if not path.exists():
        return ()
    found = []
    for number, line in enumerate(read_file(path, "the record of what was erased").splitlines(), 1):
        try:
            found.append(msgspec.json.decode(line, type=Erasure))
        except (msgspec.DecodeError, UnicodeDecodeError) as error:
            text = f"found no erasure ({error}), expected a line that tactometry erase wrote; restore it from a copy"
            raise InvalidFile(f"{path}, line {number}: {text}") from None
    return tuple(found)


def write_erasures(root: Path, erasures: Sequence[Erasure]) -> None:
    """Write the record whole, and put it on the disk."""
    write_atomically(root / RECORD, b"".join(msgspec.json.encode(erasure) + b"\n" for erasure in erasures))


def unfinished(erasures: Sequence[Erasure], participant: str) -> Erasure | None:
    """The erasure of a participant that was interrupted."""
    return next((e for e in erasures if e.participant == participant and e.finished_utc is None), None)
