"""What a benchmark measured, in one form: printed as a line, and kept for the table of all benchmarks (`table.py`)."""

import json
import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median

ROWS = "TACTOMETRY_BENCH_ROWS"
"""The variable that names the file to which results are added, a line of JSON each; else they are printed alone."""


@dataclass(frozen=True)
class Measured:
    """One figure with its repeats. A ratio has the unit `x`, and `what` says of what to what."""

    what: str
    values: tuple[float, ...]
    unit: str = "x"
    at_least: float | None = None
    at_most: float | None = None

    @property
    def median(self) -> float:
        return median(self.values)

    @property
    def asked(self) -> str:
        """The limit in words; empty where nothing was asked for."""
        limits = {"at least": self.at_least, "at most": self.at_most}
        return ", ".join(self.told(limit, f"{word} ") for word, limit in limits.items() if limit is not None)

    def told(self, value: float, before: str = "") -> str:
        """A value with its unit."""
        return f"{before}{number(value)} {self.unit}".rstrip()

    @property
    def holds(self) -> bool | None:
        """Whether the median is within what was asked for; None where nothing was. A NaN holds nothing."""
        if self.at_least is None and self.at_most is None:
            return None
        above = self.at_least is None or self.median >= self.at_least
        return above and (self.at_most is None or self.median <= self.at_most)

    @property
    def spread(self) -> str:
        """Least and largest of several repeats; empty where they are the same."""
        least, largest = number(min(self.values)), number(max(self.values))
        return f"{least} to {largest}" if least != largest else ""

    @property
    def verdict(self) -> str:
        return {None: "", True: "reached", False: "MISSED"}[self.holds]

    def __str__(self) -> str:
        told = ", ".join(filter(None, (self.spread, self.asked, self.verdict)))
        return f"= {self.what}: {self.told(self.median)}{f' ({told})' if told else ''}"


def number(value: float) -> str:
    """Three digits.

    >>> number(1234.5), number(0.12345), number(3e-10)
    ('1230', '0.123', '3e-10')
    """
    short = f"{value:.3g}"
    return f"{float(short):.0f}" if 1000 <= abs(value) < 1e9 else short


def tell(
    what: str,
    values: float | Sequence[float],
    unit: str = "x",
    *,
    at_least: float | None = None,
    at_most: float | None = None,
) -> None:
    """Print a result, and keep it where the table asks for it; `values` are its repeats."""
    repeats = tuple(float(f"{value:.4g}") for value in (values if isinstance(values, Sequence) else (values,)))
    found = Measured(what, repeats, unit, at_least, at_most)
    print(found, flush=True)
    if kept := os.environ.get(ROWS):
        with Path(kept).open("a", encoding="utf-8") as file:
            file.write(json.dumps(asdict(found)) + "\n")


def ratios(ones: Sequence[float], others: Sequence[float]) -> list[float]:
    """Of pairs that were measured in turn.

    >>> ratios([2.0, 9.0], [1.0, 3.0])
    [2.0, 3.0]
    """
    return [one / other for one, other in zip(ones, others, strict=True)]
