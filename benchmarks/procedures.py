"""How many trials each procedure needs, against the information bound.

Run: OMP_NUM_THREADS=1 python benchmarks/procedures.py [--observers 1000] [--out DIR]. Minutes in full form.

The observer is a cumulative normal of standard deviation SD_DB with 2 % lapses, whose threshold lies within 1.5
standard deviations of the middle; thresholds are weighed within 2, levels go to 4. Slope and lapse rate are unknown to
the procedure: lapse rates of 0, 2 and 4 %, flat, and two priors of the standard deviation. The one is log-normal about
the true one with a factor of 1.5, from half to twice; the other (`wide`) flat from a quarter to four times, with which
plain QUEST+ has the error that others report of it. The bound on the variance of a threshold after N trials is K / N,
where K is the least of p (1 - p) / (dp/dx)^2 over all levels: the ideal sweat factor (Taylor 1971; Taylor and Creelman
1967). It holds for a known slope and lapse rate; `Task.bound_unknown` is that of the best placement when both are
nuisance, with what their prior tells of them (c-optimal design; Silvey 1980, ch. 3). Prints the root-mean-square error
and the sweat factor N * MSE of each procedure at 40, 80 and 160 trials, the trials that it needs for an error of 1 dB,
and how a run ends that is asked to stop at a posterior standard deviation of 1 dB; draws the errors. Observers of a
QUEST+ rule are simulated together, by the same sums over all of them at once; `check` holds their estimates against
the rule itself.
"""

import argparse
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from measured import tell
from scipy.special import ndtr
from scipy.stats import norm

from tactometry.protocols import (
    MethodOfLimits,
    ParameterGrid,
    Quest,
    QuestPlus,
    Staircase,
    WeightedStaircase,
    psi,
)
from tactometry.protocols.bayesian.outcome_model import p_log_p
from tactometry.protocols.bayesian.quest_plus import QuestPlusRun
from tactometry.protocols.procedures.staircase import StaircaseRun

SD_DB, LAPSE, GOAL_DB = 4.0, 0.02, 1.0
N_MAX, EVERY, SHOWN = 480, 5, (40, 80, 160)
TOGETHER = 250
"""Observers that are simulated at a time."""
LEVELS = tuple(float(x) for x in np.linspace(-16, 16, 81))
THRESHOLDS = tuple(float(x) for x in np.linspace(-8, 8, 41))
SPAN_DB = 6.0
SDS_DB, WIDE_DB = SD_DB * np.geomspace(0.5, 2, 7), SD_DB * np.geomspace(0.25, 4, 9)
LOG_FACTOR = math.log(1.5)
SD_PRIOR = tuple(float(w) for w in np.exp(-0.5 * (np.log(SDS_DB / SD_DB) / LOG_FACTOR) ** 2))
LAPSES = (0.0, 0.02, 0.04)
TO_WIDTH = 2 * 1.6448536269514722


@dataclass(frozen=True)
class Task:
    """What is asked: the chance of 1 without a stimulus."""

    name: str
    guess: float
    rmse_asked: float = float("inf")
    """The error after 160 trials that was asked for, in standard deviations of the observer."""

    def chance(self, level, threshold):
        return self.guess + (1 - self.guess - LAPSE) * ndtr((level - threshold) / SD_DB)

    def level_of(self, chance: float) -> float:
        """Where the observer of threshold 0 answers 1 with this chance."""
        return SD_DB * float(norm.ppf((chance - self.guess) / (1 - self.guess - LAPSE)))

    def bound(self) -> float:
        """The ideal sweat factor, in units of the observer's variance."""

        return float(1 / np.square(self._slopes(np.linspace(-2, 3, 5001))[0]).max())

    def bound_unknown(self, n_trials: int) -> float:
        """The least standard deviation of a threshold, in units of the observer's, with slope and lapse rate unknown
        but for their prior, by the multiplicative algorithm."""
        slopes = self._slopes(np.linspace(-4, 4, 161))
        prior = np.diag([1e-9, 1 / LOG_FACTOR**2, 1 / np.var(LAPSES)])
        weights = np.full(slopes.shape[1], 1 / slopes.shape[1])
        for _ in range(3000):
            variances = np.linalg.inv(n_trials * (slopes * weights) @ slopes.T + prior)
            weights *= np.abs(variances[0] @ slopes)
            weights /= weights.sum()
        return math.sqrt(variances[0, 0])

    def _slopes(self, z: np.ndarray) -> np.ndarray:
        """Of the chance at z by threshold, log standard deviation and lapse rate, over the answer's deviation."""
        span = 1 - self.guess - LAPSE
        p = self.guess + span * norm.cdf(z)
        return np.stack([span * norm.pdf(z), span * norm.pdf(z) * z, norm.cdf(z)]) / np.sqrt(p * (1 - p))

    def grid(self, sds_db: np.ndarray = SDS_DB) -> ParameterGrid:
        return ParameterGrid(THRESHOLDS, tuple(TO_WIDTH * sds_db), (self.guess,), LAPSES, shape="normal")


Run = Callable[["Task", np.ndarray, np.random.Generator], np.ndarray]
"""Estimates of thresholds (dB) after every `EVERY` trials, (n_observers, n_steps), NaN where there is none."""


@dataclass(frozen=True)
class Contender:
    """A procedure, and where on the observer's function its estimate is meant to lie."""

    name: str
    run: Run
    target_db: float = 0.0


def one_by_one(
    start: Callable[[np.random.Generator], object], estimate: Callable[[object], float | None], n_max: int = N_MAX
) -> Run:
    """Each observer with the procedure itself."""

    def run(task: Task, truths_db: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        found = np.full((len(truths_db), n_max // EVERY), np.nan)
        for observer, truth in enumerate(truths_db):
            rule = start(rng)
            for n in range(n_max):
                rule = rule.after(bool(rng.random() < task.chance(rule.level, truth)))
                if (n + 1) % EVERY == 0:
                    value = estimate(rule)
                    found[observer, n // EVERY] = math.nan if value is None else value
        return found

    return run


def losses_of(rule: QuestPlus, yes: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """The expected losses (n_levels, n_observers) of weights (n_cells, n_observers), by `yes` (n_levels, n_cells)."""
    first, rest = rule.begin().posterior.shape
    thresholds = np.repeat(rule.grid.thresholds, rest)
    moments = np.concatenate([yes * thresholds**power for power in range(3)])
    by_first = np.ascontiguousarray(yes.reshape(len(yes), first, rest).transpose(1, 0, 2))
    cost = p_log_p(yes) + p_log_p(1 - yes)

    def variance(weights: np.ndarray) -> np.ndarray:
        felt = (moments @ weights).reshape(3, len(yes), -1)
        whole = np.stack([thresholds**power @ weights for power in range(3)])[:, None]
        return sum(-(at[1] ** 2) / np.maximum(at[0], 1e-300) for at in (felt, whole - felt))

    def entropy(weights: np.ndarray) -> np.ndarray:
        if rule.aim == "parameters":
            chance = yes @ weights
            return p_log_p(chance) + p_log_p(1 - chance) - cost @ weights
        cells = weights.reshape(first, rest, -1)
        joint = by_first @ cells
        both = np.stack([cells.sum(axis=1)[:, None] - joint, joint])
        return p_log_p(both.sum(axis=1)).sum(axis=0) - p_log_p(both).sum(axis=(0, 1))

    return variance if rule.criterion == "variance" else entropy


def together(rule: QuestPlus, levels: Callable[..., np.ndarray] | None = None, n_max: int = N_MAX) -> Run:
    """All observers of a QUEST+ rule at once; or of levels in an order of their own, by their indices."""
    prior = rule.begin().posterior
    _, rest = prior.shape
    yes = np.exp(np.stack([rule.grid.log_likelihood(level, 1) for level in rule.levels]))
    losses, thresholds, at = losses_of(rule, yes), np.repeat(rule.grid.thresholds, rest), np.asarray(rule.levels)

    def some(task: Task, truths_db: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        weights = np.repeat(prior.reshape(-1, 1), len(truths_db), axis=1)
        found = np.empty((len(truths_db), n_max // EVERY))
        for n in range(n_max):
            chosen = losses(weights).argmin(axis=0) if levels is None else levels(n, len(truths_db), rng)
            answers = rng.random(len(truths_db)) < task.chance(at[chosen], truths_db)
            weights *= np.where(answers, yes[chosen].T, 1 - yes[chosen].T)
            weights /= weights.sum(axis=0)
            found[:, n // EVERY] = thresholds @ weights
        return found

    def run(task: Task, truths_db: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        parts = np.array_split(truths_db, math.ceil(len(truths_db) / TOGETHER))
        return np.concatenate([some(task, part, rng) for part in parts])

    return run


def check(task: Task, rng: np.random.Generator, n_max: int = N_MAX) -> None:
    """The rules' own estimates and those of `together` are alike for the same stream of random numbers."""
    truth_db = np.array([rng.uniform(-SPAN_DB, SPAN_DB)])
    for rule in rules(task).values():
        seed = int(rng.integers(2**31))
        batch = together(rule, n_max=n_max)(task, truth_db, np.random.default_rng(seed))
        alone = one_by_one(lambda _, rule=rule: rule, mean, n_max)(task, truth_db, np.random.default_rng(seed))
        np.testing.assert_allclose(batch, alone, atol=1e-6)


def rules(task: Task) -> dict[str, QuestPlus]:
    """QUEST+ and those that put the threshold first, on both priors."""
    whole = QuestPlus(LEVELS, task.grid(), n_trials=10**6, prior={"width": SD_PRIOR})
    wide = QuestPlus(LEVELS, task.grid(WIDE_DB), n_trials=10**6)
    return {
        "QUEST+": whole,
        "threshold first, entropy": replace(whole, aim="threshold"),
        "threshold first, variance": replace(whole, aim="threshold", criterion="variance"),
        "QUEST+, wide": wide,
        "threshold first, variance, wide": replace(wide, aim="threshold", criterion="variance"),
    }


def mean(rule: QuestPlusRun) -> float:
    return rule.mean("threshold")


def contenders(task: Task) -> list[Contender]:
    many = 10**6
    half = task.guess + (1 - task.guess - LAPSE) / 2
    known = psi(LEVELS, THRESHOLDS, tuple(SDS_DB), guess_rate=task.guess, lapse_rate=LAPSE, n_trials=many)
    quest = Quest(
        0.0, 8.0, -8.0, 8.0, 0.4, target=half, slope=2.7, guess_rate=task.guess, blind_share=0.04, n_trials=many
    )
    bounds = {"low": -24.0, "high": 24.0, "n_reversals": many, "n_trials": many, "n_at_bound": many}

    def late_reversals(rule: StaircaseRun) -> float | None:
        return rule.mean_of_reversals(discard=4)

    def up_down(n_down: int) -> Contender:
        rule = Staircase(12.0, (4.0, 2.0), n_down=n_down, **bounds)
        target_db = task.level_of(0.5 ** (1 / n_down))
        return Contender(f"1 up {n_down} down", one_by_one(lambda _: rule, late_reversals), target_db)

    weighted = WeightedStaircase(12.0, (6.0, 3.0), (2.0, 1.0), **bounds)
    found = [
        *(Contender(name, together(rule)) for name, rule in rules(task).items()),
        Contender("psi (lapse rate known)", together(known)),
        Contender(
            "QUEST (slope, lapse rate given)",
            one_by_one(lambda _: quest, lambda rule: float(rule.posterior @ rule.rule.thresholds)),
        ),
        *(up_down(n) for n in ((2, 3) if task.guess >= 0.5 else (1, 2))),
        Contender("weighted 3:1", one_by_one(lambda _: weighted, late_reversals), task.level_of(0.75)),
        Contender("constant stimuli, 9 levels", together(rules(task)["QUEST+"], nine_levels)),
    ]
    if task.guess < 0.5:
        limits = MethodOfLimits(-24.0, 24.0, 2.0, n_series=N_MAX, n_start_steps=6)
        found.append(Contender("limits, alternating", one_by_one(limits.begin, lambda rule: rule.threshold)))
    return found


NINE = np.linspace(10, len(LEVELS) - 11, 9).round().astype(int)


def nine_levels(n: int, n_observers: int, rng: np.random.Generator) -> np.ndarray:
    """Constant stimuli: every nine trials each of nine levels once, scored by the posterior of QUEST+."""
    if n % 9 == 0:
        nine_levels.order = np.argsort(rng.random((n_observers, 9)), axis=1)
    return NINE[nine_levels.order[:, n % 9]]


def rmse_db(errors: np.ndarray) -> np.ndarray:
    """Root mean square over observers; infinite where one observer in ten has no estimate."""
    missing = np.isnan(errors).mean(axis=0) > 0.1
    squares = np.where(np.isnan(errors), 0.0, errors**2).sum(axis=0) / np.maximum((~np.isnan(errors)).sum(axis=0), 1)
    return np.where(missing, np.inf, np.sqrt(squares))


def trials_to(goal_db: float, rmse: np.ndarray) -> int | None:
    """The number of trials from which the error stays at the goal or below."""
    above = np.flatnonzero(rmse > goal_db)
    step = 0 if above.size == 0 else int(above[-1]) + 1
    return None if step >= len(rmse) else EVERY * (step + 1)


def report(task: Task, n_observers: int, rng: np.random.Generator) -> dict[str, np.ndarray]:
    bound, curves = task.bound(), {}
    ideal = bound * (SD_DB / GOAL_DB) ** 2
    print(f"\n{task.name}: ideal sweat factor {bound:.2f} (in units of the observer's variance)")
    heads = "".join(f"{f'N={n}':>8} {'K':>6}" for n in SHOWN)
    print(f"{'RMSE / SD, sweat factor':<34}{heads}{'trials to 1 dB':>16}")
    unknown = [task.bound_unknown(n) for n in SHOWN]
    print(
        f"{'bound, slope and lapse unknown':<34}"
        + "".join(f"{e:>8.3f} {n * e**2:>6.2f}" for n, e in zip(SHOWN, unknown, strict=True))
    )
    print(f"{'bound':<34}" + "".join(f"{math.sqrt(bound / n):>8.3f} {bound:>6.2f}" for n in SHOWN) + f"{ideal:>16.0f}")
    for contender in contenders(task):
        truths_db = rng.uniform(-SPAN_DB, SPAN_DB, n_observers)
        rmse = rmse_db(contender.run(task, truths_db, rng) - truths_db[:, None] - contender.target_db)
        curves[contender.name] = rmse
        at = [rmse[n // EVERY - 1] / SD_DB for n in SHOWN]
        needed = trials_to(GOAL_DB, rmse)
        cells = "".join(f"{e:>8.3f} {n * e**2:>6.2f}" for n, e in zip(SHOWN, at, strict=True))
        limit = task.rmse_asked if contender.name in ASKED_OF else None
        tell(f"{task.name}, {contender.name}: error after 160 trials", at[-1], "SD", at_most=limit)
        print(f"{contender.name:<34}{cells}{needed if needed else f'above {N_MAX}':>16}", flush=True)
    ratio_of_trials(task, curves)
    return curves


ASKED_OF = ("threshold first, variance",)
PAIRS = (
    ("threshold first, variance", "QUEST+"),
    ("threshold first, variance, wide", "QUEST+, wide"),
    ("threshold first, variance", "QUEST+, wide"),
)


def ratio_of_trials(task: Task, curves: dict[str, np.ndarray]) -> None:
    """Trials by which one rule reaches what the other has after 160, and that the other needs for what it has then."""
    at = 160 // EVERY - 1
    for ours, theirs in PAIRS:
        fewer, more = trials_to(curves[theirs][at], curves[ours]), trials_to(curves[ours][at], curves[theirs])
        ratio = (curves[ours][at] / curves[theirs][at]) ** 2
        share, is_fair = 100 * fewer / 160 if fewer else math.inf, ours.endswith("wide") == theirs.endswith("wide")
        tell(
            f"{task.name}, {ours}: trials to the error of {theirs} after 160",
            share,
            "%",
            at_most=45 if is_fair else None,
        )
        print(
            f"{ours}, beside {theirs}: its error after 160 trials in {fewer} trials; it needs {more or 'more'} of "
            f"{N_MAX} for ours after 160; ratio of squared errors after 160: {100 * ratio:.0f} %"
        )


def stops(task: Task, n_observers: int, rng: np.random.Generator) -> None:
    """How runs end that are asked to stop at a posterior standard deviation of 1 dB."""
    start = QuestPlus(
        LEVELS, task.grid(), 400, GOAL_DB, aim="threshold", criterion="variance", prior={"width": SD_PRIOR}
    )
    ends, errors = [], []
    for _ in range(n_observers):
        threshold, rule = rng.uniform(-SPAN_DB, SPAN_DB), start
        while not rule.finished:
            rule = rule.after(bool(rng.random() < task.chance(rule.level, threshold)))
        ends.append((rule.ending, len(rule.responses)))
        errors.append(mean(rule) - threshold)
    converged = np.array([ended == "converged" for ended, _ in ends])
    n_trials = np.array([n for _, n in ends])
    tell(f"{task.name}: runs that stop at {GOAL_DB:g} dB in 400 trials", 100 * converged.mean(), "%", at_least=90)
    print(
        f"stop at a posterior SD of {GOAL_DB:g} dB, at most 400 trials: reached in {100 * converged.mean():.1f} % of "
        f"runs, median {np.median(n_trials):.0f} trials (90 %: {np.quantile(n_trials, 0.9):.0f}); RMSE of these "
        f"{math.sqrt(np.mean(np.square(np.array(errors)[converged]))):.2f} dB"
    )


COLOURS = ("#000000", "#0072B2", "#56B4E9", "#009E73", "#CC79A7", "#D55E00", "#E69F00", "#999999", "#7F3C8D", "#A5AA99")
MARKS = "osv^D<>P*X"


def draw(curves: dict[Task, dict[str, np.ndarray]], path: Path) -> None:
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, len(curves), figsize=(12, 5.4), sharey=True, layout="constrained")
    n = EVERY * np.arange(1, N_MAX // EVERY + 1)
    for axis, (task, lines) in zip(axes, curves.items(), strict=True):
        axis.loglog(n, SD_DB * np.sqrt(task.bound() / n), "--", color="0.4", label="information bound")
        for (name, rmse), colour, mark in zip(lines.items(), COLOURS, MARKS, strict=False):
            shown = np.isfinite(rmse) & (n >= 10)
            axis.loglog(n[shown], rmse[shown], color=colour, marker=mark, markevery=0.12, markersize=5, label=name)
        axis.axhline(GOAL_DB, color="0.8", zorder=0)
        axis.set(title=task.name, xlabel="Trials", xlim=(10, N_MAX), ylim=(0.25, 12))
        ticks = (10, 20, 40, 80, 160, 320)
        axis.set_xticks(ticks, [str(tick) for tick in ticks])
        axis.set_yticks((0.5, 1, 2, 4, 8), ["0.5", "1", "2", "4", "8"])
        axis.minorticks_off()
        axis.legend(fontsize=8, frameon=False)
    axes[0].set_ylabel(f"RMS error of the threshold (dB); the observer's SD is {SD_DB:g} dB")
    figure.savefig(path, dpi=120)
    print(f"\nwrote {path}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--observers", type=int, default=1000)
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    rng, curves = np.random.default_rng(), {}
    for task in (Task("Two-alternative forced choice", 0.5, 0.19), Task("Yes/no with 2 % false alarms", 0.02, 0.115)):
        check(task, rng)
        curves[task] = report(task, options.observers, rng)
        stops(task, options.observers, rng)
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
        draw(curves, options.out / "procedures.png")


if __name__ == "__main__":
    main()
