"""Time ANOVAs compared with pingouin and statsmodels, and the reading of a million trials.

`python benchmarks/analysis.py`
"""

import tempfile
import warnings
from functools import partial
from itertools import product
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np
import pandas as pd
import pingouin
from statsmodels.stats.anova import AnovaRM

from tactometry.analysis.anova.within_subjects import permutation_test, repeated_measures
from tactometry.analysis.reading import text_table
from tactometry.analysis.reading.trials import read_trials
from tactometry.experiments.harness import interleaved, ratios, run_once, tell

WITHIN = ["force_n", "frequency_hz"]
OURS: dict[str, Any] = {"dependent": "threshold", "within": WITHIN, "subject": "participant"}
PEER: dict[str, Any] = {"dv": "threshold", "within": WITHIN, "subject": "participant"}


def anova(rng: np.random.Generator) -> None:
    """Time two-factor analyses of 10 and of 200 participants."""
    small, large = values(10, rng), values(200, rng)
    calls = {"ours": partial(repeated_measures, small, **OURS), "pingouin": partial(of_pingouin, small)}
    took = interleaved(calls | {"permutations": partial(permutation_test, small, **OURS)}, 15)
    tell("10 x 3 x 7, our time over pingouin's", ratios(took["ours"], took["pingouin"]), at_most=1.5)
    tell("10 x 3 x 7, exact permutation test of all effects", [1e3 * each for each in took["permutations"]], "ms")
    ours_s = median(interleaved({"ours": partial(repeated_measures, large, **OURS)}, 5)["ours"])
    theirs_s, _ = run_once(AnovaRM(large, "threshold", "participant", within=WITHIN).fit)
    tell("200 x 3 x 7, AnovaRM's time over ours", theirs_s / ours_s, at_least=50)


def values(n: int, rng: np.random.Generator) -> pd.DataFrame:
    table = pd.DataFrame(list(product(range(n), range(3), range(7))), columns=["participant", *WITHIN])
    return table.assign(threshold=rng.normal(size=len(table)) + rng.normal(size=n)[table["participant"]])


def of_pingouin(table: pd.DataFrame) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        pingouin.rm_anova(table, correction=True, detailed=True, **PEER)


N_TRIALS = 1_000_000
HEADER = (
    "participant,session,study,block,trial,force_n,frequency_hz,procedure,level,level_unit,task,response,correct,"
    "onset_s,latency_s,force_mean_n,force_sd_n,force_in_band,valid,timestamp_utc,attempt,catch,level_delivered"
)


def reading(rng: np.random.Generator) -> None:
    """Time the reading of a million trials from a CSV file, with the fast and the tolerant reader."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "large.csv"
        write(path, rng)
        fast_s = [clock_s(path) for _ in range(2)]
        text_table.plain_cells = lambda text, separator: None  # type: ignore[assignment]
        slow_s = [clock_s(path) for _ in range(2)]
    tell("a million trials, by the clock", fast_s, "s", at_most=5)
    tell("the reader for quoted and damaged tables over the fast one", min(slow_s) / min(fast_s))


def clock_s(path: Path) -> float:
    began_s = perf_counter()
    read_trials(path)
    return perf_counter() - began_s


def write(path: Path, rng: np.random.Generator) -> None:
    n = N_TRIALS
    level, yes = rng.normal(20, 5, n).round(3), rng.integers(0, 2, n)
    columns = {
        "participant": [f"P{code:03d}" for code in rng.integers(1, 101, n)],
        "trial": np.arange(1, n + 1),
        "force_n": rng.choice([0.5, 1.5, 3.0], n),
        "frequency_hz": rng.choice([30, 60, 120, 240, 480], n),
        "level": level,
        "response": yes,
        "correct": yes,
        "onset_s": np.cumsum(rng.random(n)).round(6),
        "latency_s": rng.random(n).round(6),
        "force_mean_n": rng.random(n).round(6),
        "level_delivered": level,
    }
    constants = {"session": 1, "study": "large", "block": 1, "procedure": "staircase", "level_unit": "dB re 1 V"}
    constants |= {"task": "yes_no", "force_sd_n": 0.012, "force_in_band": 1, "valid": 1, "attempt": 1, "catch": 0}
    constants |= {"timestamp_utc": "2026-11-21T05:00:00"}
    pd.DataFrame(columns).assign(**constants)[HEADER.split(",")].to_csv(path, index=False)


if __name__ == "__main__":
    for measure in (anova, reading):
        measure(np.random.default_rng())
