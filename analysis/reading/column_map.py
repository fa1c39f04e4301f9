"""Translation of other programs' tables to Tactometry's."""

import re
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import pandas as pd

from tactometry.arguments.require import expect
from tactometry.config.quantity import si_unit, unit_suffix, units
from tactometry.config.strict import read_toml
from tactometry.errors import InvalidFile, count_of
from tactometry.trials.row_rules import NUMBERS

from .level_scale import PLACED, SETTINGS, LevelScale
from .rows import POSITIVE, TOTAL, counted_trials, expect_column, holds, survey_answers, with_responses
from .trial_files import plain_text, trimmed

NEEDED = ("participant", "level", "task", "response", POSITIVE, TOTAL)
"""Columns that every table must contain."""


@dataclass(frozen=True)
class ColumnMap:
    """Rules that translate another program's table, compared as text.

    Parameters
    ----------
    columns : mapping of str to str
        Maps our column names to theirs. ``n_positive`` and ``n_trials`` name the counts in a table with one row per
        level.
    constants : mapping of str to value
        Maps our name of a missing column to its value in every row, for example ``n_alternatives = 2``.
    values : mapping of str to mapping
        Maps our column name to a translation of its values (theirs to ours). Other values are unchanged.
    keep : mapping of str to list of str
        Maps their column name to the values that mark a row as a trial. Other rows are omitted.
    from_name : mapping of str to str
        Maps our column name to the key in the file name that precedes its value, for example ``sub`` in
        ``sub-01_ses-2_beh.tsv``. A pattern with a star for the value also works: ``P*``, ``_subject_*_``, or ``*`` for
        the whole name.
    units : mapping of str to str
        Maps our column name to the unit in the file: ``latency_s = "ms"`` divides by 1000. Levels, and standards and
        settings without a unit of their own, are converted to the SI unit, which becomes `level_unit`.
    level_scale : str
        Axis of the fits: ``linear``, ``log10`` or ``db``, applied to the levels after `units`.
    missing : list of str
        Texts that mark a value as missing.
    decimal : str
        Decimal sign, "." or ",".
    separator : str
        Column separator, one character such as ";". By default a comma, and in ``.tsv`` files a tab.

    Raises
    ------
    InvalidParameter
        If the decimal sign is invalid or equals the separator, the separator is not one character, a column has two
        sources, or a unit is unknown or does not match the column's name.
    """

    columns: dict[str, str] = field(default_factory=dict)
    constants: dict[str, str | float | bool] = field(default_factory=dict)
    values: dict[str, dict[str, str | float | bool]] = field(default_factory=dict)
    keep: dict[str, tuple[str, ...]] = field(default_factory=dict)
    from_name: dict[str, str] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    level_scale: LevelScale | None = None
    missing: tuple[str, ...] = ()
    decimal: str = "."
    separator: str = ""

    def __post_init__(self) -> None:
        expect(self.decimal in (".", ","), "decimal", repr(self.decimal), "'.' or ','")
        is_other = len(self.separator) <= 1 and (self.decimal == "." or self.separator not in ("", ","))
        expect(is_other, "separator", repr(self.separator), "one character that differs from the decimal sign")
        sources = ("columns", "constants", "from_name")
        for name in {**self.columns, **self.constants, **self.from_name}:
            of = [source for source in sources if name in getattr(self, source)]
            expect(len(of) == 1, name, f"definitions in {' and '.join(of)}", "a definition in one of them")
        for name, unit in self.units.items():
            symbol, _ = si_unit(unit, f"units.{name}")
            suffix = unit_suffix(name)
            of_name = symbol if suffix is None else units(suffix)[0]
            expect(
                of_name == symbol,
                f"units.{name}",
                f"{unit!r}, a unit of {symbol}",
                f"a unit of {of_name}, as in the column's name",
            )


def read_column_map(path: str | Path) -> ColumnMap:
    """Read a column map from TOML with the keys of `ColumnMap`.

    Raises `InvalidFile` if the file cannot be read, is not TOML, or contains other keys or values.
    """
    read = read_toml(ColumnMap, Path(path), "a column map")
    return replace(read, **{key.name: _plain(getattr(read, key.name)) for key in fields(read)})


def _plain(value: Any) -> Any:
    """Normalise the texts of a key as `text_cells` normalises tables."""
    if isinstance(value, Mapping):
        return {trimmed(plain_text(name)): _plain(held) for name, held in value.items()}
    if isinstance(value, tuple):
        return tuple(map(_plain, value))
    return trimmed(plain_text(value)) if isinstance(value, str) else value


def translate(
    raw: pd.DataFrame,
    column_map: ColumnMap,
    file: Path,
    elsewhere: Container[str] = (),
    warn: Callable[[str], None] = lambda note: None,
) -> pd.DataFrame:
    """Translate a table of text to Tactometry's columns and values.

    Optional columns in `elsewhere` (those of the other tables) may be missing here and are then empty.

    Raises `InvalidFile` if the map names a missing column or one column twice, or no row is a trial.
    """
    if column_map == ColumnMap():
        return raw
    for note in _unkept_notes(raw, column_map, file):
        warn(note)
    # Before renaming, as `keep` and `missing` refer to the text in the file.
    whole = raw.assign(**dict.fromkeys(_optional(raw, column_map, elsewhere), ""))
    table = _with_our_names(_with_our_signs(_trial_rows(whole, column_map, file), column_map), column_map, file)
    if column_map.decimal == ",":
        _refuse_thousands(table, file)
    for name, text in {**column_map.constants, **_of_name(column_map, file)}.items():
        table[name] = _text(text)
    table = _with_our_values(survey_answers(table, file, warn), column_map, file)
    return with_responses(counted_trials(_in_si(table, column_map, file), file), file)


def _optional(raw: pd.DataFrame, column_map: ColumnMap, elsewhere: Container[str]) -> list[str]:
    """Return optional columns (their names) that only other tables have."""
    named = {theirs for ours, theirs in column_map.columns.items() if ours not in NEEDED}
    return sorted(theirs for theirs in named if theirs in elsewhere and theirs not in raw.columns)


def missing_notes(tables: Mapping[Path, pd.DataFrame], column_map: ColumnMap) -> Iterator[str]:
    """Warn about mapped columns that some tables lack."""
    for ours, theirs in column_map.columns.items():
        lacking = [file.name for file, table in tables.items() if theirs not in table.columns]
        if lacking:
            yield f"found no column {theirs!r} in {', '.join(lacking)}, so {ours} is empty there"


def _unkept_notes(raw: pd.DataFrame, column_map: ColumnMap, file: Path) -> Iterator[str]:
    """Warn about omitted rows that differ from kept ones only in form."""
    for theirs, values in column_map.keep.items():
        kept = {_folded(value) for value in values}
        held = raw[theirs] if theirs in raw.columns else pd.Series(dtype=str)
        like = held[~held.isin(values) & held.map(_folded).isin(kept)]
        if len(like):
            result = " and ".join(map(repr, sorted(like.unique())))
            yield f"{file.name}: {count_of(len(like), 'row')} with {theirs} = {result} not kept; expected {values[0]!r}"


def _folded(value: str) -> str:
    return value.casefold().removesuffix(".0")


def stated_codes(raw: pd.DataFrame, column_map: ColumnMap) -> set[str]:
    """Return all participant codes in a table, even of omitted rows."""
    name = column_map.columns.get("participant", "participant")
    if name not in raw.columns or "participant" in (*column_map.constants, *column_map.from_name):
        return set()
    meanings = column_map.values.get("participant", {})
    codes = set(raw[name].unique()) - {"", *column_map.missing}
    return {_text(meanings.get(code, code)) for code in codes}


def trials_of(table: pd.DataFrame, file: Path) -> pd.DataFrame:
    """Return the rows with a level, an answer, an item or a catch trial.

    Other programs also write rows without any of these, for routines.

    Raises `InvalidFile` if there is no such row.
    """
    is_trial = holds(table, "catch", "1")
    for name in ("level", "response", "item", "level_measured"):
        if name in table.columns:
            is_trial |= table[name] != ""
    if not is_trial.any():
        raise InvalidFile(f"{file}: found no row with a level, an answer or an item, expected at least one trial")
    return table[is_trial]


def _text(value: str | float | bool) -> str:
    """Format a value as a cell.

    >>> _text(True), _text(1.0), _text(1234567.125), _text("a")
    ('1', '1', '1234567.125', 'a')
    """
    return value if isinstance(value, str) else repr(float(value)).removesuffix(".0")


def _trial_rows(raw: pd.DataFrame, column_map: ColumnMap, file: Path) -> pd.DataFrame:
    for theirs, values in column_map.keep.items():
        expect_column(raw, theirs, file, ", which the column map names in keep")
        raw = raw[raw[theirs].isin(values)]
        if raw.empty:
            raise InvalidFile(f"{file}: found no row with {theirs} = {' or '.join(values)}, expected trials (keep)")
    return raw


def _with_our_signs(raw: pd.DataFrame, column_map: ColumnMap) -> pd.DataFrame:
    """Replace missing values by "", and decimal commas by points."""
    table = raw.copy()
    for name in (name for name in raw.columns if name != "row"):
        if column_map.missing:
            table[name] = table[name].where(~table[name].isin(column_map.missing), "")
        if column_map.decimal == ",":
            # Only in numeric cells, as texts keep their commas.
            table[name] = table[name].str.replace(r"^([+-]?\d*),(\d+(?:[eE][+-]?\d+)?)$", r"\1.\2", regex=True)
    return table


def _refuse_thousands(table: pd.DataFrame, file: Path) -> None:
    """Raise for numbers such as 6.125, if they may mean 6125."""
    for name in (name for name in NUMBERS if name in table.columns):
        pointed = table[table[name].str.fullmatch(r"[+-]?\d*\.\d+")]
        if len(pointed) and pointed[name].str.fullmatch(r"[+-]?[1-9]\d{0,2}\.\d{3}").all():
            first = pointed.iloc[0]
            raise InvalidFile(
                f"{file}, row {first['row']}, column {name!r}: found {first[name]!r}, expected a decimal comma, as the "
                'column map states. Remove points that group thousands, or set decimal = "."'
            )


def _with_our_names(raw: pd.DataFrame, column_map: ColumnMap, file: Path) -> pd.DataFrame:
    for ours, theirs in column_map.columns.items():
        expect_column(raw, theirs, file, f", which the column map assigns to {ours!r}")
        if ours != theirs and ours in raw.columns:
            raise InvalidFile(f"{file}: found a column {ours!r}, but the column map assigns {theirs!r} to this name")
    table = raw.rename(columns={theirs: ours for ours, theirs in column_map.columns.items()})
    # One of their columns may be the source of several of ours; `rename` cannot duplicate columns.
    return table.assign(**{ours: raw[theirs] for ours, theirs in column_map.columns.items() if ours not in table})


def _of_name(column_map: ColumnMap, file: Path) -> Mapping[str, str]:
    values = {}
    for ours, key in column_map.from_name.items():
        value = re.search(_name_pattern(key), plain_text(file.stem))
        if value is None:
            raise InvalidFile(
                f"{file}: found no {key if '*' in key else f'{key}-...'} in the file name, expected the value "
                f"of {ours!r} "
                'there (from_name). A star stands for the value: "P*" in P01.csv, "_subject_*_" in x_subject_1_y.csv'
            )
        values[ours] = value[1]
    return values


def shared_name_notes(files: Iterable[Path], column_map: ColumnMap) -> Iterator[str]:
    """Warn about files whose names contain the same participant code."""
    if "*" not in column_map.from_name.get("participant", ""):
        return
    by_code: dict[str, list[str]] = {}
    for file in files:
        by_code.setdefault(_of_name(column_map, file)["participant"], []).append(file.name)
    for code, names in by_code.items():
        if len(names) > 1:
            yield f"files read as one participant, {code} (from_name): {', '.join(names)}"


def _name_pattern(key: str) -> str:
    """Return a regular expression for a BIDS key or a pattern with a star.

    >>> re.search(_name_pattern("_subject_*_"), "_subject_1_trials_2026")[1], re.search(_name_pattern("P*"), "P01")[1]
    ('1', '01')
    """
    if "*" not in key:
        # Anchored at the start or an underscore, so that the key "run" does not match "prerun-1".
        return rf"(?:^|_){re.escape(key)}-([A-Za-z0-9]+)"
    before, _, after = map(re.escape, key.partition("*"))
    return f"{before or '^'}(.+?){after or '$'}"


def _with_our_values(table: pd.DataFrame, column_map: ColumnMap, file: Path) -> pd.DataFrame:
    for ours, meanings in column_map.values.items():
        expect_column(table, ours, file, ", whose values the column map translates")
        table[ours] = table[ours].replace({theirs: _text(value) for theirs, value in meanings.items()})
    return table


def _in_si(table: pd.DataFrame, column_map: ColumnMap, file: Path) -> pd.DataFrame:
    """Convert numbers to SI units; other cells are reported later."""
    for name, unit in {**_units_of_levels(table, column_map), **column_map.units}.items():
        expect_column(table, name, file, ", which is in [units] of the column map")
        symbol, factor = si_unit(unit, f"units.{name}")
        numbers = pd.to_numeric(table[name].str.strip(), errors="coerce")
        # division keeps 812 ms exactly 0.812 s
        in_si = numbers * factor if factor >= 1 else numbers / round(1 / factor)
        scaled = [repr(float(number)) for number in in_si]
        table[name] = table[name].where(numbers.isna(), scaled)
        if name == "level":
            table["level_unit"] = _level_unit(table, symbol, file)
    return table


def _units_of_levels(table: pd.DataFrame, column_map: ColumnMap) -> Mapping[str, str]:
    """Return the unit of each column that contains levels."""
    if "level" not in column_map.units:
        return {}
    are_settings = "task" in table.columns and set(table["task"]) <= set(SETTINGS)
    names = [name for name in (*PLACED, *(["response"] if are_settings else [])) if name in table.columns]
    return dict.fromkeys(names, column_map.units["level"])


def _level_unit(table: pd.DataFrame, symbol: str, file: Path) -> str:
    stated = sorted(set(table["level_unit"]) - {"", symbol}) if "level_unit" in table.columns else []
    if stated:
        raise InvalidFile(
            f"{file}: found the level_unit {stated[0]!r}, expected {symbol!r}, the unit after conversion by units.level"
        )
    return symbol
