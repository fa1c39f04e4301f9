"""The files that hold trials: in a data set of ours, in BIDS, in a folder of another program."""

import filecmp
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from tactometry.errors import InvalidFile
from tactometry.files.durable import files_in

from ..wording import first_named
from .file_text import is_json_list

OWN_FILES = ("data/*_data.csv", "sub-*/**/beh/*_events.tsv", "sub-*/**/beh/*_beh.tsv")
"""Where trials are in a data set: our own, then BIDS."""
TABLES = (".csv", ".tsv", ".json", ".txt")
"""Endings of the tables that a column map reads; of several files of one name the first counts."""
OTHER_DATA = (".xlsx", ".xls", ".ods", ".psydat", ".mat", ".sav", ".rds", ".rda", ".parquet", ".pkl", ".h5", ".dat")
"""Endings of files that may hold trials and are not read."""
DESCRIPTIONS = ("participants", "dataset_description")
"""Names of files that describe a data set of BIDS and hold no trial."""
BEGINNING = 200
"""Bytes that say whether a file is a list in JSON."""
MOST_NAMED = 8

EXPORTED_MAP = "columns.toml"
"""The column map beside the tables of `tactometry export`."""


def trial_files(path: Path, *, foreign: bool = False) -> list[Path]:
    """The trials files of a data set (ours, or BIDS with behaviour), or the one file that `path` is.

    With `foreign`, a folder may also hold tables of another program, in itself or in ``data``.

    Raises
    ------
    InvalidFile
        If there is none.
    """
    if path.is_file():
        return [path]
    if not path.is_dir():
        raise InvalidFile(f"{path}: no such file or folder, expected a data set or a CSV file of trials")
    files = next((files for form in OWN_FILES if (files := _visible_files(path.glob(form)))), [])
    if not files and foreign:
        files = _tables_in(path) or _tables_in(path / "data")
    return files or _refuse_folder(path, foreign=foreign)


def _refuse_folder(path: Path, *, foreign: bool) -> list[Path]:
    for folder in (path, path / "data"):
        files_in(folder)  # a glob keeps silent about one that may not be read
    column_map = path / EXPORTED_MAP
    if not foreign and column_map.is_file():
        raise InvalidFile(
            f"{path}: found another program's tables and {EXPORTED_MAP}, which says how they are read, expected "
            f"--columns {column_map}; its first line is a comment with the whole command"
        )
    data_files = _data_files(path) if foreign else []
    folders = {file.parent.name for file in data_files if file.suffix.lower() in TABLES and file.parent != path}
    if folders:
        raise InvalidFile(
            f"{path}: found tables only in its subfolders ({first_named(sorted(folders), MOST_NAMED)}), expected them "
            "in the folder itself; analyse one subfolder at a time, or move the tables into one folder"
        )
    held = [file.name for file in data_files]
    if held:
        raise InvalidFile(
            f"{path}: found no table of trials but {first_named(held, MOST_NAMED)}, expected CSV, TSV or JSON; save "
            "each table as CSV"
        )
    raise InvalidFile(
        f"{path}: found no {OWN_FILES[0]}, expected a data set's folder, a CSV file of trials, or a column map "
        "(--columns) and a folder of another program's tables"
    )


def unread_notes(path: Path, used: Sequence[Path]) -> Iterator[str]:
    """Warn of the files and participants of a folder that are not read."""
    if path.is_file():
        return
    if any(part.startswith("sub-") for part in used[0].relative_to(path).parts[:1]):
        unread = [*_unread_subjects(path, used), *_other_runs(path, used)]
    elif used[0].match(OWN_FILES[0]):
        unread = [file for file in _data_files(path / "data") if file not in used and not _is_sidecar(file, used)]
    else:
        # A program saves one session in several forms, of which only one table is read.
        names = {file.stem for file in used}
        others = [file for file in _data_files(path) if file not in used]
        unread = [file for file in others if file.stem not in names or file.suffix.lower() in TABLES]
    if unread:
        yield f"not read: {first_named([str(file.relative_to(path)) for file in unread], MOST_NAMED)}"


def copy_notes(files: Sequence[Path]) -> Iterator[str]:
    """Warn of files with the same content."""
    by_size: dict[int, list[Path]] = {}
    for file in files:
        by_size.setdefault(file.stat().st_size, []).append(file)
    for group in by_size.values():
        for n, file in enumerate(group):
            first = next((other for other in group[:n] if filecmp.cmp(file, other, shallow=False)), None)
            if first is not None:
                yield (
                    f"{first.name} and {file.name} have the same content, and the trials of both were counted; remove "
                    "one if it is a copy"
                )


def _tables_in(folder: Path) -> list[Path]:
    """Tables of another program: all CSV, TSV and lists in JSON, else all text files."""
    held = (file for file in _visible_files(folder.glob("*")) if file.stem not in DESCRIPTIONS)
    files = [file for file in held if file.suffix.lower() in TABLES]
    sure = [file for file in files if file.suffix.lower() in (".csv", ".tsv") or _begins_list(file)]
    tables = sure or [file for file in files if file.suffix.lower() == ".txt"]
    first = {file.stem: file for file in sorted(tables, key=lambda file: -TABLES.index(file.suffix.lower()))}
    return sorted(first.values())


def _begins_list(file: Path) -> bool:
    with file.open("rb") as content:
        return is_json_list(content.read(BEGINNING).decode("utf-8-sig", "replace"))


def _data_files(path: Path) -> list[Path]:
    """Files that may hold trials: of the folder and of those within it."""
    files = _visible_files([*path.glob("*"), *(file for file in path.glob("*/*") if not _is_report(file.parent))])
    return [file for file in files if file.suffix.lower() in (*TABLES, *OTHER_DATA) and file.stem not in DESCRIPTIONS]


def _is_report(folder: Path) -> bool:
    """Return True for folders in which `analyse` writes its tables and figures."""
    return folder.name.endswith("_tables") or folder.name == "figures"


def _is_sidecar(file: Path, used: Sequence[Path]) -> bool:
    return file.suffix.lower() in (".json", ".tsv") and any(file.stem == other.stem for other in used)


def _unread_subjects(path: Path, used: Sequence[Path]) -> list[Path]:
    read = {file.relative_to(path).parts[0] for file in used}
    return sorted(folder for folder in path.glob("sub-*") if folder.is_dir() and folder.name not in read)


def _other_runs(path: Path, used: Sequence[Path]) -> list[Path]:
    """Tables of BIDS whose run is not among those that are read: of one run events or answers count."""
    runs = {_run(file) for file in used}
    files = (file for form in OWN_FILES[1:] for file in _visible_files(path.glob(form)))
    return [file for file in files if _run(file) not in runs and _in_read_subject(file, path, used)]


def _in_read_subject(file: Path, path: Path, used: Sequence[Path]) -> bool:
    subject = file.relative_to(path).parts[0]
    return any(other.relative_to(path).parts[0] == subject for other in used)


def _run(file: Path) -> Path:
    return file.with_name(re.sub(r"_(events|beh)\.tsv$", "", file.name))


def _visible_files(files: Iterable[Path]) -> list[Path]:
    """Return the files, sorted, without hidden ones (``._x_data.csv``) and Excel's lock files (``~$x.csv``)."""
    return sorted(file for file in files if file.is_file() and not file.name.startswith((".", "~$")))
