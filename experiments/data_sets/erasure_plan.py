"""Sort the files of a data set into those of one participant, those derived from several, and others.

*Own* files are named for the participant, or are a journal of theirs under another name. *Derived* files are reports,
figures and exports: all of them go, as a mean contains whoever entered it, and are made again from who remains. Other
files stay, and their names are returned so that a person can look at them: they are not searched.
"""

import os
import re
from collections.abc import Collection, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from tactometry.errors import InvalidFile
from tactometry.files.durable import drafts, read_file
from tactometry.records.data_set import PARTS, keys_of
from tactometry.records.description import NAME
from tactometry.records.erasures import LOCK, RECORD
from tactometry.records.head import heads

STUDY: Final = "study.toml"
DERIVED: Final = frozenset((".csv", ".gz", ".htm", ".html", ".json", ".jsonl", ".pdf", ".png", ".svg", ".tsv"))
"""Endings of files that `analyse`, `show` and `export` write."""
EXPORTED: Final = frozenset(("README.md", "CHANGES.md", "columns.toml", "trials.R"))
"""Further files that `export` writes."""
_FIGURE: Final = (".csv", ".png", ".svg")
_OF_TRIAL: Final = re.compile(r"trial-\d+\.(png|pdf|svg)")
_BEGINNINGS: Final = {NAME: b"", "columns.toml": b"# tactometry analyse", "trials.R": b"# Reads trials.csv"}
"""Files that mark a folder as an export, and how they begin."""
_KEYS: Final = ("participant", "subject", "sub")


@dataclass(frozen=True)
class ErasurePlan:
    """Files to erase (`journals`, `own`, `derived`), and names of files and folders to look at (`others`)."""

    journals: tuple[Path, ...]
    own: tuple[Path, ...]
    derived: tuple[Path, ...]
    others: tuple[str, ...]

    @property
    def files(self) -> tuple[Path, ...]:
        """All files to erase, journals last: while one is there, the plan can be made again."""
        return (*self.derived, *self.own, *self.journals)


def plan(root: Path, code: str, begun: Collection[str] = ()) -> ErasurePlan:
    """Return what to erase of the participant `code`; `begun` are the files of an interrupted erasure.

    Raises
    ------
    InvalidFile
        If something in the folder cannot be read.
    """
    files, folders = _walk(root)
    own = [path for path in files if _is_own(root, path, code)]
    rest = [path for path in files if path not in own and not _is_of_set(root, path)]
    derived = {*_derived(root, rest), *(path for path in rest if _name(root, path) in begun)}
    links = [f"{_name(root, path)} -> {os.path.realpath(path)}" for path in own if path.is_symlink()]
    others = [_name(root, path) for path in (*rest, *folders) if path not in derived]
    return ErasurePlan(
        tuple(path for path in own if _is_journal(root, path)),
        tuple(path for path in own if not _is_journal(root, path)),
        tuple(sorted(derived)),
        (*links, *sorted(others)),
    )


def _name(root: Path, path: Path) -> str:
    return path.relative_to(root).as_posix()


def _walk(root: Path) -> tuple[list[Path], list[Path]]:
    """Return all files and links, and the folders that are not entered: hidden ones and other data sets."""
    found, closed = [], []
    for folder, folders, files in os.walk(root, onerror=_refuse):
        here = Path(folder)
        shut = [name for name in sorted(folders) if name.startswith(".") or (here / name / "journals").is_dir()]
        closed += [here / name for name in shut]
        folders[:] = sorted(set(folders) - set(shut))
        links = [name for name in folders if (here / name).is_symlink()]
        found += [here / name for name in sorted([*files, *links])]
    return found, closed


def _refuse(error: OSError) -> None:
    raise InvalidFile(f"{error.filename}: cannot be read ({error.strerror}), expected a folder to read")


def is_named_for(name: str, code: str) -> bool:
    """Return True if a path has the participant's code under a key of Psych-DS or BIDS.

    >>> is_named_for("data/participant-P1_session-1_study-a_data.csv", "P1"), is_named_for("bids/sub-P10/x.tsv", "P1")
    (True, False)
    """
    keys = "|".join(_KEYS)
    return re.search(rf"(?:^|[/._])(?:{keys})-{re.escape(code)}(?=[/._]|$)", name) is not None


def _is_own(root: Path, path: Path, code: str) -> bool:
    return is_named_for(_name(root, path), code) or (_is_journal(root, path) and _whose(path) == code)


def _is_journal(root: Path, path: Path) -> bool:
    return path.parent == root / "journals" and path.suffix == ".jsonl" and "_interruptions" not in path.stem


def _whose(journal: Path) -> str | None:
    """Return the participant that the head of a journal names."""
    with suppress(InvalidFile):
        return next((head.participant for head in heads(journal)), None)
    return None


def _is_of_set(root: Path, path: Path) -> bool:
    """Return True for a file of the data set itself, or of another participant's session."""
    if path.parent == root:
        return path.name in (NAME, STUDY, RECORD, LOCK) or path in drafts(root, RECORD)
    return path.parent.parent == root and path.parent.name in PARTS and "participant" in keys_of(path.stem)


def _derived(root: Path, rest: Collection[Path]) -> Iterator[Path]:
    """Yield reports with their tables, figures, and the files of exports."""
    outputs = {path for path in rest if path.suffix.lower() in DERIVED}
    reports = {path for path in outputs if path.with_name(f"{path.stem}_tables").is_dir()}
    stems = {path.with_suffix("") for path in reports}
    folders = {path.with_name(f"{path.stem}_tables") for path in reports}
    folders |= {path.parent for path in outputs if all(path.with_suffix(end) in outputs for end in _FIGURE)}
    exports = {path.parent for path in rest if path.parent != root and _marks_export(path)}
    for path in rest:
        in_export = not exports.isdisjoint(path.parents)
        of_folder = in_export or path.parent in folders - {root} or _OF_TRIAL.fullmatch(path.name)
        is_output = path in outputs and (of_folder or path.with_suffix("") in stems)
        if is_output or (in_export and path.name in EXPORTED):
            yield path


def _marks_export(path: Path) -> bool:
    if path.name not in _BEGINNINGS or path.is_symlink():
        return False
    return read_file(path, "a file of an export").startswith(_BEGINNINGS[path.name])
