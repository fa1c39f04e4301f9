"""CPU time of one fit, or one analysis of variance, of every hard case: `python benchmarks/analysis_hard_cases.py`.

Each is to take at most 100 ms; set OMP_NUM_THREADS=1 for comparable numbers.
"""

import platform
from collections.abc import Callable, Iterator
from functools import partial
from itertools import product
from time import process_time
from typing import Any

import numpy as np
import pandas as pd
from measured import tell

from tactometry.analysis.anova.within_subjects import repeated_measures
from tactometry.analysis.threshold.fitting import fit
from tactometry.errors import InvalidParameter

GUIDE_S = 0.1
SEVEN = np.arange(1.0, 8.0)
RISING = np.array([1, 2, 5, 10, 16, 18, 20])
FORCED = np.array([10, 11, 12, 15, 18, 19, 20])

DATA_SETS: dict[str, tuple[Any, Any, Any, float | None]] = {
    "all correct, 2AFC": (SEVEN, [20] * 7, 20, 0.5),
    "all wrong, 2AFC": (SEVEN, [0] * 7, 20, 0.5),
    "all at chance": (SEVEN, [10] * 7, 20, 0.5),
    "all yes": (SEVEN, [20] * 7, 20, None),
    "all no": (SEVEN, [0] * 7, 20, None),
    "perfect step, yes/no": (SEVEN, [0, 0, 0, 20, 20, 20, 20], 20, None),
    "perfect step, 2AFC": (SEVEN, [10, 10, 10, 20, 20, 20, 20], 20, 0.5),
    "one level": ([3.0], [15], 20, 0.5),
    "two levels": ([3.0, 5.0], [12, 18], 20, 0.5),
    "one trial per level, 40 levels": (np.linspace(-3, 3, 40), [0] * 12 + [0, 1] * 8 + [1] * 12, 1, None),
    "300 trials unpooled": (
        np.repeat(SEVEN[:6], 50),
        np.arange(300) % 10 < np.repeat([0, 1, 4, 7, 9, 10], 50),
        1,
        None,
    ),
    "300 continuous levels": (np.linspace(-3, 3, 300), [0] * 90 + [0, 1, 1] * 40 + [1] * 90, 1, None),
    "a million trials per level": (SEVEN, 50_000 * FORCED, 1_000_000, 0.5),
    "a million trials per level, yes/no": (SEVEN, 50_000 * RISING, 1_000_000, None),
    "NaN level": ([np.nan, 2, 3], [1, 2, 3], 20, 0.5),
    "text for a level": (["low", 2, 3], [1, 2, 3], 20, 0.5),
    "minus infinite level": ([-np.inf, 2, 3], [1, 2, 3], 20, 0.5),
    "more answers than trials": (SEVEN, [1, 2, 3, 4, 5, 6, 21], 20, 0.5),
    "rows without trials": ([*SEVEN, 40], [*FORCED, 0], [20] * 7 + [0], 0.5),
    "no row": ([], [], [], 0.5),
    "falling": (SEVEN, FORCED[::-1], 20, 0.5),
    "non-monotone": (SEVEN, [2, 8, 18, 20, 12, 5, 2], 20, None),
    "a quarter lapses": (SEVEN, [0, 1, 4, 10, 14, 15, 15], 20, None),
    "levels 1e-9 apart": (1e-9 * SEVEN, FORCED, 20, 0.5),
    "levels 1e9 apart": (1e9 * SEVEN, FORCED, 20, 0.5),
    "levels of 1e-12": (1e-12 * SEVEN, FORCED, 20, 0.5),
    "huge offset, small spread": (1e6 + 1e-3 * SEVEN, FORCED, 20, 0.5),
    "duplicated levels": (np.repeat(SEVEN, 2), np.repeat(FORCED, 2), 20, 0.5),
    "two levels 1e-12 apart": ([*SEVEN, 7 + 1e-12], [*FORCED, 20], 20, 0.5),
}


def table(n_participants: int = 10) -> pd.DataFrame:
    rng = np.random.default_rng(1)
    keys = list(product([f"P{i}" for i in range(n_participants)], (0.5, 1.0, 1.5), range(7)))
    return pd.DataFrame(keys, columns=["who", "force", "hz"]).assign(y=rng.normal(size=len(keys)))


def tables() -> Iterator[tuple[str, pd.DataFrame]]:
    whole = table()
    yield "one cell missing", whole.drop(index=7)
    yield "the same value everywhere", whole.assign(y=3.0)
    yield "no variance within participants", whole.assign(y=np.repeat(np.arange(10.0), 21))
    yield "identical participants", whole.assign(y=np.tile(np.sin(np.arange(21.0)), 10))
    yield "one participant", table(1)
    yield "two participants", table(2)
    yield "fewer participants than levels", table(5)
    yield "two trials a cell", pd.concat([whole, whole])
    yield "one-level factor", whole[whole["hz"] == 3]
    yield "infinite value", whole.assign(y=whole["y"].where(whole.index != 3, np.inf))
    yield "offset 1e9", whole.assign(y=1e9 + whole["y"])
    yield "scale 1e-12", whole.assign(y=1e-12 * whole["y"])
    yield "no row", whole.iloc[:0]
    yield "200 participants", table(200)


def told(work: Callable[[], str]) -> str:
    try:
        return work()
    except InvalidParameter as refusal:
        return getattr(refusal, "status", None) or "refused"


def printed(name: str, work: Callable[[], str], repeats: int = 3) -> float:
    """The least CPU time of some runs after a warm one, as told."""
    said, times = told(work), []
    for _ in range(repeats):
        start = process_time()
        told(work)
        times.append(process_time() - start)
    took = min(times)
    print(f"  {name:36} {1e3 * took:7.1f} ms{' ABOVE' if took > GUIDE_S else '      '} {said}")
    return took


def of_set(levels: Any, k: Any, n: Any, guess: float | None) -> str:
    return fit(levels, k, n, shape="normal", guess_rate=guess).status


def of_table(values: pd.DataFrame) -> str:
    repeated_measures(values, dependent="y", within=["force", "hz"], subject="who")
    return "tested"


def main() -> None:
    print(f"numpy {np.__version__}, Python {platform.python_version()}, {platform.machine()}")
    print("posterior of one data set:")
    times = [printed(name, partial(of_set, *case)) for name, case in DATA_SETS.items()]
    print("repeated-measures analysis of variance, 10 x 3 x 7 unless said:")
    times += [printed(name, partial(of_table, values)) for name, values in tables()]
    print(f"above {1e3 * GUIDE_S:.0f} ms: {sum(took > GUIDE_S for took in times)} of {len(times)}")
    tell(f"slowest of {len(times)} hard cases", 1e3 * max(times), "ms", at_most=1e3 * GUIDE_S)


if __name__ == "__main__":
    main()
