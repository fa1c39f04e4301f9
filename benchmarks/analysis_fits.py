"""Threshold fits against psignifit and scipy, in one run: `python benchmarks/analysis_fits.py`.

Prints times and ratios; set OMP_NUM_THREADS=1 for comparable numbers.
"""

import platform
import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from time import process_time

import numpy as np
from measured import tell
from scipy.optimize import minimize

from tactometry.analysis.threshold.counts import count_arrays, normalise
from tactometry.analysis.threshold.fitting import fit, fit_many
from tactometry.analysis.threshold.log_posterior import LogPosterior, Prior
from tactometry.analysis.threshold.mode import find_mode
from tactometry.psychometric import SHAPES, PsychometricFunction

LEVELS = np.linspace(-3, 3, 7)
N_SETS, N_TRIALS, N_PEER = 10_000, 20, 5
SHAPE = SHAPES["normal"]
LAPSE_PRIOR_SD = 0.083
"""Of Beta(1, 10)."""


def seconds(work: Callable[[], object], repeats: int = 3) -> float:
    """CPU seconds, the best of some runs after a warm one."""
    work()
    times = []
    for _ in range(repeats):
        start = process_time()
        work()
        times.append(process_time() - start)
    return min(times)


def drawn(n_sets: int, guess: float, rng: np.random.Generator) -> np.ndarray:
    chance = PsychometricFunction("normal", 0.0, 3.3, guess, 0.02).probability(LEVELS)
    return rng.binomial(N_TRIALS, chance, (n_sets, len(LEVELS)))


def modes(k: np.ndarray) -> float:
    counts = normalise(*count_arrays(LEVELS, k, N_TRIALS))
    zeros = np.zeros(len(k))
    return seconds(lambda: find_mode(LogPosterior(SHAPE, counts, Prior(counts.gap, None, 0.5, zeros, zeros))), 2)


def scipy_one_at_a_time(k: np.ndarray) -> float:
    """Nelder-Mead on the same log posterior; seconds per set."""
    counts = normalise(*count_arrays(LEVELS, k, N_TRIALS))
    start = process_time()
    for i in range(len(k)):
        prior = Prior(counts.gap[:1], None, 0.5, np.zeros(1), np.zeros(1))
        posterior = LogPosterior(SHAPE, counts[i : i + 1], prior)

        def loss(x: np.ndarray, posterior=posterior) -> float:
            if not (abs(x[0]) < 1 and 0 <= x[2] <= 0.5):
                return 1e9
            with np.errstate(all="ignore"):
                value = -posterior.log_density(np.array([[x[0], x[1], x[2], 0.5]]))[0]
            return float(value) if np.isfinite(value) else 1e9

        minimize(loss, [0.0, -0.5, 0.02], method="Nelder-Mead")
    return (process_time() - start) / len(k)


def psignifit_seconds(k: np.ndarray, experiment: str) -> float:
    """CPU seconds per set."""
    import warnings

    from psignifit import psignifit

    start = process_time()
    for row in k:
        data = np.column_stack([LEVELS, row, np.full(len(LEVELS), N_TRIALS)])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            psignifit(data, sigmoid="norm", experiment_type=experiment)
    return (process_time() - start) / len(k)


def megabytes(work: Callable[[], object]) -> float:
    tracemalloc.start()
    work()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak / 1e6


def sd_error(k: np.ndarray) -> float:
    """The largest relative error of the half-width of a batch's threshold intervals, against grids of their own."""
    together = fit_many(LEVELS, k, N_TRIALS, shape="normal", guess_rate=0.5)
    errors = [0.0]
    for row, found in zip(k, together, strict=True):
        alone = fit(LEVELS, row, N_TRIALS, shape="normal", guess_rate=0.5)
        if found.status == alone.status == "ok":
            reach = alone.interval_high - alone.interval_low
            errors.append(abs((found.interval_high - found.interval_low) / reach - 1))
    return max(errors)


def ideal_width(curve: PsychometricFunction, levels: np.ndarray, n: float) -> float:
    """2 x 1.96 standard errors of the threshold by Fisher's information, width, lapse (and guess) rate unknown too."""
    step = 1e-5
    names = ["threshold", "width", "lapse_rate", *(["guess_rate"] if curve.guess_rate < 0.5 else [])]
    p = curve.probability(levels)
    slopes = [(replace(curve, **{a: getattr(curve, a) + step}).probability(levels) - p) / step for a in names]
    weighted = np.array(slopes) * np.sqrt(n / (p * (1 - p)))
    information = weighted @ weighted.T
    information[2, 2] += LAPSE_PRIOR_SD**-2
    return 2 * 1.96 * float(np.sqrt(np.linalg.inv(information)[0, 0]))


def calibration(rng: np.random.Generator) -> None:
    """Coverage and mean width of 95 % intervals at a fixed truth."""
    levels = np.linspace(-3, 3, 10)
    for task, guess, n_sets in (("2AFC", 0.5, 1000), ("yes/no", 0.03, 200)):
        curve = PsychometricFunction("normal", 0.2, 3.3, guess, 0.02)
        for n in (50, 100, 200, 400):
            k = rng.binomial(n // 10, curve.probability(levels), (n_sets, 10))
            found = fit_many(levels, k, n // 10, shape="normal", guess_rate=0.5 if task == "2AFC" else None)
            told = [one for one in found if one.status == "ok"]
            inside = np.mean([one.interval_low <= 0.2 <= one.interval_high for one in told])
            width = np.mean([one.interval_high - one.interval_low for one in told])
            ratio = width / ideal_width(curve, levels, n // 10)
            print(f"  {task}, {n} trials: {100 * inside:.1f} % of {len(told)}, mean width {ratio:.2f} of the ideal")


def main() -> None:
    rng = np.random.default_rng()
    forced, yes_no = drawn(N_SETS, 0.5, rng), drawn(N_PEER, 0.02, rng)
    print(f"numpy {np.__version__}, Python {platform.python_version()}, {platform.machine()}")
    peer_forced = psignifit_seconds(forced[:N_PEER], "2AFC")
    peer_yes_no = psignifit_seconds(yes_no[:2], "yes/no")
    all_modes = modes(forced)
    print(f"modes of {N_SETS} sets: {all_modes:.2f} s, {N_SETS / all_modes:.0f} a second")
    one_s = scipy_one_at_a_time(forced[:20])
    tell(f"modes of {N_SETS} sets, psignifit's time over ours", peer_forced * N_SETS / all_modes, at_least=10_000)
    tell(f"modes of {N_SETS} sets, Nelder-Mead one at a time over ours", one_s * N_SETS / all_modes, at_least=500)

    def one(k: np.ndarray, guess: float | None) -> object:
        return fit(LEVELS, k, N_TRIALS, shape="normal", guess_rate=guess)

    for name, k, guess, peer, limit in (
        ("2AFC", forced[0], 0.5, peer_forced, 50),
        ("yes/no", yes_no[0], None, peer_yes_no, 300),
    ):
        took = seconds(lambda k=k, guess=guess: one(k, guess), 10)
        memory = megabytes(lambda k=k, guess=guess: one(k, guess))
        tell(f"posterior of one {name} set, psignifit's time over ours", peer / took, at_least=limit)
        tell(f"posterior of one {name} set", 1e3 * took, "ms", at_most=20)
        tell(f"posterior of one {name} set, memory", memory, "MB", at_most=100)
    batch = seconds(lambda: fit_many(LEVELS, forced[:1000], N_TRIALS, shape="normal", guess_rate=0.5), 2) / 1000
    print(f"posteriors in a batch: {1e3 * batch:.2f} ms a set")
    tell("posteriors in a batch, psignifit's time over ours", peer_forced / batch, at_least=1000)
    tell(
        "largest error of a batch's intervals against grids of their own", 100 * sd_error(forced[:100]), "%", at_most=1
    )
    print("95 % intervals of the threshold:")
    calibration(rng)


if __name__ == "__main__":
    main()
