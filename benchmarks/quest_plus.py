"""Time a trial of QUEST+, compared with the package questplus and PsychoPy's handler.

    OMP_NUM_THREADS=1 python benchmarks/quest_plus.py

A trial consists of choosing a level and processing the answer. Times are processor times, without building the tables.
Choices are tied if their expected entropies differ by less than 1e-11 nat.
"""

import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import questplus
from scipy.stats import norm

from tactometry.experiments.harness import tell
from tactometry.protocols import QuestPlus
from tactometry.protocols.bayesian.parameter_grid import ParameterGrid
from tactometry.psychometric import shape_named

TIED = 1e-11


@dataclass(frozen=True)
class Size:
    """Numbers of levels, means, standard deviations and lapse rates."""

    name: str
    n_levels: int
    n_means: int
    n_sds: int = 1
    n_lapses: int = 1
    n_trials: int = 40

    def levels(self) -> tuple[float, ...]:
        return tuple(float(x) for x in np.linspace(-40, 0, self.n_levels))

    def axes(self) -> dict[str, tuple[float, ...]]:
        return {
            "mean": tuple(float(x) for x in np.linspace(-40, 0, self.n_means)),
            "sd": tuple(np.geomspace(2, 12, self.n_sds)) if self.n_sds > 1 else (4.0,),
            "lower_asymptote": (0.5,),
            "lapse_rate": tuple(np.linspace(0.0, 0.1, self.n_lapses)) if self.n_lapses > 1 else (0.02,),
        }


SIZES = (
    Size("41 levels x 41", 41, 41),
    Size("41 x (41, 20 slopes, 5 lapses)", 41, 41, 20, 5),
    Size("50 x (50, 40, 10): 2e6 cells", 50, 50, 40, 10),
)
LARGEST_MS = {SIZES[-1]: 0.5}


class Contender(Protocol):
    def choose(self) -> float: ...

    def learn(self, level: float, answer: bool) -> None: ...


class Ours:
    def __init__(self, size: Size) -> None:
        mean, sd, guess, lapse = size.axes().values()
        grid = ParameterGrid(mean, tuple(shape_named("normal").z_width * each for each in sd), guess, lapse, "normal")
        self.rule = QuestPlus(size.levels(), grid, n_trials=10**6).begin()

    def choose(self) -> float:
        return self.rule.level

    def learn(self, level: float, answer: bool) -> None:
        self.rule = self.rule.after(answer, level)


class Questplus:
    def __init__(self, size: Size) -> None:
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
    """PsychoPy's handler, with equally many cells of a Weibull function, the only one it supports."""

    def __init__(self, size: Size) -> None:
        from psychopy.data import QuestPlusHandler
        from psychopy.logging import console

        console.setLevel(50)
        mean, sd, guess, lapse = (list(axis) for axis in size.axes().values())
        options: dict[str, Any] = {"responseVals": ("Yes", "No"), "psychometricFunc": "weibull", "stimScale": "dB"}
        options |= {"thresholdVals": mean, "slopeVals": sd, "lowerAsymptoteVals": guess, "lapseRateVals": lapse}
        self.rule = QuestPlusHandler(nTrials=10**6, intensityVals=list(size.levels()), **options)

    def choose(self) -> float:
        return float(next(self.rule))

    def learn(self, level: float, answer: bool) -> None:
        self.rule.addResponse("Yes" if answer else "No", intensity=level)


def answers(rng: np.random.Generator) -> Callable[[float], bool]:
    return lambda level: bool(rng.random() < 0.5 + 0.48 * norm.cdf((level + 18.3) / 4))


def trial_ms(contender: Contender, size: Size, rng: np.random.Generator) -> np.ndarray:
    """Return the times of the trials, excluding the observer."""
    times_s, answer = [], answers(rng)
    for _ in range(size.n_trials):
        began_s = time.process_time()
        level = contender.choose()
        chosen_s = time.process_time() - began_s
        reply = answer(level)
        began_s = time.process_time()
        contender.learn(level, reply)
        times_s.append(chosen_s + time.process_time() - began_s)
    return 1e3 * np.array(times_s)


def compare(size: Size, rng: np.random.Generator) -> None:
    ours_ms = trial_ms(Ours(size), size, rng)
    tell(f"{size.name}: a trial, 99th percentile", np.quantile(ours_ms, 0.99), "ms", at_most=LARGEST_MS.get(size))
    for kind, limit in ((Questplus, None), (PsychoPy, 50)):
        ratio = np.median(trial_ms(kind(size), size, rng)) / np.median(ours_ms)
        tell(f"{size.name}: {kind.__name__}'s trial over ours, medians", ratio, at_least=limit)


def choices(size: Size, rng: np.random.Generator) -> None:
    """Count the trials in which our level differs from that of questplus and is not tied."""
    ours, theirs, answer, n_other = Ours(size), Questplus(size), answers(rng), 0
    for _ in range(size.n_trials):
        level = theirs.choose()
        losses = ours.rule.expected_loss()
        n_other += losses[ours.rule.rule.levels.index(level)] - losses.min() >= TIED
        reply = answer(level)
        ours.learn(level, reply)
        theirs.learn(level, reply)
    tell(f"{size.name}: choices other than questplus's that are no ties", n_other, "", at_most=0)


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # warnings of the other programs
    generator = np.random.default_rng()
    for measure in (compare, choices):
        for each in SIZES:
            measure(each, generator)
