"""Analyses of variance against pingouin and statsmodels, in one run: `python benchmarks/analysis_anova.py`.

Prints times and ratios; set OMP_NUM_THREADS=1 for comparable numbers.
"""

import platform
import warnings
from collections.abc import Callable
from itertools import product
from statistics import median
from time import perf_counter

import numpy as np
import pandas as pd
import pingouin
import statsmodels
from measured import ratios, tell
from statsmodels.stats.anova import AnovaRM

from tactometry.analysis.anova.within_subjects import permutation_test, repeated_measures

N_LEVELS = (3, 7)
WITHIN = ["force_n", "frequency_hz"]


def interleaved(works: dict[str, Callable[[], object]], repeats: int) -> dict[str, list[float]]:
    """The times of each, run in turn after a warm call."""
    times: dict[str, list[float]] = {name: [] for name in works}
    for turn in range(repeats + 1):
        for name, work in works.items():
            start = perf_counter()
            work()
            if turn:
                times[name].append(perf_counter() - start)
    return times


def study(n: int, rng: np.random.Generator) -> pd.DataFrame:
    keys = list(product(range(n), *(range(k) for k in N_LEVELS)))
    table = pd.DataFrame(keys, columns=["participant", *WITHIN])
    return table.assign(threshold=rng.normal(size=len(table)) + rng.normal(size=n)[table["participant"]])


def ours(table: pd.DataFrame) -> pd.DataFrame:
    return repeated_measures(table, dependent="threshold", within=WITHIN, subject="participant")


def of_pingouin(table: pd.DataFrame) -> pd.DataFrame:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return pingouin.rm_anova(
            table, dv="threshold", within=WITHIN, subject="participant", correction=True, detailed=True
        )


def of_statsmodels(table: pd.DataFrame) -> pd.DataFrame:
    return AnovaRM(table, "threshold", "participant", within=WITHIN).fit().anova_table


def main() -> None:
    rng = np.random.default_rng()
    versions = f"pingouin {pingouin.__version__}, statsmodels {statsmodels.__version__}, numpy {np.__version__}"
    print(f"{versions}, Python {platform.python_version()}, {platform.machine()}")
    small, large = study(10, rng), study(200, rng)
    took = interleaved(
        {
            "ours": lambda: ours(small),
            "pingouin": lambda: of_pingouin(small),
            "permutations": lambda: permutation_test(
                small, dependent="threshold", within=WITHIN, subject="participant"
            ),
        },
        repeats=15,
    )
    print(f"10 x 3 x 7: ours {1e3 * median(took['ours']):.1f} ms, pingouin {1e3 * median(took['pingouin']):.1f} ms")
    tell("10 x 3 x 7, our time over pingouin's", ratios(took["ours"], took["pingouin"]), at_most=1.5)
    tell("10 x 3 x 7, exact permutation test of all effects", [1e3 * each for each in took["permutations"]], "ms")
    took = interleaved({"ours": lambda: ours(large), "pingouin": lambda: of_pingouin(large)}, repeats=5)
    took |= interleaved({"statsmodels": lambda: of_statsmodels(large)}, repeats=1)
    ours_s, pingouin_s, (statsmodels_s,) = (median(took["ours"]), median(took["pingouin"]), took["statsmodels"])
    print(f"200 x 3 x 7: ours {1e3 * ours_s:.0f} ms, pingouin {1e3 * pingouin_s:.0f} ms, AnovaRM {statsmodels_s:.1f} s")
    tell("200 x 3 x 7, AnovaRM's time over ours", statsmodels_s / ours_s, at_least=50)


if __name__ == "__main__":
    main()
