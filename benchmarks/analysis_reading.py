"""A million trials from a CSV file, by the fast reader and by the other: `python benchmarks/analysis_reading.py`."""

import platform
import tempfile
from pathlib import Path
from time import perf_counter, process_time

import numpy as np
import pandas as pd
from measured import tell

from tactometry.analysis.reading import text_table
from tactometry.analysis.reading.trials import read_trials

N_TRIALS = 1_000_000
HEADER = (
    "participant,session,study,block,trial,force_n,frequency_hz,procedure,level,level_unit,task,response,correct,"
    "onset_s,latency_s,force_mean_n,force_sd_n,force_in_band,valid,timestamp_utc,attempt,catch,level_delivered"
)


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


def seconds(path: Path) -> list[tuple[float, float]]:
    """Wall and processor seconds of two runs."""
    times = []
    for _ in range(2):
        wall, cpu = perf_counter(), process_time()
        read_trials(path)
        times.append((perf_counter() - wall, process_time() - cpu))
    return times


def main() -> None:
    print(f"pandas {pd.__version__}, numpy {np.__version__}, Python {platform.python_version()}, {platform.machine()}")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "large.csv"
        write(path, np.random.default_rng())
        fast = seconds(path)
        text_table.plain_cells = lambda text, separator: None  # type: ignore[assignment]
        slow = seconds(path)
        size = path.stat().st_size / 1e6
    print(f"{N_TRIALS} trials of {len(HEADER.split(','))} columns, {size:.0f} MB:")
    print(f"  best {min(fast)[1]:.2f} s of processor time")
    tell("a million trials, by the clock", [wall for wall, _ in fast], "s", at_most=5)
    tell("the reader for quoted and damaged tables over the fast one", min(slow)[0] / min(fast)[0])


if __name__ == "__main__":
    main()
