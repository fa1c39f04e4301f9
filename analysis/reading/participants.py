"""Normalisation and comparison of participant codes and factor values."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path

import pandas as pd

from tactometry.errors import InvalidFile
from tactometry.trials.cells import PARTICIPANT

from ..wording import first_named

_SEPARATORS = re.compile(r"[_-]+")
_ZEROS = re.compile(r"(?<![0-9])0+(?=[0-9])")


def without_separators(codes: Iterable[str], path: Path) -> dict[str, str]:
    """Map each code with hyphens or underscores to the code without them.

    A code with a space may be a person's name, so the column map must assign a code to it.

    Raises `InvalidFile` if two codes differ only by these characters.

    >>> without_separators(["sub-01", "S02", "Bob Smith", "P_01"], Path("t.csv"))
    {'sub-01': 'sub01', 'P_01': 'P01'}
    """
    codes = list(codes)
    short = {code: _SEPARATORS.sub("", code) for code in codes if not PARTICIPANT.fullmatch(code)}
    short = {code: text for code, text in short.items() if PARTICIPANT.fullmatch(text)}
    for code, text in short.items():
        same = [other for other in codes if other != code and short.get(other, other) == text]
        if same:
            raise InvalidFile(
                f"{path}: found the participants {same[0]!r} and {code!r}, expected codes that differ in more than "
                f"separators. In a column map, below [values.participant], set {code!r} = 'another code', or "
                f"{code!r} = {same[0]!r} if they are the same participant"
            )
    return short


def with_codes(tables: Mapping[Path, pd.DataFrame], path: Path, notes: list[str]) -> dict[Path, pd.DataFrame]:
    """Apply `without_separators` to the participants, with a note in `notes`."""
    codes = dict.fromkeys(code for table in tables.values() for code in table["participant"].unique())
    short = without_separators(codes, path)
    if not short:
        return dict(tables)
    written = first_named([f"{code} as {text}" for code, text in short.items()])
    notes.append(
        f"separators were removed from participant codes: {written}; set others in [values.participant] of the map"
    )
    return {file: table.assign(participant=table["participant"].replace(short)) for file, table in tables.items()}


def _alike(words: Iterable[str], plain: Callable[[str], str]) -> list[str]:
    """Return the groups of words that have the same `plain` form."""
    groups: dict[str, list[str]] = {}
    for word in words:
        groups.setdefault(plain(word), []).append(word)
    return [" and ".join(sorted(group)) for group in groups.values() if len(group) > 1]


def alike_values(rows: pd.DataFrame, factors: Iterable[str]) -> Iterator[str]:
    """Warn about values of a factor that differ only in case or spaces."""
    for name in factors:
        alike = _alike(map(repr, map(str, rows[name].unique())), lambda value: "".join(value.casefold().split()))
        if alike:
            yield (
                f"{name} has values that differ only in case or spaces: {first_named(alike)}. Each was analysed as a "
                f"condition. If they are the same, merge them in [values.{name}] of a column map"
            )


def alike_notes(codes: Iterable[str]) -> Iterator[str]:
    """Warn about codes that differ only in case, separators or leading zeros.

    >>> list(alike_notes(["01", "1", "S2"]))[0][:75]
    'participants that may be the same, as their codes differ only in case, sepa'
    """
    alike = _alike(codes, lambda code: _ZEROS.sub("", _SEPARATORS.sub("", code).casefold()))
    if alike:
        yield (
            "participants that may be the same, as their codes differ only in case, separators or leading zeros: "
            f"{first_named(alike)}; each was analysed separately. If they are the same, use one code, or merge them in "
            "[values.participant] of a column map"
        )
