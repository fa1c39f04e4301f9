"""The page of what was validated: a table of each check, what departs from what it ought to be, and why."""

import math
from collections.abc import Iterator, Mapping
from typing import Any, Final

import pandas as pd

from ..census.shares import departure, share_interval
from .check import Check
from .checks import check_of
from .kinds import ALPHA
from .run import Validated

PERCENT: Final = frozenset(("share", "none", "bounds"))
UNEXPLAINED: Final = "not explained"
HEAD: Final = """# Our methods, put to participants whose truth is known

<!-- not run: it takes half an hour; tests/experiments/test_validation.py runs each check -->
```console
$ tactometry validate-method --out validated --rounds {n_rounds} --seed {seed}
```

Every procedure with every fit, calibration by simulation, tests without an effect and with one, intervals of effects:
each table is what came out, good or bad. *too few* and *too many* stand where an exact binomial test of the share
against what is stated has p < 1e-4; below the table is said why, where it is known. Shares have exact 95 % intervals
(Clopper and Pearson 1934), which the CSV files of the folder hold. Everything is of simulated participants. This page
is made by the command; nobody writes in it.
"""


def page(found: Validated) -> str:
    """The text of the page; the same outcomes give the same text."""
    sections = [_section(check_of(name), table) for name, table in found.tables.items()]
    validation = found.validation
    head = HEAD.format(n_rounds=validation.n_rounds, seed=validation.seed)
    return "\n".join([head, *_cost(found), *(line for section in sections for line in section)]) + "\n"


def departures(table: pd.DataFrame) -> pd.DataFrame:
    """The rows whose share is not what is stated."""
    return table[table["verdict"] != ""]


def _cost(found: Validated) -> Iterator[str]:
    """What rounds buy: half of the 95 % interval of a share of 95 %."""
    yield "## What accuracy costs\n"
    yield "A round simulates each setting so many times; the processor time is that of this run. Half of the interval"
    yield "of a share of 95 % is told for each number of rounds, in per cent: four times the time halves it.\n"
    numbers = sorted({1, 4, 16, 64, found.validation.n_rounds})
    yield _row("check", "a round", "processor time of a round / s", *(f"{n} rounds" for n in numbers))
    yield _row(*["---"] * (3 + len(numbers)))
    for name, seconds in found.seconds.items():
        check = check_of(name)
        reaches = (f"{100 * reach_of_share(n * check.n_sets):.1f}" for n in numbers)
        yield _row(name, f"{check.n_sets}", f"{seconds / found.validation.n_rounds:.2g}", *reaches)
    yield ""


def reach_of_share(n: int, share: float = 0.95) -> float:
    """Half of the exact 95 % interval of a share.

    >>> round(reach_of_share(100), 3)
    0.048
    """
    low, high = share_interval(round(share * n), n)
    return (high - low) / 2


def _section(check: Check, table: pd.DataFrame) -> Iterator[str]:
    yield f"## {check.title}\n"
    yield f"{check.words}\n"
    if check.figure:
        yield f"![{check.title}](validated/{check.figure}.svg)\n"
    heads = check.kind.heads
    yield _row(*check.keys, *heads.values())
    yield _row(*["---"] * (len(check.keys) + len(heads)))
    for row in table.to_dict("records"):
        yield _row(*(_name(row[key]) for key in check.keys), *(shown(name, row) for name in heads))
    yield ""
    yield from _reasons(check, departures(table))
    yield from _pooled(check, table)


def _pooled(check: Check, table: pd.DataFrame) -> Iterator[str]:
    """Of methods whose rows depart in none, but whose sets do all together: small shares off show there alone."""
    for name, rows in table[table["stated"].notna()].groupby(check.reason_key, sort=False):
        n, n_yes = int(rows["n"].sum()), round(float((rows["share"] * rows["n"]).sum()))
        stated = rows["stated"].iloc[0]
        if (rows["verdict"] == "").all() and n and departure(n_yes, n, stated, ALPHA):
            reason = check.reasons.get(str(name), UNEXPLAINED)
            yield f"- *{name}*: {100 * n_yes / n:.1f} % over all rows together, {100 * stated:g} % stated: {reason}.\n"


def _reasons(check: Check, departing: pd.DataFrame) -> Iterator[str]:
    """Each reason once, with the rows that it is said of."""
    if departing.empty:
        yield "No share departs from what is stated.\n"
        return
    named = departing[check.reason_key].astype(str)
    for name in dict.fromkeys(named):
        rows = departing[named == name]
        word = ", ".join(dict.fromkeys(rows["verdict"]))
        yield f"- *{name}*, {word} in {len(rows)} of the rows: {check.reasons.get(name, UNEXPLAINED)}."
    yield ""


def shown(name: str, row: Mapping[Any, Any]) -> str:
    """A number as the page shows it; of a bias its standard error too.

    >>> shown("share", {"share": 0.9512}), shown("bias", {"bias": 0.123, "bias_se": 0.04})
    ('95.1', '0.12 ± 0.04')
    """
    value = row[name]
    if isinstance(value, str):
        return f"**{value}**" if value else ""
    if math.isnan(value):
        return ""
    if name in PERCENT:
        return f"{100 * value:.1f}"
    if name == "bias":
        return f"{_plain(value)} ± {row['bias_se']:.2f}"
    return f"{value}" if isinstance(value, int) else _plain(value) if name != "p" else f"{value:.2g}"


def _name(value: object) -> str:
    return value if isinstance(value, str) else f"{value:g}"


def _plain(value: float) -> str:
    """Two decimals, and no minus before a zero."""
    digits = f"{value:.2f}"
    return digits.removeprefix("-") if float(digits) == 0 else digits


def _row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"
