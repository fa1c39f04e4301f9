"""Hierarchical fits in one run: `python benchmarks/analysis_hierarchical.py`.

CPU time of the threshold model for 10 participants x 21 cells x 98 trials; time and error of the mixed model for 12
participants x 7 levels against lme4's recorded numbers (1.1-31, R 4.2.2) and quadrature; set OMP_NUM_THREADS=1.
"""

import platform
from collections.abc import Callable
from time import process_time

import numpy as np
from measured import tell

from tactometry.analysis.hierarchical.fitting import fit_hierarchical
from tactometry.analysis.mixed_models.glmm import fit_glmm
from tactometry.psychometric import PsychometricFunction

LEVELS = np.linspace(5, 33, 7)
FORCES_N, FREQUENCIES_HZ = (0.5, 1.0, 2.0), (30.0, 60.0, 120.0, 240.0, 400.0, 480.0, 500.0)
PROBIT_LEVELS = np.linspace(-3, 3, 7)
PROBIT_COUNTS = """
0 1 10 15 18 20 20  3 4 6 14 16 17 20  0 1 2 7 18 20 20  0 0 2 3 5 15 17  0 1 5 17 19 19 20  0 3 6 10 19 19 20
0 0 2 9 17 20 20  0 0 0 6 11 20 20  2 9 11 13 19 19 20  0 0 7 12 16 20 20  1 1 2 11 15 20 20  0 0 0 2 15 19 20
"""
LME4 = {"intercept": (-0.0160486205618, 0.1681780283), "level": (0.9279686088526, 0.0835367670)}


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


def mixed() -> None:
    k, participants = np.array(PROBIT_COUNTS.split(), dtype=float), np.repeat([f"S{i:02d}" for i in range(12)], 7)
    fixed = {"intercept": 1.0, "level": np.tile(PROBIT_LEVELS, 12)}

    def fit(expected: bool = True, n_nodes: int = 1):
        return fit_glmm(
            k, 20, participants, fixed=fixed, random=("intercept", "level"), expected=expected, n_nodes=n_nodes
        )

    took, found = best(fit), fit()
    tell("probit model, 12 participants x 7 levels, random intercept and slope", took, "s", at_most=0.5)
    for name, (effect, error) in LME4.items():
        off = abs(found.effects[name] - effect) / error
        ratio = found.standard_errors[name] / error
        tell(f"{name}: distance from lme4's estimate, in its standard errors", off, "SE", at_most=0.05)
        tell(f"{name}: standard error over lme4's", ratio, at_least=0.95, at_most=1.05)
    exact = fit(n_nodes=9).effects["level"]
    for name, other in (
        ("lme4", LME4["level"][0]),
        ("ours, observed information", fit(expected=False).effects["level"]),
    ):
        print(f"  slope against quadrature with 9 x 9 nodes: {name} {other - exact:+.5f}")


def main() -> None:
    print(f"numpy {np.__version__}, Python {platform.python_version()}, {platform.machine()}")
    mixed()
    thresholds(np.random.default_rng())


if __name__ == "__main__":
    main()
