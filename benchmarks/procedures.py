"""Count the trials that variants of QUEST+ require, compared with the information bound.

    OMP_NUM_THREADS=1 python benchmarks/procedures.py [--observers 1000]

The observer is a cumulative normal with standard deviation SD_DB and 2 % lapses. Its threshold lies within 1.5 standard
deviations of the middle. The prior of thresholds extends to 2 standard deviations, and levels to 4. Slope and lapse
rate are unknown to QUEST+. The prior of the lapse rate is flat over 0, 2 and 4 %. There are two priors of the standard
deviation: log-normal about the true value with a factor of 1.5 (from half to twice), and flat from a quarter to four
times (`wide`). For a known slope and lapse rate, the variance after N trials is at least K / N. K is the minimum of p
(1 - p) / (dp/dx)^2 over all levels, the ideal sweat factor (Taylor 1971; Taylor and Creelman 1967).
`Task.bound_unknown` is the bound for the best placement of levels if both are unknown except for their prior (c-optimal
design; Silvey 1980, ch. 3).
"""

import argparse
import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import norm

from tactometry.experiments.harness import tell
from tactometry.protocols import QuestPlus
from tactometry.protocols.batch.answers import criteria
from tactometry.protocols.batch.tracks import tracks
from tactometry.protocols.bayesian.parameter_grid import ParameterGrid
from tactometry.protocols.bayesian.weighing import normalised

SD_DB, LAPSE, GOAL_DB = 4.0, 0.02, 1.0
N_MAX, EVERY, N_SHOWN, MANY = 480, 5, 160, 10**6
LEVELS = tuple(float(x) for x in np.linspace(-16, 16, 81))
THRESHOLDS = tuple(float(x) for x in np.linspace(-8, 8, 41))
SPAN_DB = 6.0
SDS_DB, WIDE_DB = SD_DB * np.geomspace(0.5, 2, 7), SD_DB * np.geomspace(0.25, 4, 9)
LOG_FACTOR = math.log(1.5)
SD_PRIOR = tuple(float(w) for w in np.exp(-0.5 * (np.log(SDS_DB / SD_DB) / LOG_FACTOR) ** 2))
LAPSES = (0.0, 0.02, 0.04)
TO_WIDTH = 2 * 1.6448536269514722
FIRST, WHOLE, WIDE_FIRST, WIDE = (
    "threshold first, variance", "QUEST+", "threshold first, variance, wide", "QUEST+, wide",
)  # fmt: skip
PAIRS = ((FIRST, WHOLE, 45), (WIDE_FIRST, WIDE, 45), (FIRST, WIDE, None))


@dataclass(frozen=True)
class Task:
    """Task, with its guess rate and the required error (SD) after 160 trials."""

    name: str
    guess: float
    rmse_asked: float = float("inf")

    def bound(self) -> float:
        """Ideal sweat factor, in units of the observer's variance."""
        return float(1 / np.square(self._slopes(np.linspace(-2, 3, 5001))[0]).max())

    def bound_unknown(self, n_trials: int) -> float:
        """Return the smallest error (SD) for unknown slope and lapse rate, by the multiplicative algorithm."""
        slopes = self._slopes(np.linspace(-4, 4, 161))
        prior = np.diag([1e-9, 1 / LOG_FACTOR**2, 1 / np.var(LAPSES)])
        weights = np.full(slopes.shape[1], 1 / slopes.shape[1])
        for _ in range(3000):
            variances = np.linalg.inv(n_trials * (slopes * weights) @ slopes.T + prior)
            weights *= np.abs(variances[0] @ slopes)
            weights /= weights.sum()
        return math.sqrt(variances[0, 0])

    def _slopes(self, z: np.ndarray) -> np.ndarray:
        """Return derivatives by threshold, log standard deviation and lapse rate, over the answer's SD."""
        span = 1 - self.guess - LAPSE
        p = self.guess + span * norm.cdf(z)
        return np.stack([span * norm.pdf(z), span * norm.pdf(z) * z, norm.cdf(z)]) / np.sqrt(p * (1 - p))

    def grid(self, sds_db: np.ndarray = SDS_DB) -> ParameterGrid:
        return ParameterGrid(THRESHOLDS, tuple(TO_WIDTH * sds_db), (self.guess,), LAPSES, shape="normal")

    def criteria(self, truths_db: np.ndarray, rng: np.random.Generator, n_trials: int) -> np.ndarray:
        """Draw the random numbers of observers."""
        uniform = rng.random((len(truths_db), n_trials))
        return criteria(uniform, "normal", truths_db[:, None], TO_WIDTH * SD_DB, self.guess, LAPSE)


def rules(task: Task) -> dict[str, QuestPlus]:
    """Return QUEST+ and its variants that put the threshold first, with both priors."""
    whole = QuestPlus(LEVELS, task.grid(), n_trials=MANY, prior={"width": SD_PRIOR})
    wide = QuestPlus(LEVELS, task.grid(WIDE_DB), n_trials=MANY)
    return {
        WHOLE: whole,
        "threshold first, entropy": replace(whole, aim="threshold"),
        FIRST: replace(whole, aim="threshold", criterion="variance"),
        WIDE: wide,
        WIDE_FIRST: replace(wide, aim="threshold", criterion="variance"),
    }


def estimates_db(
    rule: QuestPlus, task: Task, truths_db: np.ndarray, rng: np.random.Generator, n_max: int = N_MAX
) -> np.ndarray:
    """Return the posterior means (n_observers, n_steps), each after `EVERY` further trials."""
    made = tracks(rule, task.criteria(truths_db, rng, n_max))
    logs, result = np.tile(rule.prior_state.log_weights, (len(truths_db), 1)), []
    for n, (at, answers) in enumerate(zip(made.levels.T, made.answers.T, strict=True), start=1):
        logs += rule.log_likelihoods(at, answers)
        if n % EVERY == 0:
            weights = normalised(logs)[1].reshape(len(truths_db), len(rule.thresholds), -1).sum(axis=2)
            result.append(weights @ rule.thresholds)
    return np.stack(result, axis=1)


def trials_to(goal_db: float, rmse: np.ndarray) -> int | None:
    """Return the number of trials after which the error stays at or below the goal."""
    above = np.flatnonzero(rmse > goal_db)
    step = 0 if above.size == 0 else int(above[-1]) + 1
    return None if step >= len(rmse) else EVERY * (step + 1)


def report(task: Task, n_observers: int, rng: np.random.Generator) -> None:
    bound, unknown, at = task.bound(), task.bound_unknown(N_SHOWN), N_SHOWN // EVERY - 1
    print(f"{task.name}: ideal sweat factor {bound:.2f}, bounds of the error after {N_SHOWN} trials "
          f"{math.sqrt(bound / N_SHOWN):.3f} SD (slope and lapse rate known), {unknown:.3f} SD (unknown)")  # fmt: skip
    curves: dict[str, np.ndarray] = {}
    truths_db = rng.uniform(-SPAN_DB, SPAN_DB, n_observers)
    for name, rule in rules(task).items():
        errors_db = estimates_db(rule, task, truths_db, rng) - truths_db[:, None]
        curves[name] = np.sqrt(np.mean(np.square(errors_db), axis=0))
        limit = task.rmse_asked if name == FIRST else None
        tell(f"{task.name}, {name}: error after {N_SHOWN} trials", curves[name][at] / SD_DB, "SD", at_most=limit)
    for ours, theirs, limit in PAIRS:
        fewer = trials_to(curves[theirs][at], curves[ours])
        share = 100 * fewer / N_SHOWN if fewer else math.inf
        tell(f"{task.name}, {ours}: trials to the error of {theirs} after {N_SHOWN}", share, "%", at_most=limit)


def stops(task: Task, n_observers: int, rng: np.random.Generator) -> None:
    """Count runs that reach a posterior standard deviation of 1 dB within 400 trials."""
    rule = replace(rules(task)[FIRST], n_trials=400, sd_stop=GOAL_DB)
    truths_db = rng.uniform(-SPAN_DB, SPAN_DB, n_observers)
    made = tracks(rule, task.criteria(truths_db, rng, 400))
    share = 100 * np.mean(made.n_trials < 400)
    tell(f"{task.name}: runs that stop at {GOAL_DB:g} dB in 400 trials", share, "%", at_least=90)
    print(f"median {np.median(made.n_trials):.0f} trials")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--observers", type=int, default=1000)
    n_observers, rng = parser.parse_args().observers, np.random.default_rng()
    for task in (Task("Two-alternative forced choice", 0.5, 0.19), Task("Yes/no with 2 % false alarms", 0.02, 0.115)):
        report(task, n_observers, rng)
        stops(task, n_observers, rng)


if __name__ == "__main__":
    main()
