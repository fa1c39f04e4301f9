"""Data set on disk, as in Psych-DS: a journal and a trials file per session.

The journal is the source. The trials file and the descriptions are derived from the journal and the study, and can
be rebuilt.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Final

from ..arguments.require import expect
from ..errors import InvalidFile, count_of
from ..files.durable import files_in, make_folder, read_file, write_first
from ..files.rows import delimited_text
from ..trials.cells import PARTICIPANT, Value, cell
from ..trials.columns import Column
from ..trials.trial import Trial
from .description import NAME, StudyDescription

TRACES: Final = "traces"
PARTS: Final = ("data", "journals", TRACES)
"""Folders of recorded sessions."""
LARGEST_NUMBER = 999_999_999
"""Largest number of a session, and of a participant for counterbalancing."""


@dataclass(frozen=True)
class Session:
    """Session of one participant.

    Raises `InvalidParameter` if the code is not 1 to 32 letters and digits, or the session number is below 1.
    """

    participant: str
    session: int
    study: str

    def __post_init__(self) -> None:
        code = "a code of 1 to 32 letters and digits (A-Z, a-z, 0-9), such as P01, but not a name or a path"
        expect(PARTICIPANT.fullmatch(self.participant) is not None, "participant", repr(self.participant), code)
        expect(self.session >= 1, "session", self.session, "a number from 1")
        expect(self.session <= LARGEST_NUMBER, "session", self.session, f"a number up to {LARGEST_NUMBER}")

    @property
    def stem(self) -> str:
        return f"participant-{self.participant}_session-{self.session}_study-{self.study.replace('-', '')}"

    def journal(self, root: Path) -> Path:
        return root / "journals" / f"{self.stem}.jsonl"

    def events(self, root: Path) -> Path:
        return root / "journals" / f"{self.stem}_events.tsv"

    def positions(self, root: Path) -> Path:
        return root / "journals" / f"{self.stem}_positions.tsv"

    def trials(self, root: Path) -> Path:
        return root / "data" / f"{self.stem}_data.csv"

    def sidecar(self, root: Path) -> Path:
        return root / "data" / f"{self.stem}_data.json"


_MEASURED = tuple(field.name for field in fields(Trial) if field.name not in ("factors", "extra"))


def values_of(trial: Trial, session: Session, rig: str) -> dict[str, Value]:
    """Return the values of a trial by column name."""
    return {
        **vars(session),
        "rig": rig,
        **{name: getattr(trial, name) for name in _MEASURED},
        **trial.factors,
        **trial.extra,
    }


def row(trial: Trial, session: Session, rig: str, columns: Sequence[Column]) -> list[str]:
    known = values_of(trial, session, rig)
    return [cell(known.get(column.name)) for column in columns]


def trials_csv(trials: Sequence[Trial], session: Session, rig: str, columns: Sequence[Column]) -> bytes:
    header = [column.name for column in columns]
    return delimited_text([header, *(row(trial, session, rig, columns) for trial in trials)])


def refuse_links(root: Path) -> None:
    """Refuse a data set whose folders are links, before writing or erasing."""
    for part in PARTS:
        it = "the folder itself; replace the link by its target"
        expect(not (root / part).is_symlink(), root / part, "a link", it, InvalidFile)


def prepare(root: Path, design: StudyDescription) -> None:
    """Create the folders and files that all sessions share.

    Raises `InvalidFile` if the folder contains another study, a modified version of this study, other files, or a
    link.
    """
    refuse_links(root)
    for folder in (root, root / "data", root / "journals"):
        make_folder(folder)
    path = root / "study.toml"
    alone = "the description of a data set without its study.toml"
    is_whole = path.exists() or not (root / NAME).exists()
    expect(is_whole, root / NAME, alone, "both or none; choose another --out folder", InvalidFile)
    write_first(path, design.study_toml)
    is_same = read_file(path, "the study that ran") == design.study_toml
    other = "another study, or other settings than the study to run"
    same = "the same bytes; choose another --out folder, or run the study.toml of this folder"
    expect(is_same, path, other, same, InvalidFile)


def keys_of(stem: str) -> dict[str, str]:
    """Return the keys in the file name of a data set, and their values.

    >>> keys_of("participant-P01_session-1_study-tutorial_data")
    {'participant': 'P01', 'session': '1', 'study': 'tutorial'}
    """
    pairs = (part.partition("-") for part in stem.split("_"))
    return {key: value for key, dash, value in pairs if dash}


def participants(root: Path) -> list[str]:
    return sorted({code for path in sessions(root) if (code := keys_of(path.stem).get("participant"))})


def sessions(root: Path) -> list[Path]:
    """Return the journals of a data set, sorted."""
    files = (path for path in files_in(root / "journals", "*.jsonl") if path.is_file())
    return [path for path in files if not path.name.endswith("_interruptions.jsonl")]


REBUILD = "rewrite it with tactometry rebuild"


def is_beginning(existing: bytes, expected: bytes) -> bool:
    """Return True if a file is a beginning of the expected file."""
    return expected.startswith(existing.rstrip(b"\0"))


def first_difference(existing: bytes, expected: bytes) -> int | None:
    """Return the first line, from 1, in which two files differ, or None."""
    if existing == expected:
        return None
    pairs = zip(existing.split(b"\n"), expected.split(b"\n"), strict=False)
    differing = next((n for n, (a, b) in enumerate(pairs, 1) if a != b), None)
    # all lines of the shorter file are equal: return the first missing line
    return differing if differing is not None else min(existing.count(b"\n"), expected.count(b"\n")) + 1


def disagreement(existing: bytes, expected: bytes) -> tuple[int, str] | None:
    """Return where and how a derived file first differs from its journal.

    The line counts from 1. Returns None if the file agrees.
    """
    row = first_difference(existing, expected)
    if row is None:
        return None
    if not is_beginning(existing, expected):
        return (
            row,
            f"found a row that differs from the journal, expected the same row; move the file away, then {REBUILD}",
        )
    n_lacking = expected.count(b"\n") - existing.count(b"\n")
    if n_lacking == 0:
        return row, f"found zero bytes after the last row, expected none; {REBUILD}"
    return row, f"lacks the last {count_of(n_lacking, 'row')} of the journal, expected all of them; {REBUILD}"
