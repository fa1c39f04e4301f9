"""Rows of a table of trials: the numbers of their cells, what they say of a trial, and how a bad one is refused."""

import json
import re
from collections.abc import Container, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from tactometry.errors import InvalidFile, count_of, nearest
from tactometry.trials.row_rules import COUNTS, FLAGS, NUMBERS, rows_text
from tactometry.trials.tasks import FORM_TASK

from ..arrays import Array

NOT_MEASURED = frozenset(("none", "null", "nan", "na", "n/a", "-", "--", "undefined", "#n/a", "timeout"))
"""What other programs write where nothing was measured."""
NAMED_VALUES = ("response", "target", "session", "correct", "catch", "valid", "practice")
"""Columns whose values other programs write in words."""
NEGATIVE = frozenset(("n", "no", "nein", "false", "f", "wrong", "incorrect", "miss", "not felt"))
"""Words that most likely mean 0."""
_NUMBER = re.compile(r"[+-]?\d+\.?\d*")


def numbers_of(text: "pd.Series[str]") -> "pd.Series[float]":
    """Numbers of text cells, NaN for what is none."""
    numbers = plain_numbers(text)
    return pd.Series(_numbers_of_words(text) if numbers is None else numbers, index=text.index)


def plain_numbers(text: "pd.Series[str]") -> Array | None:
    """Numbers of text cells, NaN for empty ones, if all are numbers.

    >>> plain_numbers(pd.Series(["1.5", "", "-2e3"]))
    array([ 1.5e+00,      nan, -2.0e+03])
    >>> plain_numbers(pd.Series(["1.5", "loud"])) is None
    True
    """
    words = text.to_numpy(dtype=object)
    try:
        # numpy reads "1_000" as a number, as Python does; a table means a word by it.
        return None if "_" in "".join(words) else np.where(words == "", "nan", words).astype(np.float64)
    except (TypeError, ValueError):
        return None


def _numbers_of_words(text: "pd.Series[str]") -> Array:
    """Each different text is read once, and what is none is NaN."""
    codes, different = pd.factorize(text)
    numbers = np.asarray(pd.to_numeric(pd.Series(different), errors="coerce"), dtype=np.float64)
    return numbers[codes]


def holds(rows: pd.DataFrame, name: str, value: object) -> "pd.Series[bool]":
    """Which rows hold a value in a column that a table may lack."""
    return rows[name] == value if name in rows.columns else pd.Series(False, index=rows.index)


def is_catch(rows: pd.DataFrame) -> "pd.Series[bool]":
    """Which trials were catch trials."""
    return holds(rows, "catch", 1)


def delivered_level(rows: pd.DataFrame) -> "pd.Series[float]":
    """The level that was delivered where that is known, else the one that was asked for."""
    if "level_delivered" not in rows.columns:
        return rows["level"]
    return rows["level_delivered"].fillna(rows["level"])


def correctness(rows: pd.DataFrame) -> "pd.Series[float]":
    """1 where the answer was right, 0 where it was wrong; NaN where the row says neither that nor what was right."""
    stated = rows["correct"] if "correct" in rows.columns else pd.Series(np.nan, index=rows.index)
    if "target" not in rows.columns:
        return stated
    is_right = numbers_of(rows["response"]) == rows["target"]
    return stated.fillna(is_right.astype(float).where(rows["target"].notna()))


def place_of(rows: pd.DataFrame) -> str:
    """Where rows of a table of trials stand: the first of them, and how many more there are."""
    numbers = rows["row"].drop_duplicates().tolist()  # a row of counts holds several trials
    return f"{rows['source'].iloc[0]}{rows_text(numbers[0], numbers[1:], len(numbers))}"


def first_place(rows: pd.DataFrame) -> str:
    """Return where the first of the rows is, as the end of a warning."""
    first = rows.iloc[0]
    return f"(the first: {Path(str(first['source'])).name}, row {first['row']})"


def bad_cell(row: "pd.Series[Any]", column: str, found: str, expected: str) -> InvalidFile:
    """Of a row of a table of trials, which says where it stands in which file."""
    return InvalidFile(f"{row['source']}, row {row['row']}, column {column!r}: found {found}, expected {expected}")


def meaning(name: str, text: str) -> str:
    """Return how a column map states what a word means.

    >>> meaning("response", "y")
    "; say what it means in a column map (--columns), below [values.response], for example: 'y' = 1"
    >>> meaning("response", "None"), meaning("response", "7")
    ("; say in a column map (--columns) that it was not measured: missing = ['None']", '')
    """
    if name == "participant" and text:
        return f"; give each a code in a column map (--columns), below [values.participant]: {_toml_text(text)} = 'P1'"
    word, plain = _toml_text(text), text.strip().lower()
    if plain in NOT_MEASURED:
        return f"; say in a column map (--columns) that it was not measured: missing = [{word}]"
    if name not in NAMED_VALUES or not text or _NUMBER.fullmatch(text):
        return ""
    number = 0 if plain in NEGATIVE and name != "target" else 1
    return f"; say what it means in a column map (--columns), below [values.{name}], for example: {word} = {number}"


def _toml_text(text: str) -> str:
    r"""
    >>> print(_toml_text("y"), _toml_text("don't\n"))
    'y' "don't\n"
    """
    if text.isprintable() and "'" not in text:
        return f"'{text}'"
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")  # JSON may hold it as it is, TOML may not


def expect_column(table: pd.DataFrame, name: str, file: object, why: str) -> None:
    """Refuse a table of this file without a column; `why` ends the sentence."""
    if name not in table.columns:
        raise InvalidFile(f"{file}: found no column {name!r}{why}{nearest(name, map(str, table.columns))}")


def no_column(name: str, table: pd.DataFrame) -> str:
    """
    >>> no_column("levl", pd.DataFrame({"level": [1.0]}))
    "found no column 'levl'; did you mean 'level'?"
    """
    return f"found no column {name!r}{nearest(name, [str(column) for column in table.columns])}"


def with_all_columns(tables: Mapping[Path, pd.DataFrame]) -> dict[Path, pd.DataFrame]:
    """With the columns of all of them: other programs write a column into a file only where it holds something."""
    header = list(dict.fromkeys(name for table in tables.values() for name in table.columns))
    missing = {file: [name for name in header if name not in table.columns] for file, table in tables.items()}
    return {file: with_empty(table, missing[file])[header] for file, table in tables.items()}


def with_empty(table: pd.DataFrame, names: list[str]) -> pd.DataFrame:
    """With columns that hold nothing."""
    return table.assign(**{name: np.nan if name in (*NUMBERS, *COUNTS, *FLAGS) else "" for name in names})


def with_rows(tables: Mapping[Path, pd.DataFrame]) -> Mapping[Path, pd.DataFrame]:
    """Those of the tables that have rows; all of them where none has."""
    return {file: table for file, table in tables.items() if len(table)} or tables


def begun_notes(tables: Mapping[Path, pd.DataFrame], used: Container[Path]) -> list[str]:
    """What is said of sessions that are not `used`, as they have no row: so one ends in which nobody agrees to take
    part.
    """
    names = [file.name for file in tables if file not in used]
    return [f"{count_of(len(names), 'session')} without a trial, left out: {', '.join(names)}"] if names else []


def unanswered_notes(rows: pd.DataFrame) -> list[str]:
    """What is said of trials without an answer."""
    silent = rows[(rows["response"] == "") & (rows["task"] != FORM_TASK)]
    if silent.empty:
        return []
    verb = "was" if len(silent) == 1 else "were"
    return [f"{count_of(len(silent), 'row')} without an answer {verb} left out {first_place(silent)}"]


def routine_notes(left: Mapping[Path, pd.DataFrame]) -> list[str]:
    """What is said of rows that hold no trial."""
    n = sum(map(len, left.values()))
    if not n:
        return []
    file, first = next((file, table["row"].iloc[0]) for file, table in left.items() if len(table))
    rows = "1 row was left out that holds" if n == 1 else f"{n} rows were left out that hold"
    return [
        f"{rows} neither level nor answer nor item, as other programs write for routines (the first: {file.name}, row "
        f"{first})"
    ]
