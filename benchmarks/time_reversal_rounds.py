"""What the time-reversal benchmarks share: one thread, contenders in turn, medians, and what the machine is."""

import statistics
import time
from collections.abc import Callable, Mapping

import numpy as np
import scipy
import scipy.linalg  # so that its BLAS is limited and listed
from measured import tell
from threadpoolctl import threadpool_info, threadpool_limits

threadpool_limits(1)
TURN_S = 5e-3


def interleaved(contenders: Mapping[str, Callable[[], object]], n_rounds: int = 7) -> dict[str, float]:
    """Median processor time (s) of a call of each, after a warm-up, all in turn in every round.

    A short call is repeated until its turn lasts some milliseconds, as it is in a sweep or a movie.

    On one thread processor time is the time on a quiet machine; what neighbours take is not counted.
    """
    for call in contenders.values():
        call()
    n_calls = {name: max(int(TURN_S / _spent_s(call, 1)), 1) for name, call in contenders.items()}
    times: dict[str, list[float]] = {name: [] for name in contenders}
    for _ in range(n_rounds):
        for name, call in contenders.items():
            times[name].append(_spent_s(call, n_calls[name]))
    return {name: statistics.median(each) for name, each in times.items()}


def _spent_s(call: Callable[[], object], n_calls: int) -> float:
    start = time.process_time()
    for _ in range(n_calls):
        call()
    return max(time.process_time() - start, 1e-9) / n_calls


def machine() -> str:
    """BLAS, its kernels and threads: they move every ratio against a peak."""
    found = {(i["internal_api"], i.get("architecture", "?"), i["num_threads"]) for i in threadpool_info()}
    blas = "; ".join(f"{api} {kernel}, {n} thread(s)" for api, kernel, n in sorted(found))
    return f"numpy {np.__version__}, scipy {scipy.__version__}; {blas}"


def row(
    what: str,
    value: float,
    detail: str = "",
    *,
    unit: str = "x",
    at_least: float | None = None,
    at_most: float | None = None,
) -> None:
    """One result, with how it came about."""
    tell(what, value, unit, at_least=at_least, at_most=at_most)
    if detail:
        print(f"    {detail}")
