"""Reading and checking of trials tables.

Every error names the file, the row (the header is row 1) and the column.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from pandas.api.types import is_numeric_dtype

from tactometry.arguments.require import expect
from tactometry.errors import InvalidFile, count_of, nearest
from tactometry.records.data_set import keys_of
from tactometry.records.head import ADDED
from tactometry.trials.cells import PARTICIPANT
from tactometry.trials.columns import ALWAYS, FIRST, FOREIGN, MAY_BE_FACTORS, OPTIONAL, RESERVED, stated_factors
from tactometry.trials.row_rules import COUNTS, FLAGS, NUMBERS
from tactometry.trials.tasks import FORM_TASK, TASKS, tasks_with_level

from .column_map import ColumnMap, missing_notes, shared_name_notes, stated_codes, translate, trials_of
from .contradictions import contradictions
from .level_scale import on_scale, wide_levels
from .participants import alike_notes, alike_values, with_codes, without_separators
from .rows import (
    ALTERNATIVES,
    POSITIVE,
    TOTAL,
    bad_cell,
    begun_notes,
    expect_column,
    first_place,
    holds,
    is_catch,
    meaning,
    numbers_of,
    place_of,
    routine_notes,
    unanswered_notes,
    with_all_columns,
    with_empty,
    with_rows,
)
from .text_table import text_cells
from .trial_files import copy_notes, plain_text, trial_files, unread_notes

REQUIRED = ("participant", "level", "task", "response")
READ = tuple(column.name for column in (*FIRST, *ALWAYS, *OPTIONAL, *FOREIGN))
"""Columns that the analysis uses; each may occur only once in a table."""
CURVED = tasks_with_level("curve")
TRIAL_KEY = (
    *("participant", "study", "session", "block", "task", "procedure"),
    *("trial", "attempt", "item", "item_b", "track", "catch", "level"),
)
"""Columns that identify a row together with the factors, as other programs restart trial numbers in each condition."""


@dataclass(frozen=True)
class Trials:
    """A checked trials table.

    `rows` has one row per trial, with numbers as float (NaN: missing) and the columns `source` (file) and `row`.
    `factors` are the names of the columns of conditions. `n_files` files were read from `path`.
    """

    rows: pd.DataFrame
    factors: tuple[str, ...]
    path: Path
    n_files: int
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """Summarise the trials, participants and factors in one line."""
        of_whom = count_of(self.rows["participant"].nunique(), "participant")
        factors = f"; {', '.join(self.factors)}" if self.factors else ""
        return f"Trials({count_of(len(self.rows), 'row')} of {of_whom}{factors})"


def read_trials(
    path: str | Path,
    *,
    within: Sequence[str] | str | None = None,
    column_map: ColumnMap | None = None,
    level_scale: str | None = None,
) -> Trials:
    """Read the trials of a data set folder or of one file.

    The files are ``data/*_data.csv`` of a folder, or one CSV or tab-separated ``.tsv`` file. With a `column_map` a
    folder may also contain another program's tables, one per participant or session. Factors are the non-empty columns
    between ``trial`` and ``procedure``, or the columns in `within` (may be empty). Levels are converted to
    `level_scale` (`on_scale`), or else to the scale of the map.

    Raises `InvalidFile` if there is nothing to read, or a table is damaged. The error names the file, row and column.
    Raises `InvalidParameter` if `within` names a missing column, or the levels cannot be converted to the scale.
    """
    path, given, notes = Path(path), column_map or ColumnMap(), list[str]()
    named = [within] if within and isinstance(within, str) else within
    within = None if named is None else [plain_text(name) for name in named]
    files = trial_files(path, foreign=column_map is not None)
    needed = None if within is None else {*within, *READ, *given.columns.values(), *given.keep}
    cells = {file: text_cells(file, given.separator, needed=needed, notes=notes) for file in files}
    read = _translated(cells, given, notes)
    raw = with_rows(read) if column_map is None else read
    for file in (file for file, table in raw.items() if table.empty):
        raise InvalidFile(f"{file}: found no row below the header, expected at least one trial")
    texts = raw if column_map is None else {file: trials_of(table, file) for file, table in raw.items()}
    texts = with_codes(texts, path, notes)
    scale = level_scale or given.level_scale
    trials = trials_in(texts, path, within=within, level_scale=scale, named_by_us=column_map is None)
    left_out = {file: table.drop(texts[file].index) for file, table in raw.items()}
    notes = [*unread_notes(path, files), *notes, *routine_notes(left_out), *begun_notes(read, raw)]
    notes += unanswered_notes(trials.rows) if column_map is not None else []
    notes += [*shared_name_notes(files, given), *(copy_notes(files) if column_map is not None else ())]
    notes += [*_lost_notes(cells, given, trials.rows, path), *_between_notes(trials.rows, within or ())]
    return replace(trials, notes=(*notes, *trials.notes, *contradictions(trials.rows)))


def _translated(
    cells: Mapping[Path, pd.DataFrame], column_map: ColumnMap, notes: list[str]
) -> dict[Path, pd.DataFrame]:
    """Return tables with Tactometry's columns, still as text."""
    elsewhere, tables = {str(name) for table in cells.values() for name in table.columns}, {}
    for file, own in cells.items():
        table = translate(own, column_map, file, elsewhere, notes.append)
        if "level" not in table.columns and holds(table, "task", FORM_TASK).all():
            table = table.assign(level="")  # questionnaire answers have no level
        for name in REQUIRED:
            of_counts = f", and {POSITIVE} and {TOTAL} if the table contains counts" * (name == "response")
            expect_column(table, name, file, f"; assign it in a column map (--columns){of_counts}")
        tables[file] = table
    notes += missing_notes(cells, column_map)
    return tables


def _lost_notes(
    cells: Mapping[Path, pd.DataFrame], column_map: ColumnMap, rows: pd.DataFrame, path: Path
) -> Iterator[str]:
    """Warn about participants without trials, and codes that may be equal."""
    stated = set().union(*(stated_codes(table, column_map) for table in cells.values()))
    short = without_separators(stated, path)
    lost = {short.get(code, code) for code in stated} - set(rows["participant"].unique())
    if lost:
        yield (
            f"no trial was read of {', '.join(sorted(lost))}: the column map keeps none of their rows, or they have no "
            "level, answer or item"
        )
    yield from alike_notes(rows["participant"].unique())


def _between_notes(rows: pd.DataFrame, within: Sequence[str]) -> Iterator[str]:
    """Warn about factors in `--within` that vary only between participants."""
    for name in within:
        if rows[name].nunique() > 1 and rows.groupby("participant")[name].nunique().max() == 1:
            yield (
                f"--within {name}: each participant has only one level of this factor; check the "
                "participant codes if it was varied within participants"
            )


def trials_in(
    texts: Mapping[Path, pd.DataFrame],
    path: Path,
    *,
    within: Sequence[str] | None = None,
    level_scale: str | None = None,
    named_by_us: bool = True,
) -> Trials:
    """Build the trials of `path` from tables of text cells by file.

    With `named_by_us`, the file names contain the participant. Columns of numbers, counts and flags may already be
    floats, which are not checked.

    Raises `InvalidFile` or `InvalidParameter` as `read_trials`.
    """
    same_columns = _with_same_columns if named_by_us else with_all_columns
    tables = same_columns({file: _checked_table(table, file) for file, table in texts.items()})
    for file, table in tables.items() if named_by_us else ():  # other programs name files differently
        code = keys_of(file.stem).get("participant")
        if code is not None:
            expected = f"{code!r} as in the file name; remove the file if it is a copy"
            _expect(table, "participant", table["participant"] == code, expected)
        if "rig" in table.columns:
            expect_column(table, "valid", file, "; every table of a session has it")
    rows = pd.concat(tables.values(), ignore_index=True)
    named = _factors(list(rows.columns), within, path)
    for name in named:
        rows[name] = _factor_values(rows, name)
    factors = named if within is not None else tuple(name for name in named if _is_filled(rows[name]))
    notes = (*repetitions(rows, named), *alike_values(rows, factors), *([] if level_scale else wide_levels(rows)))
    return Trials(on_scale(rows, level_scale) if level_scale else rows, factors, path, len(tables), notes)


def repetitions(rows: pd.DataFrame, factors: Sequence[str] = ()) -> list[str]:
    """Warn about rows that repeat an earlier trial, if trials are numbered.

    >>> row = {"participant": "P1", "trial": 1.0, "response": "1", "source": "a.csv", "row": 2}
    >>> repetitions(pd.DataFrame([row, row | {"trial": 2.0, "row": 3}, row | {"response": "0", "row": 4}]))[0][:58]
    '1 row repeats an earlier trial (the first: a.csv, row 4; 0'
    """
    if "trial" not in rows.columns:
        return []
    numbered = rows[rows["trial"].notna()]
    keys = [name for name in (*TRIAL_KEY, *factors) if name in rows.columns]
    again = numbered[numbered.duplicated(keys)]
    if again.empty:
        return []
    alike = int(numbered.duplicated([name for name in rows.columns if name not in OWN]).sum())
    place = first_place(again).removesuffix(")")
    repeat = "repeats an earlier trial" if len(again) == 1 else "repeat earlier trials"
    return [
        f"{count_of(len(again), 'row')} {repeat} {place}; {alike} of {len(again)} identical in every cell): "
        "each counts as a separate trial. Remove copies, or number trials consecutively in each session"
    ]


def _with_same_columns(tables: Mapping[Path, pd.DataFrame]) -> dict[Path, pd.DataFrame]:
    """Give all tables the same columns; those in `ADDED` may be missing.

    Raises `InvalidFile` if the other columns of a table differ from those of the first.
    """
    header = list(max(tables.values(), key=lambda table: len(ADDED.intersection(table.columns))).columns)
    whole = {}
    for file, table in tables.items():
        missing = [name for name in header if name in ADDED and name not in table.columns]
        is_older = missing and set(header) == {*table.columns, *missing}
        whole[file] = with_empty(table, missing)[header] if is_older else table
    first, *others = whole
    for file in others:
        if (columns := list(whole[file].columns)) != (expected := list(whole[first].columns)):
            odd = ", ".join(sorted(set(columns) ^ set(expected))) or "in another order"
            raise InvalidFile(
                f"{file}: found columns that differ from {first.name} ({odd}), expected the same; analyse different "
                "studies separately"
            )
    return whole


def _checked_table(raw: pd.DataFrame, file: Path) -> pd.DataFrame:
    table = raw.assign(source=str(file))
    _expect_texts(table, "participant", lambda code: PARTICIPANT.fullmatch(code) is not None, _CODE)
    _expect_texts(table, "task", lambda task: task in TASKS, f"one of {', '.join(TASKS)}")
    texts = {name for name in table.columns if not is_numeric_dtype(table[name])}
    for name in (name for name in (*NUMBERS, *COUNTS) if name in texts):
        table[name] = _numbers(table, name)
    for name in (name for name in FLAGS if name in texts):
        _expect_texts(table, name, lambda flag: flag in ("", "0", "1"), "1, 0 or nothing")
        # Floats, as flags may be missing.
        table[name] = table[name].map({"": np.nan, "0": 0.0, "1": 1.0}).astype(np.float64)
    _check_answers(table)
    return table


_CODE = "a code of 1 to 32 letters and digits, not a name or a path"


def _expect_texts(table: pd.DataFrame, name: str, holds: Callable[[str], bool], expected: str) -> None:
    wrong = [value for value in table[name].unique() if not holds(value)]
    if wrong:
        _expect(table, name, ~table[name].isin(wrong), expected)


def _expect(table: pd.DataFrame, name: str, fine: "pd.Series[bool]", expected: str) -> None:
    """Raise for the first row that is not `fine`."""
    if fine.all():
        return
    bad = table[~fine]
    cell = bad[name].iloc[0]
    text = "" if pd.isna(cell) else str(cell)
    # shorten long texts
    shown = "nothing" if not text else repr(text if len(text) <= 40 else text[:40] + "...")
    where = f"{place_of(bad)}, column {name!r}"
    raise InvalidFile(f"{where}: found {shown}, expected {expected}{meaning(name, text)}")


OWN = ("row", "source")
"""Columns added on reading: row number and file."""


def _numbers(table: pd.DataFrame, name: str) -> "pd.Series[float]":
    values = numbers_of(table[name])
    fine = pd.Series(np.isfinite(values), table.index)
    if not fine.all():  # check texts only if needed, as comparing them is slow
        fine |= table[name] == ""
        has_comma = table[name][~fine].head(1).str.fullmatch(r"-?\d+,\d+").any()
        _expect(table, name, fine, "a decimal point" if has_comma else "a finite number or nothing")
    if name in COUNTS:
        lowest = 2 if name == ALTERNATIVES else 0
        is_count = (values % 1 == 0) & (values >= lowest) | values.isna()
        _expect(table, name, is_count, f"a whole number from {lowest}")
    return values


def _check_answers(table: pd.DataFrame) -> None:
    for task in (task for task in sorted(table["task"].unique()) if TASKS[task].is_read):
        rule, of_task = TASKS[task].response, table["task"] == task
        expected = f"{rule.words} (task {task})"
        # Integers may be written as 1.0.
        texts = table.loc[of_task, "response"].unique()
        wrong = [text for text in texts if text and ("_" in text or not rule.holds(text.removesuffix(".0")))]
        _expect(table, "response", ~of_task | ~table["response"].isin(wrong), expected)
    lost = table["task"].isin(CURVED) & table["level"].isna() & ~is_catch(table)
    _expect(table, "level", ~lost, "a level, or 1 in the column 'catch'")


def _factors(header: Sequence[str], within: Sequence[str] | None, path: Path) -> tuple[str, ...]:
    theirs = [name for name in header if name not in OWN]
    for name in within or ():
        expect(name in theirs, "--within", repr(name), f"columns of {path}{nearest(name, theirs)}")
        is_kept = name in RESERVED - MAY_BE_FACTORS
        expect(not is_kept, "--within", f"{name!r}, a reserved name", f"factors of {path}")
    if within is not None:
        return tuple(dict.fromkeys(within))
    if "procedure" not in header or "trial" not in header:
        raise InvalidFile(
            f"{path}: found no column {'trial' if 'trial' not in header else 'procedure'!r}, expected the factors "
            "between 'trial' and 'procedure'; name the factors with --within A,B (--within '' if there are none)"
        )
    factors = stated_factors(header)
    for name in factors:
        if name in RESERVED:
            raise InvalidFile(
                f"{path}, row 1: found {name!r} between 'trial' and 'procedure', expected factors only: the analysis "
                "reserves this name. Rename the column, or name the factors with --within"
            )
    return tuple(factors)


def _is_filled(column: "pd.Series[Any]") -> bool:
    """Return True if any cell of the column has a value."""
    return column.empty or bool((column.notna() & (column.astype(str) != "")).any())


def _factor_values(rows: pd.DataFrame, name: str) -> "pd.Series[Any]":
    """Parse a factor as numbers, or as text if any cell is not numeric."""
    text = rows[name].astype(str)
    lost = (text == "") & rows["task"].isin(CURVED)
    if lost.any():
        raise bad_cell(rows[lost].iloc[0], name, "nothing", "the factor's value")
    numbers = numbers_of(text)
    if not np.isfinite(numbers[text != ""]).all():
        return text
    # Beyond 2^53 floats cannot represent every integer, so two levels could become equal.
    is_whole = bool((numbers == np.floor(numbers)).all() and (numbers.abs() < 2**53).all())
    return numbers.astype(np.int64) if is_whole else numbers


def used_rows(trials: Trials) -> pd.DataFrame:
    """Return the rows used in fits: valid, answered and not practice."""
    rows = asked_rows(trials)
    return rows[rows["response"] != ""]


def asked_rows(trials: Trials) -> pd.DataFrame:
    """Return the valid rows without practice, whether answered or not."""
    rows = trials.rows
    return rows[~holds(rows, "valid", 0) & ~holds(rows, "practice", 1)]
