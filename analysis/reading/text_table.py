"""Reading of table files as text cells, without interpretation.

Every error names the file and, if possible, the row (the header is row 1).
"""

import csv
import io
import json
import re
from collections import Counter
from collections.abc import Container, Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd

from tactometry.errors import InvalidFile
from tactometry.files.json_file import json_items
from tactometry.trials.row_rules import MOST_COLUMNS

from .trial_files import file_text, is_json_list, trimmed

TEXT = pd.StringDtype("python", na_value=np.nan)
"""Data type of cells, which does not depend on pyarrow being installed."""
MOST_EMPTY = 10_000_000
"""Largest number of empty cells in a JSON table; otherwise a small file could exhaust memory."""
LAST_LINE = "end"
"""Line appended to a table to detect unclosed quotation marks."""
FEWEST_LOST = 12
"""Fewest cells of a single line that count as lost line breaks, as a short line may be a header."""
_LINE_BREAK = re.compile(r"\r\n|\r|\n")
_SEP_LINE = re.compile(r'"?sep=([^\r\n"])"?[;,\t]*(?:\r\n|\r|\n)', re.IGNORECASE)


def text_cells(
    file: Path,
    separator: str = "",
    *,
    needed: Container[str] | None = None,
    notes: list[str] | None = None,
    verbatim: bool = False,
) -> pd.DataFrame:
    """Read all cells as text, with the row number in the column `row`.

    A list of JSON objects is read by `json_cells`, whatever the file name. By default the `separator` is that of a
    first line such as ``sep=;``, or else a comma (in ``.tsv`` files a tab). Empty columns without a name are omitted,
    as PsychoPy ends each row with a comma. An unnamed first column that counts the rows, and repeated columns that are
    not `needed` (None: all are needed), are omitted with a note in `notes`. Text is normalised (`plain_text`) and
    trimmed, unless it is `verbatim`.

    Raises `InvalidFile` if the file cannot be read, is not UTF-8 text or not a table, or has rows of different lengths,
    more than `MOST_COLUMNS` columns, or an unnamed or repeated column.
    """
    text = file_text(file, verbatim=verbatim)
    notes = [] if notes is None else notes
    if file.suffix.lower() == ".json" or is_json_list(text):
        return _trimmed_cells(json_cells(text, file), "" if verbatim else text)
    text, stated, n_before = _without_sep_line(text)
    header = text[: text.find("\n")] if "\n" in text else text
    if not separator:
        separator = stated or ("\t" if file.suffix.lower() == ".tsv" else ",")
        _expect_commas(header, separator, file)
    _expect_lines(text, separator, file)
    _expect_few_columns(header.count(separator) + 1, f"{file}, row {n_before + 1}")
    cells = plain_cells(text, separator)
    if cells is None:
        cells = _any_cells(text, separator, file, n_before)
    table = _with_header(cells.set_axis(cells.index + n_before), file, needed, notes)
    return _trimmed_cells(table, "" if verbatim else text, separator)


def _trimmed_cells(table: pd.DataFrame, text: str, separator: str = ",") -> pd.DataFrame:
    """Trim spaces around cells."""
    ends = (separator, "\n", "\r", '"')
    if not any(f"{space}{end}" in text or f"{end}{space}" in text for end in ends for space in (" ", "\u00a0")):
        return table
    return table.assign(**{name: table[name].map(trimmed) for name in table.columns if name != "row"})


def _without_sep_line(text: str) -> tuple[str, str, int]:
    r"""Remove Excel's line ``sep=,``; return text, separator, lines removed.

    >>> _without_sep_line("sep=;\r\na;b"), _without_sep_line("a,b")
    (('a;b', ';', 1), ('a,b', '', 0))
    """
    result = _SEP_LINE.match(text)
    return (text[result.end() :], result[1], 1) if result else (text, "", 0)


def _expect_lines(text: str, separator: str, file: Path) -> None:
    """Raise for a table whose line breaks were lost."""
    if "\n" in text.strip() or "\r" in text.strip() or '"' in text:
        return
    cells = text.strip().split(separator)
    if len(cells) > len({*cells}) and len(cells) > FEWEST_LOST:
        raise InvalidFile(
            f"{file}: found one line of {len(cells)} cells, expected a line for each row; the line breaks were lost"
        )


def json_cells(text: str, file: Path) -> pd.DataFrame:
    """Read trials from JSON as text, with the position in the list as `row`.

    The text is a list with an object per trial, as saved by jsPsych, or several such lists in sequence, as saved by
    JATOS. Each key becomes a column. Numbers are unchanged, true and false become words, null and missing keys become
    empty. Nested lists and objects stay JSON.

    Raises `InvalidFile` if the text is not JSON or not a list of objects, or has more than `MOST_COLUMNS` keys or
    `MOST_EMPTY` empty cells.

    >>> json_cells('[{"level": 0.10, "correct": true}, {"rt": null}]', Path("j.json")).values.tolist()
    [['0.10', 'true', '', 1], ['', '', '', 2]]
    """
    cells, names = [], dict[str, None]()
    for trial in _json_trials(text, file):
        cells.append({name.strip(): _json_text(value) for name, value in trial.items()})
        names.update(dict.fromkeys(cells[-1]))
        _expect_few_columns(len(names), f"{file}, trial {len(cells)}", "keys")
    n_empty = len(cells) * len(names) - sum(map(len, cells))
    if n_empty > MOST_EMPTY:
        raise InvalidFile(
            f"{file}: found {len(cells)} trials with {len(names)} keys in all, with {n_empty} empty cells, "
            f"expected at most {MOST_EMPTY}. Use the same keys in all trials"
        )
    table = pd.DataFrame([[row.get(name, "") for name in names] for row in cells], columns=list(names), dtype=TEXT)
    return table.assign(row=range(1, len(cells) + 1))


def _json_trials(text: str, file: Path) -> Iterator[dict[str, object]]:
    """Yield the trials one by one, so that the caller can stop early."""
    n = 0
    try:
        for n, trial in enumerate(json_items(text), 1):
            if not isinstance(trial, dict):
                raise ValueError(f"item {n} is not an object")
            yield trial
        if n == 0:
            raise ValueError("it is empty")
    except ValueError as damage:
        raise InvalidFile(
            f"{file}: found no JSON list of objects ({damage}), expected an object for each trial, as saved by jsPsych"
        ) from None


def _expect_few_columns(n: int, where: str, what: str = "columns") -> None:
    if n > MOST_COLUMNS:
        raise InvalidFile(
            f"{where}: found {n} {what}, expected at most {MOST_COLUMNS}, with a row for each trial and a column for "
            "each variable"
        )


def _json_text(value: object) -> str:
    if value is None:
        return ""
    return value if isinstance(value, str) else json.dumps(value)


def _expect_commas(header: str, separator: str, file: Path) -> None:
    if separator == "," and "," not in header and (";" in header or "\t" in header):
        raise InvalidFile(
            f"{file}, row 1: found columns separated by {';' if ';' in header else 'tabs'}, expected commas, or tabs "
            "in a .tsv file; save it as comma-separated values with decimal points, or set the separator in a column "
            "map"
        )


def plain_cells(text: str, separator: str) -> pd.DataFrame | None:
    """Read all cells and the header as text with pandas' C parser.

    Returns None if there is a quotation mark, a blank line or a row of different length, which the slower reader
    handles.

    >>> plain_cells("a,b" + chr(10) + "1,2", ",").values.tolist()
    [['a', 'b'], ['1', '2']]
    >>> plain_cells("a,b" + chr(10) + "1", ",") is None
    True
    """
    whole = text.rstrip("\r\n")
    has_blank_line = "\n\n" in whole or "\r\n\r" in whole or whole.startswith(("\n", "\r"))
    if not whole or '"' in whole or has_blank_line or whole.count("\r") != whole.count("\r\n"):
        return None
    in_header, rows = whole.partition("\n")[0].count(separator), whole.count("\n") + 1
    # The parser raises for longer rows but pads shorter ones, so lengths are checked here.
    if in_header == 0 or whole.count(separator) != in_header * rows:
        return None
    try:
        return pd.read_csv(
            io.StringIO(whole),
            sep=separator,
            header=None,
            dtype=TEXT,
            na_filter=False,  # keep "NA" as text for the column map
            quoting=csv.QUOTE_NONE,
            skip_blank_lines=False,
        )
    except pd.errors.ParserError:
        return None


def _any_cells(text: str, separator: str, file: Path, n_before: int = 0) -> pd.DataFrame:
    lines = text if text.endswith("\n") else f"{text}\n"
    try:
        # An unclosed quotation mark absorbs the appended line, which is then not a separate row.
        reader = csv.reader(io.StringIO(f"{lines}{LAST_LINE}", newline=""), delimiter=separator)
        *rows, end = reader
    except csv.Error as damage:
        raise InvalidFile(f"{file}: found a damaged table ({damage}), expected comma-separated values") from None
    if end != [LAST_LINE]:
        raise InvalidFile(f"{file}: found an unclosed quotation mark, expected quotation marks in pairs")
    if _is_counted(rows):
        rows[0].insert(0, "")
    n_columns = max(1, len(rows[0]))
    has_breaks = reader.line_num > len(rows) + 1
    for row, cells in enumerate(rows, start=n_before + 1):
        if has_breaks and any(_holds_rows(n, cell, separator, n_columns) for n, cell in enumerate(cells)):
            raise InvalidFile(
                f"{file}, row {row}: found a quoted cell that extends over several rows, expected a closing quotation "
                "mark in the same row; remove the mark, or double it within a quoted cell"
            )
        if len(cells) not in (0, n_columns):
            raise InvalidFile(f"{file}, row {row}: found {len(cells)} cells, expected {n_columns} as in the header")
    return pd.DataFrame([cells or [""] * n_columns for cells in rows], dtype=TEXT)


def _is_counted(rows: list[list[str]]) -> bool:
    """Return True if rows start with numbers without a header, as from R."""
    body = [cells for cells in rows[1:] if cells]
    return bool(body) and {len(cells) for cells in body} == {len(rows[0]) + 1} and _counts([row[0] for row in body])


def _holds_rows(place: int, cell: str, separator: str, n_columns: int) -> bool:
    r"""Return True if a cell contains the end and start of a row.

    >>> _holds_rows(1, "fast,4,n\nS01,", ",", 4), _holds_rows(1, "fast, but\nnot too fast", ",", 4)
    (True, False)
    """
    lines = _LINE_BREAK.split(cell)
    return len(lines) > 1 and (
        lines[0].count(separator) >= n_columns - 1 - place and lines[-1].count(separator) >= place
    )


def _with_header(cells: pd.DataFrame, file: Path, needed: Container[str] | None, notes: list[str]) -> pd.DataFrame:
    cells = _without_nameless(cells, file, notes)
    header = int(cells.index[0]) + 1
    names = [str(name).strip() for name in cells.iloc[0]]
    for place, name in zip(map(int, cells.columns), names, strict=True):
        if not name:
            raise InvalidFile(
                f"{file}, row {header}: found no name for column {place + 1}, expected a name for each column"
            )
    repeated = [word for word, n in Counter(names).items() if n > 1]
    for word in repeated:
        if needed is None or word in needed:
            raise InvalidFile(f"{file}, row {header}: found the column {word!r} twice, expected unique names")
        notes.append(f"{file.name}: the column {word!r} appears {names.count(word)} times and was not read")
    body = cells.iloc[1:].set_axis(names, axis=1)[[name for name in names if name not in repeated]]
    if body.shape[1] > 1:  # in a table with one column an empty line is an empty cell
        begun = body[body.iloc[:, 0] == ""]  # compare only rows that begin with an empty cell
        body = body.drop(index=begun.index[(begun == "").all(axis=1)]) if len(begun) else body
    return body.assign(row=body.index + 1)


def _without_nameless(cells: pd.DataFrame, file: Path, notes: list[str]) -> pd.DataFrame:
    """Remove unnamed columns that are empty or contain row numbers."""
    nameless = [place for place in cells.columns if not str(cells[place].iloc[0]).strip()]
    unused = [place for place in nameless if (cells[place].str.strip() == "").all()]
    first = cells.columns[0]
    if first in nameless and first not in unused and _counts(cells[first].iloc[1:].tolist()):
        notes.append(f"{file.name}: the first column has no name and contains row numbers; it was not read")
        unused.append(first)
    return cells.drop(columns=unused)


def _counts(words: Sequence[str]) -> bool:
    """Return True if non-empty cells are increasing integers.

    >>> _counts(["0", "1", "5", ""]), _counts(["2", "2"]), _counts(["S01"])
    (True, False, False)
    """
    held = [word for word in words if word]
    if not held or not all(word.isdecimal() for word in held):
        return False
    numbers = list(map(int, held))
    return all(before < after for before, after in pairwise(numbers))
