"""Data sets for other programs: one function per form."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from tactometry.arguments.require import one_of

from .bids import bids_files
from .psychds import psychds_files
from .psychopy_csv import psychopy_files
from .r_table import r_files
from .source import ExportedDataSet, read_source, write_files

FORMS: Mapping[str, Callable[[ExportedDataSet], dict[str, bytes]]] = {
    "psych-ds": psychds_files,
    "psychopy": psychopy_files,
    "r": r_files,
}


def export(path: Path, form: str, out: Path, authors: Sequence[str] = ()) -> list[Path]:
    """Write the data set or trials file at `path` as `bids`, `psych-ds`, `psychopy` or `r` into a new or empty folder.

    Raises
    ------
    InvalidParameter
        If the form is unknown or the folder holds something.
    InvalidFile
        If the data set is damaged.
    DeviceFailed
        If the folder cannot be written.
    """
    one_of("--to", form, ("bids", *FORMS))
    source = read_source(path)
    return write_files(bids_files(source, authors) if form == "bids" else FORMS[form](source), out)
