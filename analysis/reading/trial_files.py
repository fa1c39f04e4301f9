"""Search for trials files, and reading of table files as normalised text."""

import filecmp
import re
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from tactometry.errors import InvalidFile
from tactometry.files.durable import files_in, read_file

from ..wording import first_named

WORKBOOK = "an Excel workbook; save its sheet as CSV"
PICKLE = "a Python pickle such as PsychoPy's .psydat; use the CSV file, or save one with saveAsWideText"
UTF_16 = "UTF-16 text such as Excel's Unicode text; save the table as CSV in UTF-8"
SIGNATURES = (
    (b"PK\x03\x04", WORKBOOK),
    (b"\xd0\xcf\x11\xe0", "an old Excel workbook (.xls); save its sheet as CSV"),
    *((bytes((0x80, protocol)), PICKLE) for protocol in (2, 3, 4, 5)),
    (b"\x1f\x8b", "a compressed file; unpack it"),
    (b"MATLAB 5.0", "a MATLAB file; save the table as CSV (writetable)"),
    (b"\x89HDF", "an HDF5 or MATLAB 7.3 file; save the table as CSV"),
    (b"$FL", "an SPSS file; save the table as CSV"),
    (b"PAR1", "a Parquet file; save the table as CSV"),
    (b"\xff\xfe", UTF_16),
    (b"\xfe\xff", UTF_16),
)
"""First bytes of unsupported files, with the kind of file and how to export a text table."""
_INVISIBLE = re.compile("[\u200b\u200e\u200f\u2060\ufeff]")
_MINUS = re.compile("[\u2212\uff0d](?=[.,]?[0-9])")
_JSON_LIST = re.compile(r"\s*\[\s*[{\]]")


def file_text(file: Path, *, verbatim: bool = False) -> str:
    """Read UTF-8 text, normalised by `plain_text` unless `verbatim`.

    Raises `InvalidFile` if the file cannot be read, is empty, or is not UTF-8 text.
    """
    content = read_file(file, "a table of trials")
    kinds = [kind for signature, kind in SIGNATURES if content.startswith(signature)]
    kinds += [PICKLE] if file.suffix.lower() == ".psydat" else []
    if kinds:
        raise InvalidFile(f"{file}: found {_kind_of_archive(content, kinds[0])}")
    try:
        text = content.decode("utf-8-sig")  # spreadsheets write a byte order mark
    except UnicodeDecodeError as damage:
        row = content.count(b"\n", 0, damage.start) + 1
        raise InvalidFile(
            f"{file}, row {row}: found the byte 0x{content[damage.start]:02x}, expected UTF-8 text; save the table as "
            "UTF-8"
        ) from None
    if "\0" in text:
        row = text.count("\n", 0, text.index("\0")) + 1
        raise InvalidFile(f"{file}, row {row}: found a null byte, expected text")
    if not text.strip():
        raise InvalidFile(f"{file}: found an empty file, expected a header and trials")
    return text if verbatim else plain_text(text)


def _kind_of_archive(content: bytes, kind: str) -> str:
    """Distinguish a spreadsheet from another ZIP archive."""
    if kind != WORKBOOK or b"xl/" in content:
        return kind
    if b"opendocument" in content:
        return "an OpenDocument spreadsheet; save its sheet as CSV"
    return "a ZIP archive; unpack it and pass the folder"


def plain_text(text: str) -> str:
    r"""Normalise to NFC and ASCII minus signs, and remove invisible characters.

    >>> plain_text("\u221212\u200b"), plain_text("gro\u0308\u00dfe") == "gr\u00f6\u00dfe"
    ('-12', True)
    """
    return text if text.isascii() else _MINUS.sub("-", _INVISIBLE.sub("", unicodedata.normalize("NFC", text)))


def trimmed(text: str) -> str:
    """Trim a text, except one of spaces only, such as jsPsych's space bar.

    >>> trimmed(" S01 "), trimmed(" ")
    ('S01', ' ')
    """
    return text.strip() or text


def is_json_list(text: str) -> bool:
    """Return True if a text begins like a JSON list of objects.

    >>> is_json_list('[{"level": 2}]'), is_json_list("level,response"), is_json_list("[mm],answer")
    (True, False, False)
    """
    return _JSON_LIST.match(text) is not None


OWN_FILES = ("data/*_data.csv", "sub-*/**/beh/*_events.tsv", "sub-*/**/beh/*_beh.tsv")
"""Patterns of trials files: in Tactometry's data sets, then in BIDS."""
TABLES = (".csv", ".tsv", ".json", ".txt")
"""Extensions of readable tables, in order of preference for files with the same name."""
OTHER_DATA = (".xlsx", ".xls", ".ods", ".psydat", ".mat", ".sav", ".rds", ".rda", ".parquet", ".pkl", ".h5", ".dat")
"""Extensions of files that may contain trials but cannot be read."""
DESCRIPTIONS = ("participants", "dataset_description")
"""Names of BIDS files that describe the data set, without trials."""
BEGINNING = 200
"""Number of bytes read to detect a JSON list."""
MOST_NAMED = 8

EXPORTED_MAP = "columns.toml"
"""File name of the column map that `tactometry export` writes next to its tables."""


def trial_files(path: Path, *, foreign: bool = False) -> list[Path]:
    """Return the trials files of a folder, or `path` if it is a file.

    With `foreign`, a folder may also contain another program's tables, directly or in ``data``.

    Raises `InvalidFile` if there is none.
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
        files_in(folder)  # report unreadable folders, which a glob skips
    column_map = path / EXPORTED_MAP
    if not foreign and column_map.is_file():
        raise InvalidFile(
            f"{path}: found another program's tables with the column map {EXPORTED_MAP}, expected "
            f"--columns {column_map}; the comment in its first line is the complete command"
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
            f"{path}: found only {first_named(held, MOST_NAMED)}, expected CSV, TSV or JSON; save each table as CSV"
        )
    raise InvalidFile(
        f"{path}: found no {OWN_FILES[0]}, expected a data set's folder, a CSV file of trials, or a column map "
        "(--columns) and a folder of another program's tables"
    )


def unread_notes(path: Path, used: Sequence[Path]) -> Iterator[str]:
    """Warn about files and participants of a folder that are not read."""
    if path.is_file():
        return
    if any(part.startswith("sub-") for part in used[0].relative_to(path).parts[:1]):
        unread = _unread_in_bids(path, used)
    else:
        # Skip the sidecars of our tables, and copies of a session that another program saved in a second format.
        is_own, names = used[0].match(OWN_FILES[0]), {file.stem for file in used}
        copies = (".json", ".tsv") if is_own else OTHER_DATA
        others = [file for file in _data_files(path / "data" if is_own else path) if file not in used]
        unread = [file for file in others if file.stem not in names or file.suffix.lower() not in copies]
    if unread:
        yield f"files not read: {first_named([str(file.relative_to(path)) for file in unread], MOST_NAMED)}"


def copy_notes(files: Sequence[Path]) -> Iterator[str]:
    """Warn about files with the same content."""
    by_size: dict[int, list[Path]] = {}
    for file in files:
        by_size.setdefault(file.stat().st_size, []).append(file)
    for group in by_size.values():
        for n, file in enumerate(group):
            first = next((other for other in group[:n] if filecmp.cmp(file, other, shallow=False)), None)
            if first is not None:
                yield (
                    f"{first.name} and {file.name} have the same content, but the trials of both were counted; remove "
                    "one if it is a copy"
                )


def _tables_in(folder: Path) -> list[Path]:
    """Return another program's CSV, TSV and JSON tables, or text files."""
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
    """Return files in a folder and its subfolders that may contain trials."""
    # skip the folders of reports (tables and figures)
    inner = [file for file in path.glob("*/*") if not re.search("(^figures|_tables)$", file.parent.name)]
    files = _visible_files([*path.glob("*"), *inner])
    return [file for file in files if file.suffix.lower() in (*TABLES, *OTHER_DATA) and file.stem not in DESCRIPTIONS]


def _unread_in_bids(path: Path, used: Sequence[Path]) -> list[Path]:
    """Return unread subjects, and unread runs of other subjects."""
    read, runs = {file.relative_to(path).parts[0] for file in used}, {_run(file) for file in used}
    subjects = sorted(folder for folder in path.glob("sub-*") if folder.is_dir() and folder.name not in read)
    files = (file for form in OWN_FILES[1:] for file in _visible_files(path.glob(form)))
    others = (file for file in files if _run(file) not in runs and file.relative_to(path).parts[0] in read)
    return [*subjects, *others]


def _run(file: Path) -> Path:
    return file.with_name(re.sub(r"_(events|beh)\.tsv$", "", file.name))


def _visible_files(files: Iterable[Path]) -> list[Path]:
    """Return the sorted files without hidden files and Excel's lock files."""
    return sorted(file for file in files if file.is_file() and not file.name.startswith((".", "~$")))
