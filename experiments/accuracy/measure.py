"""Errors and prices of an accuracy problem."""

import csv
import math
import os
import statistics
import subprocess
import sys
import tracemalloc
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..harness import run_once

Real = NDArray[np.float64]
OURS = "tactometry"


@dataclass(frozen=True)
class Setting:
    """Computation with its program and price (None: its computing time)."""

    name: str
    run: Callable[[], Any]
    price: float | None = None
    contender: str = OURS


@dataclass(frozen=True)
class Reference:
    """Reference result, with its method and relative uncertainty."""

    by: str
    answer: Callable[[], Any]
    uncertainty: float


@dataclass(frozen=True)
class Problem:
    """Workload with settings from coarse to fine, grouped by contender.

    - `reference`: Reference result, from a different method than the settings if possible.
    - `error`: Function of a result and the reference that returns the relative error. `title` states the norm.
    - `price`: Name of the price, with its unit.
    - `name`: Key in `PROBLEMS`.
    - `independent`: Result of another method, given if the reference is our own method at its finest setting.
    """

    title: str
    reference: Reference
    error: Callable[[Any, Any], float]
    settings: tuple[Setting, ...]
    price: str = "computing time (s)"
    name: str = ""
    independent: Reference | None = None


def error_of_decibels(answer_db: Real, reference_db: Real) -> float:
    """Return the rms error in decibels as a fraction of the amplitude."""
    return float(10 ** (np.sqrt(np.mean(np.square(answer_db - reference_db))) / 20) - 1)


def over_rms(answer: NDArray[Any], reference: NDArray[Any]) -> float:
    """Return the rms error over the rms value."""
    return float(np.linalg.norm(answer - reference) / np.linalg.norm(reference))


def over_interval(interval: Real, reference: Real) -> float:
    """Return the largest error of mean and ends over the interval length."""
    return float(np.abs(interval - reference).max() / (reference[2] - reference[1]))


def largest_relative(answer: Real, reference: Real) -> float:
    """Return the largest relative error."""
    return float(np.abs(answer / reference - 1).max())


def over_largest(answer: Real, reference: Real) -> float:
    """Return the largest error over the largest value."""
    return float(np.abs(answer - reference).max() / np.abs(reference).max())


N_ROUNDS = 5
GOALS = (1e-1, 1e-2, 1e-3, 1e-4)
PEERS = Path(__file__).with_name("peers.csv")
"""Recorded points of other programs. `yardstick_s` is the warm time of our finest setting in the same run."""
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
COLD = """
import sys
from tactometry.experiments.accuracy import problem_of
from tactometry.experiments.harness import run_once
print(run_once(problem_of(sys.argv[1]).settings[int(sys.argv[2])].run)[0])
"""


@dataclass(frozen=True)
class Point:
    """Measured relative error, price, times (s) and memory of a setting.

    A point whose result is not finite is `unstable`, and its error is infinite. `price` is the median time unless the
    setting states another price.
    """

    problem: str
    contender: str
    setting: str
    error: float
    unstable: bool
    price: float
    first_s: float
    median_s: float
    spread_s: float
    peak_bytes: int
    answer_bytes: int


@dataclass(frozen=True)
class AccuracyCurve:
    """All measured points of a problem, and the reference result."""

    problem: Problem
    points: tuple[Point, ...]
    answer: Any

    @property
    def floor(self) -> float:
        """Uncertainty of the reference. Smaller errors are reported as this value."""
        return self.problem.reference.uncertainty

    @property
    def contenders(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(point.contender for point in self.points))

    def of(self, contender: str) -> list[Point]:
        """Return the points of one contender, from coarse to fine."""
        return [point for point in self.points if point.contender == contender]

    @property
    def frontier(self) -> list[tuple[float, float]]:
        """Prices and errors of the Pareto-optimal points."""
        best: list[tuple[float, float]] = []
        for point in sorted(self.points, key=lambda each: (each.price, each.error)):
            error = max(point.error, self.floor)
            if not point.unstable and (not best or error < best[-1][1]):
                best.append((point.price, error))
        return best

    def cheapest(self, goal: float) -> Point | None:
        """Return the cheapest point with an error of at most `goal`, or None."""
        good = [point for point in self.points if max(point.error, self.floor) <= goal]
        return min(good, key=lambda point: point.price, default=None)


def measure(problem: Problem, n_rounds: int = N_ROUNDS, cold_s: Callable[[int], float] | None = None) -> AccuracyCurve:
    """Measure all settings of a problem on one thread.

    - `n_rounds`: Number of warm calls of each setting whose price is computing time. With 0, the time is that of the
      first call, and memory is 0.
    - `cold_s`: Function that returns the time (s) of a setting's first call in a separate process, given its index. By
      default, the first call is timed in this process.
    """
    from threadpoolctl import threadpool_limits

    settings = problem.settings
    timed = [n for n, setting in enumerate(settings) if setting.price is None]
    with threadpool_limits(1):
        answer = problem.reference.answer()
        firsts = [run_once(setting.run) for setting in settings]
        if cold_s is not None:
            firsts = [(cold_s(n), first[1]) if n in timed else first for n, first in enumerate(firsts)]
    times: dict[int, list[float]] = {n: [] for n in range(len(settings))}
    with threadpool_limits(1):  # again, as the first calls may have loaded further libraries
        for number in range(n_rounds):
            for n in times if number == 0 else timed:
                times[n].append(run_once(settings[n].run)[0])
    points = (
        _point(problem, setting, firsts[n], times[n], problem.error(firsts[n][1], answer))
        for n, setting in enumerate(settings)
    )
    return AccuracyCurve(problem, tuple(points), answer)


def cold_s(problem: str, place: int) -> float:
    """Return the processor time (s) of a setting's call in a new process.

    Imports during the call are included, imports of the problem are not.
    """
    command = [sys.executable, "-c", COLD, problem, str(place)]
    environment = os.environ | ONE_THREAD | {"PYTHONPATH": os.pathsep.join(sys.path)}
    printed = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=True).stdout
    return float(printed.split()[-1])


def _point(
    problem: Problem, setting: Setting, first: tuple[float, Any], times_s: Sequence[float], error: float
) -> Point:
    import numpy as np

    first_s, answer = first
    median_s = statistics.median(times_s or [first_s])
    low_s, _, high_s = statistics.quantiles(times_s, n=4) if len(times_s) > 1 else (median_s,) * 3
    parts = answer if isinstance(answer, tuple) else (answer,)
    return Point(
        problem=problem.name,
        contender=setting.contender,
        setting=setting.name,
        error=error if math.isfinite(error) else math.inf,
        unstable=not math.isfinite(error),
        price=median_s if setting.price is None else setting.price,
        first_s=first_s,
        median_s=median_s,
        spread_s=high_s - low_s,
        peak_bytes=_peak_bytes(setting.run) if times_s else 0,
        answer_bytes=sum(int(np.asarray(part).nbytes) for part in parts),
    )


def _peak_bytes(run: Callable[[], Any]) -> int:
    tracemalloc.start()
    try:
        run()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def peers_of(curve: AccuracyCurve, record: Path = PEERS) -> tuple[Point, ...]:
    """Return recorded points of other programs, scaled to this machine.

    Times are multiplied by the time of our finest setting here, divided by its recorded time.
    """
    now_s, points = curve.points[-1].median_s, []
    for row in _rows(record):
        if row["problem"] == curve.problem.name:
            point, factor = msgspec.convert(row, Point, strict=False), now_s / float(row["yardstick_s"])
            times = {name: factor * getattr(point, name) for name in ("price", "first_s", "median_s", "spread_s")}
            points.append(replace(point, **times))
    return tuple(points)


def recorded_on(record: Path = PEERS) -> str:
    """Return date and machine of the recorded points."""
    return next((row["recorded"] for row in _rows(record)), "never")


def _rows(record: Path) -> list[dict[str, str]]:
    with record.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))
