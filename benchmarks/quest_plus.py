"""QUEST+ per trial beside the package questplus and PsychoPy's handler, in one run.

Run: OMP_NUM_THREADS=1 python benchmarks/quest_plus.py [--large]. A trial is the choice of a level and the answer to it,
the first trial included; building the tables comes before and is shown apart. Times are of the wall clock and of the
processor (which other programs disturb less): median and 99th percentile. `same` counts the trials in which both
programs chose the same level, `tied` those in which the two levels' expected entropies differ by less than 1e-11 nat.
Memory is what building and running add to the process at its highest.
"""

import argparse
import multiprocessing
import resource
import time
import warnings
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np
from measured import tell
from scipy.stats import norm

from tactometry.protocols import ParameterGrid, QuestPlus
from tactometry.psychometric import shape_named

TIED = 1e-11


@dataclass(frozen=True)
class Size:
    """A grid: levels, means, standard deviations, lower asymptotes, lapse rates."""

    name: str
    n_levels: int
    n_means: int
    n_sds: int = 1
    n_guesses: int = 1
    n_lapses: int = 1
    n_trials: int = 40

    def levels(self) -> tuple[float, ...]:
        return tuple(float(x) for x in np.linspace(-40, 0, self.n_levels))

    def axes(self) -> dict[str, tuple[float, ...]]:
        return {
            "mean": tuple(float(x) for x in np.linspace(-40, 0, self.n_means)),
            "sd": tuple(np.geomspace(2, 12, self.n_sds)) if self.n_sds > 1 else (4.0,),
            "lower_asymptote": tuple(np.linspace(0.4, 0.5, self.n_guesses)) if self.n_guesses > 1 else (0.5,),
            "lapse_rate": tuple(np.linspace(0.0, 0.1, self.n_lapses)) if self.n_lapses > 1 else (0.02,),
        }

    @property
    def n_cells(self) -> int:
        return 2 * self.n_levels * self.n_means * self.n_sds * self.n_guesses * self.n_lapses


SIZES = (
    Size("41 levels x 41", 41, 41),
    Size("41 x (41, 20 slopes, 5 lapses)", 41, 41, 20, 1, 5),
    Size("50 x (50, 40, 10): 2e6 cells", 50, 50, 40, 1, 10),
)
LARGE = Size("60 x (60, 20, 10, 20): 2.9e7", 60, 60, 20, 10, 20, n_trials=20)


class Ours:
    def __init__(self, size: Size) -> None:
        mean, sd, guess, lapse = size.axes().values()
        widths = tuple(shape_named("normal").z_width * each for each in sd)
        self.rule = QuestPlus(
            size.levels(), ParameterGrid(mean, widths, guess, lapse, "normal"), n_trials=10**6
        ).begin()

    def choose(self) -> float:
        return self.rule.level

    def learn(self, level: float, answer: bool) -> None:
        self.rule = self.rule.after(answer, level)


class Questplus:
    def __init__(self, size: Size) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            import questplus
        self.rule = questplus.QuestPlus(
            stim_domain={"intensity": np.array(size.levels())},
            param_domain={name: np.array(axis) for name, axis in size.axes().items()},
            outcome_domain={"response": ["Yes", "No"]},
            func="norm_cdf",
            stim_scale="linear",
        )

    def choose(self) -> float:
        return float(np.asarray(self.rule.next_stim["intensity"]))

    def learn(self, level: float, answer: bool) -> None:
        self.rule.update(stim={"intensity": level}, outcome={"response": "Yes" if answer else "No"})


class PsychoPy:
    """Its handler knows the Weibull only: other functions, as many cells."""

    def __init__(self, size: Size) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            from psychopy.data import QuestPlusHandler
            from psychopy.logging import console
        console.setLevel(50)
        axes = size.axes()
        self.rule = QuestPlusHandler(
            nTrials=10**6,
            intensityVals=list(size.levels()),
            thresholdVals=list(axes["mean"]),
            slopeVals=list(axes["sd"]),
            lowerAsymptoteVals=list(axes["lower_asymptote"]),
            lapseRateVals=list(axes["lapse_rate"]),
            responseVals=("Yes", "No"),
            psychometricFunc="weibull",
            stimScale="dB",
        )

    def choose(self) -> float:
        return float(next(self.rule))

    def learn(self, level: float, answer: bool) -> None:
        self.rule.addResponse("Yes" if answer else "No", intensity=level)


def answers(rng: np.random.Generator) -> Callable[[float], bool]:
    return lambda level: bool(rng.random() < 0.5 + 0.48 * norm.cdf((level + 18.3) / 4))


def quantiles_ms(times_s: list[float]) -> str:
    median, high = np.quantile(times_s, (0.5, 0.99)) * 1e3
    return f"{median:>9.3f} {high:>9.3f}"


def trials(kind: type, size: Size, seed: int) -> tuple[float, float, float]:
    """Times and memory of one program, printed; median and 99th percentile of its processor times (ms), and MB."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    began_s = time.perf_counter()
    rule, answer = kind(size), answers(np.random.default_rng(seed))
    built_s = time.perf_counter() - began_s
    wall_s, processor_s = [], []
    for _ in range(size.n_trials):
        started_s, busy_s = time.perf_counter(), time.process_time()
        level = rule.choose()
        middle_s = time.perf_counter(), time.process_time()
        said = answer(level)
        resumed_s = time.perf_counter(), time.process_time()
        rule.learn(level, said)
        wall_s.append(time.perf_counter() - started_s - (resumed_s[0] - middle_s[0]))
        processor_s.append(time.process_time() - busy_s - (resumed_s[1] - middle_s[1]))
    used_mb = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    print(
        f"{size.name:<32} {kind.__name__:<10} {quantiles_ms(wall_s)} {quantiles_ms(processor_s)} "
        f"{1e3 * processor_s[0]:>9.3f} {built_s:>8.3f} {used_mb:>8.0f}",
        flush=True,
    )
    median, high = (float(each) for each in np.quantile(processor_s, (0.5, 0.99)) * 1e3)
    return median, high, used_mb


def choices(size: Size, rng: np.random.Generator) -> None:
    """In how many trials both choose the same level."""
    ours, theirs, answer = Ours(size), Questplus(size), answers(rng)
    n_same = n_tied = 0
    for _ in range(size.n_trials):
        level, chosen = theirs.choose(), ours.choose()
        losses = ours.rule.expected_loss()
        n_same += chosen == level
        n_tied += chosen != level and losses[ours.rule.rule.levels.index(level)] - losses.min() < TIED
        said = answer(level)
        ours.learn(level, said)
        theirs.learn(level, said)
    print(f"{size.name:<32} same {n_same}, tied {n_tied}, of {size.n_trials}", flush=True)
    tell(
        f"{size.name}: choices other than questplus's that are no ties", size.n_trials - n_same - n_tied, "", at_most=0
    )


def apart(kind: type, size: Size, seed: int) -> tuple[float, float, float]:
    """In a process of its own, so that memory is that of one program."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        return pool.submit(trials, kind, size, seed).result()


def compare(size: Size, rng: np.random.Generator) -> None:
    """Ours beside each peer that can be had at this size."""
    kinds = (Ours, Questplus) if size is LARGE else (Ours, Questplus, PsychoPy)
    (ours, *theirs) = (apart(kind, size, int(rng.integers(2**31))) for kind in kinds)
    most_ms = {SIZES[-1]: 0.5, LARGE: 10.0}.get(size)
    tell(f"{size.name}: a trial, 99th percentile", ours[1], "ms", at_most=most_ms)
    for kind, peer in zip(kinds[1:], theirs, strict=True):
        limit = 50 if kind is PsychoPy else None
        tell(f"{size.name}: {kind.__name__}'s trial over ours, medians", peer[0] / ours[0], at_least=limit)
    if size is LARGE:
        tell(f"{size.name}: memory over that of questplus", ours[2] / theirs[0][2], at_most=0.25)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--large", action="store_true", help="also 2.9e7 cells")
    sizes = (*SIZES, LARGE) if parser.parse_args().large else SIZES
    rng = np.random.default_rng()
    print(f"{'ms per trial':<43} {'wall':>9} {'p99':>9} {'busy':>9} {'p99':>9} {'first':>9} {'build s':>8} {'MB':>8}")
    for size in sizes:
        compare(size, rng)
    for size in sizes:
        choices(size, rng)


if __name__ == "__main__":
    main()
