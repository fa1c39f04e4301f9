"""A table on disk as text: its cells under their names, nothing of them understood yet.

Every refusal is one sentence with the file and, where there is one, the row (the header is row 1).
"""

import csv
import io
import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from tactometry.errors import InvalidFile
from tactometry.files.durable import read_file
from tactometry.files.json_file import json_items
from tactometry.trials.row_rules import MOST_COLUMNS

TEXT = pd.StringDtype("python", na_value=np.nan)
"""Of a cell: the same whether pyarrow is installed or not, without which `str` is this."""
MOST_EMPTY = 10_000_000
"""Cells without a value in a table of JSON, which a small file could otherwise fill the memory with."""
LAST_LINE = "end"
"""Put behind a table that may hold quotation marks."""


def text_cells(file: Path, separator: str = "") -> pd.DataFrame:
    """All cells as text, with the number of their row in the column `row`; a ``.json`` file is read by `json_cells`.

    Columns without a name that are empty throughout are left out: PsychoPy ends each row with a comma. The `separator`
    is by default a comma, in ``.tsv`` a tab.

    Raises
    ------
    InvalidFile
        If the file cannot be read, is no text in UTF-8 or no table, or has rows of different lengths, more than
        `MOST_COLUMNS`, or a column without a name or with that of another.
    """
    text = _text(file)
    if file.suffix == ".json":
        return json_cells(text, file)
    header = text[: text.find("\n")] if "\n" in text else text
    if not separator:
        separator = "\t" if file.suffix == ".tsv" else ","
        _expect_commas(header, separator, file)
    _expect_few_columns(header.count(separator) + 1, f"{file}, row 1")
    cells = plain_cells(text, separator)
    if cells is None:
        cells = _any_cells(text, separator, file)
    return _with_header(cells, file)


def json_cells(text: str, file: Path) -> pd.DataFrame:
    """Of a table of trials in JSON, as jsPsych saves it: a list with an object for each trial; or several such lists,
    one after the other, as servers keep them (JATOS).

    All values as text, a column for each key, and in the column `row` the place in the list, from 1.
    Numbers stay as they were written, true and false are words, null and what an object has not are empty; a list or
    an object within stays JSON.

    Raises
    ------
    InvalidFile
        If it is no JSON, or another than a list of objects; or if it has more keys than `MOST_COLUMNS`, or more
        than `MOST_EMPTY` trials and keys without a value.

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
            f"{file}: found {len(cells)} trials with {len(names)} keys in all, of which {n_empty} cells are empty, "
            f"expected at most {MOST_EMPTY}; name what all trials have alike"
        )
    table = pd.DataFrame([[row.get(name, "") for name in names] for row in cells], columns=list(names), dtype=TEXT)
    return table.assign(row=range(1, len(cells) + 1))


def _json_trials(text: str, file: Path) -> Iterator[dict[str, object]]:
    """Parse the trials one by one, so that a table beyond the bounds is not read to its end."""
    n = 0
    try:
        for n, trial in enumerate(json_items(text), 1):
            if not isinstance(trial, dict):
                raise ValueError(f"item {n} is another")
            yield trial
        if n == 0:
            raise ValueError("it is empty")
    except ValueError as damage:
        raise InvalidFile(
            f"{file}: found no list of objects in JSON ({damage}), expected one for each trial, as jsPsych saves them"
        ) from None


def _expect_few_columns(n: int, where: str, what: str = "columns") -> None:
    if n > MOST_COLUMNS:
        raise InvalidFile(
            f"{where}: found {n} {what}, expected at most {MOST_COLUMNS}: a row for each trial, a column for what is "
            "known of it"
        )


def _json_text(value: object) -> str:
    if value is None:
        return ""
    return value if isinstance(value, str) else json.dumps(value)


def _expect_commas(header: str, separator: str, file: Path) -> None:
    if separator == "," and "," not in header and (";" in header or "\t" in header):
        raise InvalidFile(
            f"{file}, row 1: found columns separated by {';' if ';' in header else 'tabs'}, expected commas (or a file "
            "named .tsv with tabs); save it as comma-separated values with decimal points, or say so in a column map"
        )


def plain_cells(text: str, separator: str) -> pd.DataFrame | None:
    """All cells as text, the header too, read by pandas' parser in C; None if there is a quotation mark, blank line or
    row of another length: the slower reader says then what is wrong.

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
    # The parser refuses a longer row and fills a shorter one: without the former there is none of the latter.
    if in_header == 0 or whole.count(separator) != in_header * rows:
        return None
    try:
        return pd.read_csv(
            io.StringIO(whole),
            sep=separator,
            header=None,
            dtype=TEXT,
            na_filter=False,  # "NA" is a word, whose meaning a column map says
            quoting=csv.QUOTE_NONE,
            skip_blank_lines=False,
        )
    except pd.errors.ParserError:
        return None


def _any_cells(text: str, separator: str, file: Path) -> pd.DataFrame:
    lines = text if text.endswith("\n") else f"{text}\n"
    try:
        # An open quotation mark takes the last line, too, which is then no row of its own.
        *rows, end = csv.reader(io.StringIO(f"{lines}{LAST_LINE}", newline=""), delimiter=separator)
    except csv.Error as damage:
        raise InvalidFile(
            f"{file}: found something that is no table ({damage}), expected comma-separated values"
        ) from None
    if end != [LAST_LINE]:
        raise InvalidFile(f"{file}: found a quotation mark that is never closed, expected it in pairs")
    n_columns = max(1, len(rows[0]))
    for row, cells in enumerate(rows, start=1):
        if len(cells) not in (0, n_columns):
            raise InvalidFile(f"{file}, row {row}: found {len(cells)} cells, expected {n_columns} as in the header")
    return pd.DataFrame([cells or [""] * n_columns for cells in rows], dtype=TEXT)


def _text(file: Path) -> str:
    content = read_file(file, "a table of trials")
    try:
        text = content.decode("utf-8-sig")  # spreadsheets write a mark before the first byte
    except UnicodeDecodeError as damage:
        row = content.count(b"\n", 0, damage.start) + 1
        raise InvalidFile(
            f"{file}, row {row}: found the byte 0x{content[damage.start]:02x}, expected UTF-8 text; save the table as "
            "UTF-8"
        ) from None
    if "\0" in text:
        row = text.count("\n", 0, text.index("\0")) + 1
        raise InvalidFile(f"{file}, row {row}: found a zero byte, expected text")
    if not text.strip():
        raise InvalidFile(f"{file}: found an empty file, expected a header and trials")
    return text


def _with_header(cells: pd.DataFrame, file: Path) -> pd.DataFrame:
    cells = _without_nameless(cells)
    names = [str(name).strip() for name in cells.iloc[0]]
    seen: set[str] = set()
    for place, name in zip(map(int, cells.columns), names, strict=True):
        if not name:
            raise InvalidFile(f"{file}, row 1: found no name for column {place + 1}, expected one for each")
        if name in seen:
            raise InvalidFile(f"{file}, row 1: found the column {name!r} twice, expected each once")
        seen.add(name)
    body = cells.iloc[1:].set_axis(names, axis=1)
    if len(names) > 1:  # in a table of one column an empty line is an empty cell
        begun = body[body[names[0]] == ""]  # so that no more cells are compared than must be
        body = body.drop(index=begun.index[(begun == "").all(axis=1)]) if len(begun) else body
    return body.assign(row=body.index + 1)


def _without_nameless(cells: pd.DataFrame) -> pd.DataFrame:
    """Without the columns in which no cell holds anything, not even the first."""
    nameless = [place for place in cells.columns if not str(cells[place].iloc[0]).strip()]
    return cells.drop(columns=[place for place in nameless if (cells[place].str.strip() == "").all()])
