"""The files that hold trials: in a data set of ours, in BIDS, in a folder of another program."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from tactometry.errors import InvalidFile
from tactometry.files.durable import files_in

OWN_FILES = ("data/*_data.csv", "sub-*/**/beh/*_events.tsv", "sub-*/**/beh/*_beh.tsv")
"""Where trials stand in a data set: our own, then BIDS."""
FOREIGN_FILES = ("*.csv", "*.tsv", "data/*.csv", "*.json", "data/*.json")
"""Where they stand in a folder of another program, read through a column map."""

EXPORTED_MAP = "columns.toml"
"""The column map beside the tables of `tactometry export`."""


def trial_files(path: Path, forms: Sequence[str] = OWN_FILES) -> list[Path]:
    """The trials files of a data set (by default ours, or BIDS with behaviour), or the one file that `path` is.

    Raises
    ------
    InvalidFile
        If there is none.
    """
    if path.is_file():
        return [path]
    if not path.is_dir():
        raise InvalidFile(f"{path}: no such file or folder, expected a data set or a CSV file of trials")
    files = next((files for form in forms if (files := _visible_files(path.glob(form)))), [])
    if not files:
        for folder in (path, path / "data"):
            files_in(folder)  # a glob keeps silent about one that may not be read
        column_map = path / EXPORTED_MAP
        if forms == OWN_FILES and column_map.is_file():
            raise InvalidFile(
                f"{path}: found another program's tables and {EXPORTED_MAP}, which says how they are read, expected "
                f"--columns {column_map}; its first line is a comment with the whole command"
            )
        raise InvalidFile(
            f"{path}: found no {forms[0]}, expected a data set's folder, a CSV file of trials, or a column map "
            "(--columns) and a folder of another program's tables"
        )
    return files


def _visible_files(files: Iterable[Path]) -> list[Path]:
    """Files, sorted, without those that a system hides beside them (``._x_data.csv``)."""
    return sorted(file for file in files if not file.name.startswith("."))
