"""Checks of the rows of a trials file."""

import csv
import io
import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from ..errors import nearest
from .cells import PARTICIPANT, STUDY, CellRule, is_time, number_from, one_of_texts, whole_number
from .columns import ALWAYS, FIRST, RIGS
from .tasks import TASKS
from .trial import REASONS

MOST_COLUMNS = 5000
"""Largest number of columns. A table with more may be transposed."""
MOST_NAMED = 5
"""Largest number of rows named for one defect."""
REQUIRED = tuple(column.name for column in (*FIRST, *ALWAYS))


@dataclass(frozen=True)
class Defect:
    """Defect of a file. `row` is the line of the file, from 1 (the header).

    Defects of one `kind` in a file may be merged. `n_rows` counts them, and `others` lists further rows.
    """

    file: str
    row: int | None
    text: str
    kind: str = ""
    n_rows: int = 1
    others: tuple[int, ...] = ()

    def __str__(self) -> str:
        return f"{self.file}{rows_text(self.row, self.others, self.n_rows)}: {self.text}"


def rows_text(row: int | None, others: Sequence[int] = (), n_rows: int = 1) -> str:
    """Format the first row and the number of further rows.

    >>> rows_text(None), rows_text(3), rows_text(3, (4, 9), 3), rows_text(2, (3, 4, 5, 6), 737)
    ('', ', row 3', ', row 3 and 2 more (4, 9)', ', row 2 and 736 more (3, 4, 5, 6, ...)')
    """
    if row is None:
        return ""
    named = others[: MOST_NAMED - 1]
    more = f" and {n_rows - 1} more ({', '.join(map(str, named))}{', ...' if n_rows > len(named) + 1 else ''})"
    return f", row {row}{more if n_rows > 1 else ''}"


def merge_alike(defects: Iterable[Defect]) -> list[Defect]:
    """Merge defects of one kind in one file, at the position of the first."""
    kinds: dict[object, list[Defect]] = {}
    for n, defect in enumerate(defects):
        kinds.setdefault((defect.file, defect.kind) if defect.kind else n, []).append(defect)
    merged = []
    for first, *rest in kinds.values():
        others = tuple(defect.row for defect in rest[: MOST_NAMED - 1] if defect.row is not None)
        merged.append(replace(first, n_rows=1 + len(rest), others=others))
    return merged


_COUNT = CellRule("a whole number from 1", whole_number())
_ANY = CellRule("a number", number_from(-math.inf))
_POSITIVE = CellRule("a number, at least 0", number_from(0))
_PART = CellRule("a number from 0 to 1", number_from(0, 1))
_FLAG = CellRule("1, 0 or nothing", one_of_texts("0", "1"))
RULES: Mapping[str, CellRule] = {
    "participant": CellRule("1 to 32 letters and digits", lambda text: PARTICIPANT.fullmatch(text) is not None),
    "study": CellRule(
        "the name of a study: lower-case letters and digits joined by hyphens",
        lambda text: STUDY.fullmatch(text) is not None,
    ),
    **dict.fromkeys(("session", "block", "trial", "attempt", "target", "n_alternatives"), _COUNT),
    **dict.fromkeys(("level", "level_delivered", "level_measured", "standard_level"), _ANY),
    **dict.fromkeys(("onset_s", "latency_s", "force_mean_n", "force_sd_n"), _POSITIVE),
    **dict.fromkeys(("speed_target_m_per_s", "speed_mean_m_per_s", "separation_m", "error_m"), _POSITIVE),
    **dict.fromkeys(("force_in_band", "speed_in_band", "positions_late"), _PART),
    **dict.fromkeys(("correct", "catch", "practice", "valid"), _FLAG),
    "task": CellRule(f"one of {', '.join(TASKS)}", one_of_texts(*TASKS)),
    "timestamp_utc": CellRule("a time in ISO 8601", is_time),
    "rig": CellRule(f"one of {', '.join(RIGS)}", one_of_texts(*RIGS)),
    "invalid_reason": CellRule(f"one of {', '.join(REASONS)}, or nothing", one_of_texts(*REASONS)),
    "positions_digest": CellRule("16 hexadecimal digits", lambda text: re.fullmatch(r"[0-9a-f]{16}", text) is not None),
    "n_gaps": CellRule("a whole number from 0", lambda text: re.fullmatch(r"\d+", text) is not None),
}
NUMBERS = tuple(name for name, rule in RULES.items() if rule in (_ANY, _POSITIVE, _PART))
COUNTS = (*(name for name, rule in RULES.items() if rule is _COUNT), "n_gaps")
FLAGS = tuple(name for name, rule in RULES.items() if rule is _FLAG)
MAY_BE_EMPTY = frozenset(RULES) - {"participant", "session", "block", "trial", "task", "rig"}


def defects(content: bytes, file: str) -> Iterator[Defect]:
    """Yield every defect of a trials file, in order of its rows."""
    try:
        table = list(csv.reader(io.StringIO(content.decode("utf-8-sig"), newline=""), strict=True))
    except (UnicodeDecodeError, csv.Error) as error:
        yield Defect(file, None, f"found no CSV in UTF-8 ({error}), expected a trials file")
        return
    if not table:
        yield Defect(file, None, "found an empty file, expected a header and a row for each trial")
        return
    header, *rows = table
    if len(header) > MOST_COLUMNS:
        yield Defect(file, 1, f"found {len(header)} columns, expected at most {MOST_COLUMNS}, and a row for each trial")
        return
    yield from _header_defects(header, file)
    seen: dict[tuple[str, ...], int] = {}
    for number, cells in enumerate(rows, 2):
        if len(cells) != len(header):
            yield Defect(file, number, f"found {len(cells)} cells, expected {len(header)} as in the header", "cells")
            continue
        row = dict(zip(header, cells, strict=True))
        yield from _row_defects(row, file, number)
        key = tuple(row.get(name, "") for name in ("participant", "session", "trial", "attempt", "item"))
        first = seen.setdefault(key, number) if row.get("trial") else number
        if first != number:
            yield Defect(file, number, f"found the same trial as in row {first}, expected each trial once", "doubled")


def _header_defects(header: Sequence[str], file: str) -> Iterator[Defect]:
    missing = [name for name in REQUIRED if name not in header]
    if len(missing) == 1:
        yield Defect(file, 1, f"found no column {missing[0]!r}, expected this column{nearest(missing[0], header)}")
    elif missing:
        yield Defect(file, 1, f"found no columns {', '.join(map(repr, missing))}, expected these columns")
    for name, n in Counter(header).items():
        if n > 1:
            yield Defect(file, 1, f"found the column {name!r} {'twice' if n == 2 else f'{n} times'}, expected it once")


def _row_defects(row: Mapping[str, str], file: str, number: int) -> Iterator[Defect]:
    for name, text in row.items():
        task = TASKS.get(row.get("task", "")) if name == "response" else None
        rule = RULES.get(name) if task is None else task.response
        empty = text == "" and (name in MAY_BE_EMPTY or name == "response")
        if rule is not None and not empty and not rule.holds(text):
            yield Defect(
                file, number, f"column {name!r}: found {text!r}, expected {rule.words}", f"{name} {rule.words}"
            )
    for name, mark, kind in (("level", "catch", "catch"), ("invalid_reason", "valid", "reason")):
        if row.get(mark) == "1" and row.get(name):
            text = f"column {name!r}: found {row[name]!r} in a {mark} trial, expected nothing"
            yield Defect(file, number, text, kind)
