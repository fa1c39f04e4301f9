"""QUEST+ per trial beside the package questplus, in one run.

Run: OMP_NUM_THREADS=1 python benchmarks/quest_plus.py. Prints the time to choose a level and take an answer, the ratio,
and in how many trials both chose the same level.
"""

import math
import time
import warnings

import numpy as np

from tactometry.protocols import ParameterGrid, QuestPlus
from tactometry.psychometric import shape_named

N_TRIALS = 40
LEVELS = tuple(float(x) for x in range(-40, 1))
SLOPE = 3.5


def ours(lapses: tuple[float, ...]) -> QuestPlus:
    scale = 20 / (SLOPE * math.log(10))
    thresholds = tuple(x + scale * math.log(math.log(2)) for x in LEVELS)
    grid = ParameterGrid(thresholds, (shape_named("gumbel").z_width * scale,), (0.5,), lapses)
    return QuestPlus(LEVELS, grid, n_trials=10**6)


def peer(lapses: tuple[float, ...]):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import questplus
    return questplus.QuestPlus(
        stim_domain={"intensity": np.array(LEVELS)},
        param_domain={
            "threshold": np.array(LEVELS),
            "slope": np.array([SLOPE]),
            "lower_asymptote": np.array([0.5]),
            "lapse_rate": np.array(lapses),
        },
        outcome_domain={"response": ["Yes", "No"]},
        func="weibull",
        stim_scale="dB",
    )


def compare(name: str, lapses: tuple[float, ...], rng: np.random.Generator) -> None:
    theirs, rule, n_same = peer(lapses), ours(lapses), 0
    times_s: dict[str, list[float]] = {"ours": [], "peer": []}
    for _ in range(N_TRIALS):
        began_s = time.perf_counter()
        level = float(np.asarray(theirs.next_stim["intensity"]))
        answer = bool(rng.random() < 0.75)
        theirs.update(stim={"intensity": level}, outcome={"response": "Yes" if answer else "No"})
        times_s["peer"].append(time.perf_counter() - began_s)
        began_s = time.perf_counter()
        n_same += rule.level == level
        rule = rule.after(answer, delivered=level)
        times_s["ours"].append(time.perf_counter() - began_s)
    medians_ms = {who: 1e3 * float(np.median(t)) for who, t in times_s.items()}
    ratio = medians_ms["peer"] / medians_ms["ours"]
    print(f"{name:<28} {medians_ms['ours']:>8.3f} {medians_ms['peer']:>8.3f} {ratio:>7.1f} {n_same:>5}/{N_TRIALS}")


def main() -> None:
    rng = np.random.default_rng()
    print(f"{'median ms per trial':<28} {'ours':>8} {'peer':>8} {'ratio':>7} {'same':>8}")
    compare("41 x 41", (0.02,), rng)
    compare("41 x 41 x 20 lapse rates", tuple(np.linspace(0, 0.1, 20)), rng)
    compare("41 x 41 x 500 lapse rates", tuple(np.linspace(0, 0.1, 500)), rng)


if __name__ == "__main__":
    main()
