"""Hierarchical fits in one run: `python benchmarks/analysis_hierarchical.py`.

CPU time of the threshold model for 10 participants x 21 cells x 98 trials; set OMP_NUM_THREADS=1.
"""

import platform
from collections.abc import Callable
from time import process_time

import numpy as np
from measured import tell

from tactometry.analysis.hierarchical.fitting import fit_hierarchical
from tactometry.psychometric import PsychometricFunction

LEVELS = np.linspace(5, 33, 7)
FORCES_N, FREQUENCIES_HZ = (0.5, 1.0, 2.0), (30.0, 60.0, 120.0, 240.0, 400.0, 480.0, 500.0)


def best(work: Callable[[], object], repeats: int = 3) -> float:
    """CPU seconds, the best of some runs after a warm one."""
    work()
    times = []
    for _ in range(repeats):
        start = process_time()
        work()
        times.append(process_time() - start)
    return min(times)


def study(rng: np.random.Generator) -> tuple[list[tuple], dict[tuple, float]]:
    rows, truth = [], {}
    for p in range(10):
        own, width = 2.5 * rng.normal(), 8.0 * np.exp(0.2 * rng.normal())
        for force_n in FORCES_N:
            for frequency_hz in FREQUENCIES_HZ:
                mean = 20 - 1.5 * np.log2(frequency_hz / 60) + 0.5 * np.log2(force_n)
                threshold = truth[f"P{p}", force_n, frequency_hz] = mean + own + 0.8 * rng.normal()
                k = rng.binomial(14, PsychometricFunction("normal", threshold, width, 0.5, 0.02).probability(LEVELS))
                rows += [(f"P{p}", force_n, frequency_hz, x, n, 14) for x, n in zip(LEVELS, k, strict=True)]
    return rows, truth


def thresholds(rng: np.random.Generator) -> None:
    rows, truth = study(rng)
    who, force_n, frequency_hz, x, k, n = (np.array(column) for column in zip(*rows, strict=True))
    conditions = {"force_n": force_n, "frequency_hz": frequency_hz}

    def fit():
        return fit_hierarchical(x, k, n, who, conditions, shape="normal", guess_rate=0.5)

    took, found = best(fit), fit()
    told = found.participants.dropna(subset="threshold")
    errors = [
        row.threshold - truth[row.participant, row.force_n, row.frequency_hz] for row in told.itertuples(index=False)
    ]
    print(f"thresholds of 10 participants x 21 conditions x 98 trials: status {found.status.value}")
    tell("thresholds of 10 participants x 21 conditions x 98 trials", took, "s")
    tell("root mean square error of a participant's threshold", float(np.sqrt(np.mean(np.square(errors)))), "dB")


def main() -> None:
    print(f"numpy {np.__version__}, Python {platform.python_version()}, {platform.machine()}")
    thresholds(np.random.default_rng())


if __name__ == "__main__":
    main()
