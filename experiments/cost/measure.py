"""Errors and prices of a ladder: contenders interleaved, first calls apart, medians and spread, peak memory."""

import math
import statistics
import time
import tracemalloc
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from .problem import Problem, Rung

N_ROUNDS = 5
GOALS = (1e-1, 1e-2, 1e-3, 1e-4)
SHORTEST_S = 1e-9


@dataclass(frozen=True)
class Point:
    """A rung measured: relative error, first call, median and interquartile range of warm calls (s), bytes.

    A result that is not finite is `unstable`; its error is infinite. `price` is the median time, or what the ladder
    says is paid.
    """

    ladder: str
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
class Climb:
    """All points of a ladder, and the reference's answer."""

    problem: Problem
    points: tuple[Point, ...]
    answer: Any

    @property
    def floor(self) -> float:
        """Below the reference's own uncertainty no error is believed."""
        return self.problem.reference.uncertainty

    @property
    def contenders(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(point.contender for point in self.points))

    def of(self, contender: str) -> list[Point]:
        """The points of one contender, from coarse to fine."""
        return [point for point in self.points if point.contender == contender]


def climb(problem: Problem, n_rounds: int = N_ROUNDS, cold_s: Callable[[int], float] | None = None) -> Climb:
    """Measure a ladder on one thread; errors are the same in every run, times are not.

    Without rounds the first call is the time, and memory is not measured (0). What is not paid in computing time is
    run once. `cold_s` times the first call of a rung, by its place, in a process of its own: without it the first call
    is that of this process, behind the reference and the rungs before it.
    """
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        answer = problem.reference.answer()
        firsts = [_first(rung, place, cold_s) for place, rung in enumerate(problem.rungs)]
    with threadpool_limits(1):  # of the libraries, too, that the first calls loaded
        rounds = [_round(problem.rungs, first=not n) for n in range(n_rounds)]
    points = tuple(
        _point(problem, rung, first, [times[n] for times in rounds if n in times], answer)
        for n, (rung, first) in enumerate(zip(problem.rungs, firsts, strict=True))
    )
    return Climb(problem, points, answer)


def _first(rung: Rung, place: int, cold_s: Callable[[int], float] | None) -> tuple[float, Any]:
    """Time of the first call, and the answer."""
    here_s, answer = run_once(rung.run)
    return (here_s if cold_s is None or rung.price is not None else cold_s(place)), answer


def _round(rungs: Sequence[Rung], *, first: bool) -> dict[int, float]:
    """Time of a warm call of each rung, by its place; of those that are not paid in time, in the first round only."""
    return {n: run_once(rung.run)[0] for n, rung in enumerate(rungs) if first or rung.price is None}


def run_once(run: Callable[[], Any]) -> tuple[float, Any]:
    """Processor time (s), which on one thread is the time on a quiet machine, and answer of a call."""
    start_s = time.process_time()
    answer = run()
    return max(time.process_time() - start_s, SHORTEST_S), answer


def cheapest(climb: Climb, goal: float) -> Point | None:
    """The rung with the lowest price whose error, or the floor, is at most `goal`; None if there is none."""
    good = [point for point in climb.points if max(point.error, climb.floor) <= goal]
    return min(good, key=lambda point: point.price, default=None)


def _point(problem: Problem, rung: Rung, first: tuple[float, Any], times_s: Sequence[float], reference: Any) -> Point:
    first_s, answer = first
    error = problem.error(answer, reference)
    median_s = statistics.median(times_s or [first_s])
    low_s, _, high_s = statistics.quantiles(times_s, n=4) if len(times_s) > 1 else (median_s,) * 3
    return Point(
        ladder=problem.name,
        contender=rung.contender,
        setting=rung.setting,
        error=error if math.isfinite(error) else math.inf,
        unstable=not math.isfinite(error),
        price=median_s if rung.price is None else rung.price,
        first_s=first_s,
        median_s=median_s,
        spread_s=high_s - low_s,
        peak_bytes=_peak_bytes(rung.run) if times_s else 0,
        answer_bytes=_bytes(answer),
    )


def _peak_bytes(run: Callable[[], Any]) -> int:
    tracemalloc.start()
    try:
        run()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def _bytes(answer: Any) -> int:
    import numpy as np

    parts = answer if isinstance(answer, tuple) else (answer,)
    return sum(int(np.asarray(part).nbytes) for part in parts)
