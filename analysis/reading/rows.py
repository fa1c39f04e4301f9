"""Rows of a trials table, one per answer: parse numbers, select rows, and report errors."""

import json
import re
from collections.abc import Callable, Container, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from tactometry.errors import InvalidFile, count_of, nearest
from tactometry.files.json_file import json_value
from tactometry.trials.row_rules import COUNTS, FLAGS, NUMBERS, rows_text
from tactometry.trials.tasks import FORM_TASK

from ..arrays import Array

NOT_MEASURED = frozenset(("none", "null", "nan", "na", "n/a", "-", "--", "undefined", "#n/a", "timeout"))
"""Texts that other programs use for missing values."""
NAMED_VALUES = ("response", "target", "session", "correct", "catch", "valid", "practice")
"""Columns in which other programs may write words for numbers."""
NEGATIVE = frozenset(("n", "no", "nein", "false", "f", "wrong", "incorrect", "miss", "not felt"))
"""Words that probably mean 0."""
_NUMBER = re.compile(r"[+-]?\d+\.?\d*")


def numbers_of(text: "pd.Series[str]") -> "pd.Series[float]":
    """Convert text cells to numbers; other text becomes NaN."""
    numbers = plain_numbers(text)
    return pd.Series(_numbers_of_words(text) if numbers is None else numbers, index=text.index)


def plain_numbers(text: "pd.Series[str]") -> Array | None:
    """Convert text cells to numbers if all are numeric or empty, else None.

    >>> plain_numbers(pd.Series(["1.5", "", "-2e3"]))
    array([ 1.5e+00,      nan, -2.0e+03])
    >>> plain_numbers(pd.Series(["1.5", "loud"])) is None
    True
    """
    words = text.to_numpy(dtype=object)
    try:
        # numpy parses "1_000" as a number, but in a table it is text.
        return None if "_" in "".join(words) else np.where(words == "", "nan", words).astype(np.float64)
    except (TypeError, ValueError):
        return None


def _numbers_of_words(text: "pd.Series[str]") -> Array:
    """Convert each distinct text to a number once; other text becomes NaN."""
    codes, different = pd.factorize(text)
    numbers = np.asarray(pd.to_numeric(pd.Series(different), errors="coerce"), dtype=np.float64)
    return numbers[codes]


def holds(rows: pd.DataFrame, name: str, value: object) -> "pd.Series[bool]":
    """Return True for rows with this value in an optional column."""
    return rows[name] == value if name in rows.columns else pd.Series(False, index=rows.index)


def is_catch(rows: pd.DataFrame) -> "pd.Series[bool]":
    """Return True for catch trials."""
    return holds(rows, "catch", 1)


def delivered_level(rows: pd.DataFrame) -> "pd.Series[float]":
    """Return the delivered level if known, else the requested level."""
    if "level_delivered" not in rows.columns:
        return rows["level"]
    return rows["level_delivered"].fillna(rows["level"])


def correctness(rows: pd.DataFrame) -> "pd.Series[float]":
    """Return 1 for correct and 0 for incorrect answers, NaN if unknown."""
    stated = rows["correct"] if "correct" in rows.columns else pd.Series(np.nan, index=rows.index)
    if "target" not in rows.columns:
        return stated
    is_right = numbers_of(rows["response"]) == rows["target"]
    return stated.fillna(is_right.astype(float).where(rows["target"].notna()))


def place_of(rows: pd.DataFrame) -> str:
    """Return the file and row of the first row, and the rows of the others."""
    numbers = rows["row"].drop_duplicates().tolist()  # trials from one row of counts share its number
    return f"{rows['source'].iloc[0]}{rows_text(numbers[0], numbers[1:], len(numbers))}"


def first_place(rows: pd.DataFrame) -> str:
    """Return the place of the first row, for the end of a warning."""
    first = rows.iloc[0]
    return f"(the first: {Path(str(first['source'])).name}, row {first['row']})"


def bad_cell(row: "pd.Series[Any]", column: str, found: str, expected: str) -> InvalidFile:
    """Return an error about a cell that names its file and row."""
    return InvalidFile(f"{row['source']}, row {row['row']}, column {column!r}: found {found}, expected {expected}")


def meaning(name: str, text: str) -> str:
    """Return a hint on how to translate a word in a column map.

    >>> meaning("response", "y")
    "; translate it in a column map (--columns), below [values.response], for example: 'y' = 1"
    >>> meaning("response", "None"), meaning("response", "7")
    ("; mark it as missing in a column map (--columns): missing = ['None']", '')
    """
    if name == "participant" and text:
        return f"; assign codes in a column map (--columns), below [values.participant]: {_toml_text(text)} = 'P1'"
    word, plain = _toml_text(text), text.strip().lower()
    if plain in NOT_MEASURED:
        return f"; mark it as missing in a column map (--columns): missing = [{word}]"
    if name not in NAMED_VALUES or not text or _NUMBER.fullmatch(text):
        return ""
    number = 0 if plain in NEGATIVE and name != "target" else 1
    return f"; translate it in a column map (--columns), below [values.{name}], for example: {word} = {number}"


def _toml_text(text: str) -> str:
    r"""Quote a text for a TOML file.

    >>> print(_toml_text("y"), _toml_text("don't\n"))
    'y' "don't\n"
    """
    if text.isprintable() and "'" not in text:
        return f"'{text}'"
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")  # allowed in JSON but not in TOML


def expect_column(table: pd.DataFrame, name: str, file: object, why: str) -> None:
    """Raise for a table without a column; `why` continues the message."""
    if name not in table.columns:
        raise InvalidFile(f"{file}: found no column {name!r}{why}{nearest(name, map(str, table.columns))}")


def no_column(name: str, table: pd.DataFrame) -> str:
    """Return a message about a missing column that suggests the nearest one.

    >>> no_column("levl", pd.DataFrame({"level": [1.0]}))
    "found no column 'levl'; did you mean 'level'?"
    """
    return f"found no column {name!r}{nearest(name, [str(column) for column in table.columns])}"


def with_all_columns(tables: Mapping[Path, pd.DataFrame]) -> dict[Path, pd.DataFrame]:
    """Give each table all columns, as other programs omit empty columns."""
    header = list(dict.fromkeys(name for table in tables.values() for name in table.columns))
    missing = {file: [name for name in header if name not in table.columns] for file, table in tables.items()}
    return {file: with_empty(table, missing[file])[header] for file, table in tables.items()}


def with_empty(table: pd.DataFrame, names: list[str]) -> pd.DataFrame:
    """Add empty columns with these names."""
    return table.assign(**{name: np.nan if name in (*NUMBERS, *COUNTS, *FLAGS) else "" for name in names})


def with_rows(tables: Mapping[Path, pd.DataFrame]) -> Mapping[Path, pd.DataFrame]:
    """Return the tables with rows, or all tables if none has rows."""
    return {file: table for file, table in tables.items() if len(table)} or tables


def begun_notes(tables: Mapping[Path, pd.DataFrame], used: Container[Path]) -> list[str]:
    """Return notes on sessions without rows, for example without consent."""
    names = [file.name for file in tables if file not in used]
    return [f"{count_of(len(names), 'session')} without trials left out: {', '.join(names)}"] if names else []


def unanswered_notes(rows: pd.DataFrame) -> list[str]:
    """Return notes on trials without an answer."""
    silent = rows[(rows["response"] == "") & (rows["task"] != FORM_TASK)]
    if silent.empty:
        return []
    verb = "was" if len(silent) == 1 else "were"
    return [f"{count_of(len(silent), 'row')} without an answer {verb} left out {first_place(silent)}"]


def routine_notes(left: Mapping[Path, pd.DataFrame]) -> list[str]:
    """Return notes on rows that are not trials."""
    n = sum(map(len, left.values()))
    if not n:
        return []
    file, first = next((file, table["row"].iloc[0]) for file, table in left.items() if len(table))
    rows = "1 row was left out: it has" if n == 1 else f"{n} rows were left out: they have"
    return [
        f"{rows} no level, answer or item, like rows that other programs write for routines (the first: {file.name}, "
        f"row {first})"
    ]


POSITIVE, TOTAL = "n_positive", "n_trials"
"""Columns of a table of counts: number of "yes" or correct answers, and number of all answers."""
COUNTED = "counts"
"""Value of `procedure` in rows made from counts, whose order has no meaning."""
CHOICE = "forced_choice"
ALTERNATIVES = "n_alternatives"
MOST_COUNTED = 10_000_000
"""Largest number of trials in a table of counts (unverified default)."""


def counted_trials(table: pd.DataFrame, file: Path) -> pd.DataFrame:
    """Return a row for each trial of a table of counts.

    Positive answers are spread evenly over the trials of their row, as their order is not known.

    Raises `InvalidFile` if the column of totals is missing, or if a row lacks counts or has more positive answers than
    trials.
    """
    if POSITIVE not in table.columns:
        return table
    expect_column(table, TOTAL, file, f", the number of trials that {POSITIVE} refers to")
    positive, total = (numbers_of(table[name].str.strip()).to_numpy() for name in (POSITIVE, TOTAL))
    is_count = (positive >= 0) & (positive <= total) & (positive % 1 == 0) & (total % 1 == 0)
    if not is_count.all():
        wrong = table[~is_count]
        found = " of ".join(wrong[name].iloc[0] or "nothing" for name in (POSITIVE, TOTAL))
        first, *others = wrong["row"]
        raise InvalidFile(
            f"{file}{rows_text(first, others, len(wrong))}: found {found} ({POSITIVE} of {TOTAL}), expected whole "
            f"numbers, with {POSITIVE} not above {TOTAL}"
        )
    if total.sum() > MOST_COUNTED:
        raise InvalidFile(f"{file}: found {total.sum():g} trials in counts, expected at most {MOST_COUNTED}")
    times = total.astype(np.int64)
    place = np.arange(times.sum()) - np.repeat(np.cumsum(times) - times, times)
    k, n = np.repeat(positive, times), np.repeat(total, times)
    is_yes = np.floor((place + 1) * k / n) > np.floor(place * k / n)
    rows = table.loc[table.index.repeat(times)].drop(columns=[POSITIVE, TOTAL, "trial"], errors="ignore")
    answers = np.where(is_yes, "1", "0")
    name = "correct" if "task" in rows.columns and (rows["task"] == CHOICE).any() else "response"
    return rows.assign(**{name: answers}).assign(procedure=COUNTED).reset_index(drop=True)


def with_responses(table: pd.DataFrame, file: Path) -> pd.DataFrame:
    """Add responses to forced choices that are only scored as correct.

    The chosen interval is then unknown: 1 stands for a correct answer, 2 for an incorrect one.

    Raises `InvalidFile` if the number of alternatives is unknown.
    """
    is_choice = {"task", "correct"} <= set(table.columns) and (table["task"] == CHOICE).all()
    if "response" in table.columns or not is_choice:
        return table
    why = f"; if only 'correct' is known, set {ALTERNATIVES} = 2 in [constants] of the column map"
    expect_column(table, ALTERNATIVES, file, why)
    return table.assign(response=table["correct"].map({"1": "1", "0": "2"}).fillna(""))


def survey_answers(table: pd.DataFrame, file: Path, warn: Callable[[str], None]) -> pd.DataFrame:
    """Return one row for each item of a jsPsych survey."""
    if not {"task", "response"} <= set(table.columns):
        return table
    nested = table["response"].str.startswith("{")
    answers = {place: _object(text) for place, text in table.loc[nested, "response"].items()}
    answers = {place: items for place, items in answers.items() if items}
    if not answers:
        return table
    times = [len(answers.get(place, "1")) for place in table.index]
    rows = table.loc[table.index.repeat(times)]
    is_item = rows.index.isin(list(answers))
    items = [item for place in table.index if place in answers for item in answers[place].items()]
    columns = {"item": [key for key, _ in items], "response": [text for _, text in items], "task": FORM_TASK}
    for name, texts in columns.items():
        column = np.full(len(rows), "", dtype=object)
        if name in rows.columns:
            column[:] = rows[name]
        column[is_item] = texts
        rows = rows.assign(**{name: column})
    where = f"{file.name}, row {table['row'][table.index.isin(list(answers))].iloc[0]}"
    warn(f"{count_of(len(answers), 'row')} of survey answers read as the task {FORM_TASK} (the first: {where})")
    return rows.reset_index(drop=True)


def _object(text: str) -> dict[str, str]:
    """Read a JSON object of answers; other text returns an empty dict.

    >>> _object('{"Q0": 3, "Q1": "often"}'), _object("{left}")
    ({'Q0': '3', 'Q1': 'often'}, {})
    """
    try:
        value = json_value(text)
    except ValueError:
        return {}
    return {str(name): "" if held is None else str(held) for name, held in value.items()}
