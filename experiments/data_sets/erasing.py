"""Erase one participant from a data set, and keep the files of others.

- *Own* files have the participant's code in their name, or are the participant's journal under another name.
- *Derived* files are reports, figures and exports. All derived files are erased, as a mean contains every participant.
- *Other* files are not searched. Their names are returned so that the experimenter can check them.

The list of files to erase is first saved to disk, so that an interrupted erasure can be finished.
"""

import os
import re
from collections.abc import Collection, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from tactometry import __version__
from tactometry.arguments.require import expect
from tactometry.errors import InvalidFile, InvalidParameter, attempt, nearest
from tactometry.files.durable import drafts, read_file, sync_folder
from tactometry.files.rows import LIST_OF_TABLES
from tactometry.records.data_set import PARTS, keys_of, refuse_links, sessions
from tactometry.records.description import NAME
from tactometry.records.erasures import LOCK, RECORD, Erasure, read_erasures, unfinished, write_erasures
from tactometry.records.head import heads
from tactometry.records.open_journal import alone, held
from tactometry.trials.cells import PARTICIPANT


@dataclass(frozen=True)
class ErasurePlan:
    """Files to erase, and names of other files and folders to check."""

    journals: tuple[Path, ...]
    own: tuple[Path, ...]
    derived: tuple[Path, ...]
    others: tuple[str, ...]

    @property
    def files(self) -> tuple[Path, ...]:
        """All files to erase, journals last. The plan requires a journal."""
        return (*self.derived, *self.own, *self.journals)


UNREACHED: Final = (
    "not reached: backups, copies elsewhere, the history of git, the list of codes and names; and no program can "
    "promise that an SSD overwrites what it erases: keep data on an encrypted disk"
)

IN_USE: Final = "another process is erasing from this data set, expected to be the only one; wait and repeat"


@dataclass(frozen=True)
class Erased:
    """Names of erased files and files to check. A dry run has no `erasure`."""

    participant: str
    n_sessions: int
    own: tuple[str, ...]
    derived: tuple[str, ...]
    others: tuple[str, ...]
    erasure: Erasure | None = None
    not_reached: str = UNREACHED


def find(root: Path, participant: str) -> Erased:
    """List what an erasure would remove, without removing it.

    Raises `InvalidFile` if the folder is not a data set or cannot be read completely. Raises `InvalidParameter` if it
    contains no files of the participant.
    """
    return _told(root, participant, _plan(root, participant))


def erase(root: Path, participant: str) -> Erased:
    """Erase all files of a participant from a data set and record it.

    Raises `InvalidFile` or `InvalidParameter` as for `find`. Raises `SessionInUse` if a session of the participant or
    another erasure is running. Nothing was erased. Raises `DeviceFailed` if a file cannot be erased. Fix the cause and
    repeat.
    """
    _refuse(root, participant)
    with alone(root / LOCK, IN_USE):
        return _erase(root, participant)


def _erase(root: Path, participant: str) -> Erased:
    before = _there(_plan(root, participant).journals)
    with held(before):
        result = _plan(root, participant)
        with held(_there(result.journals) - before):  # journals of a session that began meanwhile
            planned, begun = _told(root, participant, result), _begin(root, participant, result)
            _remove(result.files if os.name == "posix" else (*result.derived, *result.own))
    _remove(result.journals)  # other systems cannot erase an open file
    _remove_empty(root, {*result.files, *(root / name for name in begun.files)})
    done = replace(begun, finished_utc=_now(), files=())
    write_erasures(root, [done if erasure == begun else erasure for erasure in read_erasures(root)])
    _remove(drafts(root, RECORD))  # drafts of the record, left by an interruption
    return replace(planned, n_sessions=done.n_sessions, erasure=done)


def _there(journals: Iterable[Path]) -> set[Path]:
    """Return the existing journals. Locking a broken link creates its target."""
    return {path for path in journals if path.exists()}


def _refuse(root: Path, participant: str) -> None:
    expect(PARTICIPANT.fullmatch(participant) is not None, "--participant", repr(participant), "a code such as P01")
    is_set = (root / NAME).is_file() and ((root / "journals").is_dir() or (root / "data").is_dir())
    expect(is_set, root, f"no {NAME} with data or journals", "the folder of a data set", InvalidFile)
    refuse_links(root)  # all erased files could be rebuilt from a journal that remains


def _plan(root: Path, participant: str) -> ErasurePlan:
    _refuse(root, participant)
    erasures = read_erasures(root)
    begun = unfinished(erasures, participant)
    result = plan(root, participant, begun.files if begun else ())
    if not result.own and not result.journals and begun is None:
        raise InvalidParameter(_nothing(root, participant, erasures))
    return result


def _nothing(root: Path, participant: str, erasures: Iterable[Erasure]) -> str:
    times = [erasure.finished_utc for erasure in erasures if erasure.participant == participant]
    if times:
        erased = f"found that {participant} was erased at {times[-1]}"
        return f"--participant: {erased}, expected a participant with data in {root}"
    files = [*sessions(root), *(root / "data").glob("*.csv")]
    codes = sorted({code for path in files if (code := keys_of(path.stem).get("participant"))})
    known = f"{', '.join(codes) or 'the participants with data (none)'}{nearest(participant, codes)}"
    return f"--participant: found nothing of {participant!r} in {root}, expected one of {known}"


def _told(root: Path, participant: str, found: ErasurePlan) -> Erased:
    own, derived = _names(root, (*found.own, *found.journals)), _names(root, found.derived)
    return Erased(participant, len(found.journals), own, derived, found.others)


def _names(root: Path, paths: Iterable[Path]) -> tuple[str, ...]:
    return tuple(path.relative_to(root).as_posix() for path in sorted(paths))


def _begin(root: Path, participant: str, found: ErasurePlan) -> Erasure:
    """Record an erasure, or return the interrupted one to continue."""
    erasures = read_erasures(root)
    before = unfinished(erasures, participant)
    if before is not None:
        return before
    files = _names(root, found.files)
    begun = Erasure(participant, _now(), __version__, len(found.journals), len(files), files=files)
    write_erasures(root, [*erasures, begun])
    return begun


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")


def _remove(files: Iterable[Path]) -> None:
    """Remove files and sync their folders."""
    files = tuple(files)
    for path in files:
        with attempt(path, "cannot be erased", "permission; fix that and repeat: the erasure continues"):
            path.unlink(missing_ok=True)
    for folder in sorted({path.parent for path in files}):
        if folder.is_dir():
            sync_folder(folder)


def _remove_empty(root: Path, files: Iterable[Path]) -> None:
    """Remove empty folders, except the standard folders of a data set."""
    kept = {root / part for part in PARTS}
    within = [path for path in files if ".." not in path.parts]
    folders = {folder for path in within for folder in path.parents if folder.is_relative_to(root)}
    for folder in sorted(folders - kept, key=lambda path: len(path.parts), reverse=True):
        with suppress(OSError):  # the folder is not empty
            folder.rmdir()


STUDY: Final = "study.toml"
DERIVED: Final = frozenset((".csv", ".gz", ".htm", ".html", ".json", ".jsonl", ".pdf", ".png", ".svg", ".tsv"))
"""Suffixes of files that `analyse`, `show` and `export` write."""
EXPORTED: Final = frozenset(("README.md", "CHANGES.md", "columns.toml", "trials.R"))
"""Further files that `export` writes."""
_FIGURE: Final = (".csv", ".png", ".svg")
_OF_TRIAL: Final = re.compile(r"trial-\d+\.(png|pdf|svg)")
_BEGINNINGS: Final = {NAME: b"", "columns.toml": b"# tactometry analyse", "trials.R": b"# Reads trials.csv"}
"""Files that identify a folder as an export, and the first bytes of each."""
_KEYS: Final = ("participant", "subject", "sub")


def plan(root: Path, code: str, begun: Collection[str] = ()) -> ErasurePlan:
    """Return the files to erase for a participant.

    `begun` are the files of an interrupted erasure.

    Raises `InvalidFile` if a file or folder cannot be read.
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
    """Return files and links, and skipped folders (hidden ones, data sets)."""
    result, closed = [], []
    for folder, folders, files in os.walk(root, onerror=_refuse_unread):
        here = Path(folder)
        shut = [name for name in sorted(folders) if name.startswith(".") or (here / name / "journals").is_dir()]
        closed += [here / name for name in shut]
        folders[:] = sorted(set(folders) - set(shut))
        links = [name for name in folders if (here / name).is_symlink()]
        result += [here / name for name in sorted([*files, *links])]
    return result, closed


def _refuse_unread(error: OSError) -> None:
    raise InvalidFile(f"{error.filename}: cannot be read ({error.strerror}), expected a readable folder")


def is_named_for(name: str, code: str) -> bool:
    """Return True if a file or folder name contains the participant's code.

    The code must follow a key of Psych-DS or BIDS.

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
    with suppress(InvalidFile):
        return next((head.participant for head in heads(journal)), None)
    return None


def _is_of_set(root: Path, path: Path) -> bool:
    """Return True for general files of the data set and sessions of others."""
    if path.parent == root:
        return path.name in (NAME, STUDY, RECORD, LOCK) or path in drafts(root, RECORD)
    return path.parent.parent == root and path.parent.name in PARTS and "participant" in keys_of(path.stem)


def _derived(root: Path, rest: Collection[Path]) -> Iterator[Path]:
    """Yield reports with their tables, figures, and exported files."""
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
        is_index = path.name == LIST_OF_TABLES and path.parent in folders
        if is_output or is_index or (in_export and path.name in EXPORTED):
            yield path


def _marks_export(path: Path) -> bool:
    if path.name not in _BEGINNINGS or path.is_symlink():
        return False
    return read_file(path, "a file of an export").startswith(_BEGINNINGS[path.name])
