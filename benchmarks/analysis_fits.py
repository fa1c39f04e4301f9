"""Time threshold fits compared with psignifit and scipy, in one run: `python benchmarks/analysis_fits.py`."""

import tracemalloc
import warnings
from collections.abc import Callable
from functools import partial

import numpy as np
from psignifit import psignifit
from scipy.optimize import minimize

from tactometry.analysis.threshold.counts import count_arrays, normalise
from tactometry.analysis.threshold.fitting import fit, fit_many
from tactometry.analysis.threshold.log_posterior import LogPosterior, Prior
from tactometry.analysis.threshold.mode import find_mode
from tactometry.experiments.harness import interleaved, run_once, tell
from tactometry.psychometric import SHAPES, PsychometricFunction

LEVELS = np.linspace(-3, 3, 7)
N_SETS, N_TRIALS, N_PEER = 10_000, 20, 5
FORCED = {"shape": "normal", "guess_rate": 0.5}


def seconds(call: Callable[[], object], repeats: int = 3) -> float:
    """Return the shortest time of several calls, after a warm-up."""
    return min(interleaved({"call": call}, repeats)["call"])


def drawn(n_sets: int, guess: float, rng: np.random.Generator) -> np.ndarray:
    chance = PsychometricFunction("normal", 0.0, 3.3, guess, 0.02).probability(LEVELS)
    return rng.binomial(N_TRIALS, chance, (n_sets, len(LEVELS)))


def log_posterior(k: np.ndarray) -> LogPosterior:
    counts, zeros = normalise(*count_arrays(LEVELS, k, N_TRIALS)), np.zeros(len(k))
    return LogPosterior(SHAPES["normal"], counts, Prior(counts.gap, None, 0.5, zeros, zeros))


def nelder_mead(k: np.ndarray) -> None:
    """Maximise the same log posterior by Nelder-Mead, one set at a time."""
    for row in k:
        posterior = log_posterior(row[None])

        def loss(x: np.ndarray, posterior: LogPosterior = posterior) -> float:
            if not (abs(x[0]) < 1 and 0 <= x[2] <= 0.5):
                return 1e9
            with np.errstate(all="ignore"):
                value = -posterior.log_density(np.array([[x[0], x[1], x[2], 0.5]]))[0]
            return float(value) if np.isfinite(value) else 1e9

        minimize(loss, [0.0, -0.5, 0.02], method="Nelder-Mead")


def psignifit_s(k: np.ndarray, experiment: str) -> float:
    """Return psignifit's time per set."""

    def fit_all() -> None:
        for row in k:
            data = np.column_stack([LEVELS, row, np.full(len(LEVELS), N_TRIALS)])
            psignifit(data, sigmoid="norm", experiment_type=experiment)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return run_once(fit_all)[0] / len(k)


def megabytes(call: Callable[[], object]) -> float:
    tracemalloc.start()
    call()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak / 1e6


def largest_error(k: np.ndarray) -> float:
    """Return the largest relative error of interval lengths in a batch, compared with fits of single sets."""
    errors = [0.0]
    for row, result in zip(k, fit_many(LEVELS, k, N_TRIALS, **FORCED), strict=True):
        alone = fit(LEVELS, row, N_TRIALS, **FORCED)
        if result.status == alone.status == "ok":
            length = alone.interval_high - alone.interval_low
            errors.append(abs((result.interval_high - result.interval_low) / length - 1))
    return max(errors)


def main() -> None:
    rng = np.random.default_rng()
    forced, yes_no = drawn(N_SETS, 0.5, rng), drawn(N_PEER, 0.02, rng)
    peer_forced, peer_yes_no = psignifit_s(forced[:N_PEER], "2AFC"), psignifit_s(yes_no[:2], "yes/no")
    modes_s = seconds(lambda: find_mode(log_posterior(forced)), 2)
    one_s = run_once(partial(nelder_mead, forced[:20]))[0] / 20
    tell(f"modes of {N_SETS} sets, psignifit's time over ours", peer_forced * N_SETS / modes_s, at_least=10_000)
    tell(f"modes of {N_SETS} sets, Nelder-Mead one at a time over ours", one_s * N_SETS / modes_s, at_least=500)

    for name, k, guess, peer_s, limit in (
        ("2AFC", forced[0], 0.5, peer_forced, 50),
        ("yes/no", yes_no[0], None, peer_yes_no, 300),
    ):
        one = partial(fit, LEVELS, k, N_TRIALS, shape="normal", guess_rate=guess)
        took_s = seconds(one, 10)
        tell(f"posterior of one {name} set, psignifit's time over ours", peer_s / took_s, at_least=limit)
        tell(f"posterior of one {name} set", 1e3 * took_s, "ms", at_most=20)
        tell(f"posterior of one {name} set, memory", megabytes(one), "MB", at_most=100)

    batch_s = seconds(partial(fit_many, LEVELS, forced[:1000], N_TRIALS, **FORCED), 2) / 1000
    tell("posteriors in a batch, psignifit's time over ours", peer_forced / batch_s, at_least=1000)
    error = 100 * largest_error(forced[:100])
    tell("largest error of a batch's intervals against grids of their own", error, "%", at_most=1)


if __name__ == "__main__":
    main()
