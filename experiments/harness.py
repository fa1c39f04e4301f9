"""Measurement tools of benchmarks, `cost`, `validate-method`, `reproduce`."""

import json
import os
import platform
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from typing import Any, Final, TypeVar

from tactometry.errors import library_needed
from tactometry.files.durable import write_atomically

from .workers import Spread

J = TypeVar("J")
Call = Callable[[], Any]
ROWS: Final = "TACTOMETRY_BENCH_ROWS"
"""Environment variable with the path of a file. `tell` appends each result to it as a line of JSON."""
SHORTEST_S: Final = 1e-9


def run_once(call: Call) -> tuple[float, Any]:
    """Return processor time (s) of one thread, and the result of a call."""
    start_s = time.process_time()
    result = call()
    return max(time.process_time() - start_s, SHORTEST_S), result


def interleaved(calls: Mapping[str, Call], n_rounds: int, *, turn_s: float = 0.0) -> dict[str, list[float]]:
    """Return processor times (s) of calls that take turns in each round.

    Each call is warmed up first.
    """
    n_calls = {}
    for name, call in calls.items():
        call()
        n_calls[name] = max(int(turn_s / run_once(call)[0]), 1) if turn_s else 1
    times: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(n_rounds):
        for name, call in calls.items():
            spent_s, _ = run_once(lambda: [call() for _ in range(n_calls[name])])  # noqa: B023
            times[name].append(spent_s / n_calls[name])
    return times


def machine() -> str:
    """Return versions, processor and BLAS in one line."""
    import numpy as np
    from threadpoolctl import threadpool_info

    pools = sorted({f"{pool['internal_api']} {pool.get('architecture', '')}".strip() for pool in threadpool_info()})
    versions = f"Python {platform.python_version()}, numpy {np.__version__}"
    return f"{versions}, {platform.machine()}, {', '.join(pools)}; 1 thread"


@dataclass(frozen=True)
class MeasuredItem:
    """Measured quantity with repeats and limits. A ratio has the unit `x`."""

    what: str
    values: tuple[float, ...]
    unit: str = "x"
    at_least: float | None = None
    at_most: float | None = None

    @property
    def median(self) -> float:
        return median(self.values)

    @property
    def limits(self) -> str:
        """The limits in words, or an empty text without limits."""
        limits = {"at least": self.at_least, "at most": self.at_most}
        return ", ".join(f"{word} {self.in_unit(limit)}" for word, limit in limits.items() if limit is not None)

    def in_unit(self, value: float) -> str:
        return f"{number(value)} {self.unit}".rstrip()

    @property
    def holds(self) -> bool | None:
        """True if the median is within the limits, None without limits."""
        if self.at_least is None and self.at_most is None:
            return None
        above = self.at_least is None or self.median >= self.at_least
        return above and (self.at_most is None or self.median <= self.at_most)

    @property
    def spread(self) -> str:
        """Range of the repeats, or an empty text if they are equal."""
        least, largest = number(min(self.values)), number(max(self.values))
        return f"{least} to {largest}" if least != largest else ""

    @property
    def verdict(self) -> str:
        return {None: "", True: "reached", False: "MISSED"}[self.holds]

    def __str__(self) -> str:
        details = ", ".join(filter(None, (self.spread, self.limits, self.verdict)))
        return f"= {self.what}: {self.in_unit(self.median)}{f' ({details})' if details else ''}"


def tell(what: str, values: float | Sequence[float], unit: str = "x", **limits: float | None) -> None:
    """Print a result, and append it to the file that `ROWS` names.

    - `values`: One value, or one for each repeat.
    - `limits`: `at_least` and `at_most`.
    """
    repeats = tuple(float(f"{value:.4g}") for value in (values if isinstance(values, Sequence) else (values,)))
    result = MeasuredItem(what, repeats, unit, **limits)
    print(result, flush=True)
    if kept := os.environ.get(ROWS):
        with Path(kept).open("a", encoding="utf-8") as file:
            file.write(json.dumps(asdict(result)) + "\n")


def ratios(ones: Sequence[float], others: Sequence[float]) -> list[float]:
    """Return the ratios of paired measurements.

    >>> ratios([2.0, 9.0], [1.0, 3.0])
    [2.0, 3.0]
    """
    return [one / other for one, other in zip(ones, others, strict=True)]


def number(value: float) -> str:
    """Format a number to three digits, with an exponent only from 1e9 on.

    >>> number(1234.5), number(0.12345), number(3e-10)
    ('1230', '0.123', '3e-10')
    """
    short = f"{value:.3g}"
    return f"{float(short):.0f}" if 1000 <= abs(value) < 1e9 else short


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table.

    >>> print(table(["a", "b"], [["1", ""]]))
    | a | b |
    |---|---|
    | 1 |  |
    """
    lines = [f"| {' | '.join(row)} |" for row in (heads, *rows)]
    return "\n".join([lines[0], f"|{'---|' * len(heads)}", *lines[1:]])


def keep_chunks(paths: Sequence[Path], jobs: Sequence[J], make: Callable[[J], bytes], spread: Spread) -> Iterator[Path]:
    """Write each job's result atomically to its path, and yield the path."""
    left = [job for path, job in zip(paths, jobs, strict=True) if not path.exists()]
    kept = {path for path in paths if path.exists()}
    made = iter(spread(make, left))
    return (path if path in kept else _written(path, next(made)) for path in paths)


def _written(path: Path, content: bytes) -> Path:
    write_atomically(path, content)
    return path


def arrow(where: str) -> Any:
    """Return pyarrow with its `parquet` module. An error begins with `where`.

    Raises `DeviceFailed` if pyarrow, an optional extra of 170 MB, is not installed.
    """
    with library_needed(
        f"{where}: found no pyarrow ({{error}}), expected it for Parquet files; pip install 'tactometry[power]'"
    ):
        import pyarrow
        import pyarrow.parquet
    return pyarrow


def share_interval(n_yes: int, n: int, coverage: float = 0.95) -> tuple[float, float]:
    """Compute the exact Clopper-Pearson interval of a share.

    Clopper and Pearson (1934), Biometrika 26, 404.

    >>> low, high = share_interval(8, 10)
    >>> round(low, 4), round(high, 4)
    (0.4439, 0.9748)
    """
    from tactometry.analysis.distributions import exact_interval

    low, high = exact_interval(n_yes, n, coverage)
    return float(low), float(high)


def departure(n_yes: int, n: int, stated: float, alpha: float) -> int:
    """Return -1 or 1 if a share is significantly low or high, else 0.

    Uses the exact two-sided binomial test.

    >>> departure(80, 100, 0.95, 1e-4), departure(93, 100, 0.95, 1e-4), departure(30, 100, 0.05, 1e-4)
    (-1, 0, 1)
    """
    from scipy.stats import binomtest

    if binomtest(n_yes, n, stated).pvalue >= alpha:
        return 0
    return 1 if n_yes > stated * n else -1
