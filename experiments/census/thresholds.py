"""What becomes of simulated participants' thresholds: statuses, coverage, bias and length of intervals, by procedure,
task, number of trials and place of the threshold. The tables of docs/reference/analysis.md are made of it
(`python benchmarks/census.py`).

Every participant answers a whole track of the procedure itself; its first n trials are a track of n.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tactometry.analysis.tasks.kinds import CURVES
from tactometry.analysis.threshold.fitting import Status, ThresholdFit, fit_many
from tactometry.protocols import ConstantStimuli, ParameterGrid, Quest, QuestPlus, Staircase, WeightedStaircase
from tactometry.protocols.batch import tracks as batch
from tactometry.protocols.batch.answers import criteria
from tactometry.protocols.bayesian.quest_plus import Aim
from tactometry.protocols.procedures.procedure import Rule
from tactometry.protocols.procedures.stepping import SteppingRule

Array = NDArray[np.float64]
SHAPE, LAPSE_RATE, FALSE_ALARM_RATE = "gumbel", 0.02, 0.03
WIDTHS_DB = (4.0, 16.0)
"""Participants differ: their widths are drawn between these, evenly on a logarithm."""
LOW_DB, HIGH_DB = 0.0, 40.0
CONSTANT_DB = tuple(np.arange(8.0, 33.0, 4.0).tolist())
N_TRIALS = (20, 30, 40, 80, 160)
ENDLESS = 10**6
"""Of reversals, trials and moves at a bound: each track is as long as is asked."""
STEPS_DB = (8.0, 4.0, 2.0)
INSIDE = "inside"
PLACES = (
    INSIDE,
    "at the lower end",
    "at the upper end",
    *(f"{k} {side}" for side in ("below", "above") for k in (1, 2, 3)),
)
"""Of the threshold: in the middle half of the levels; at their ends; so many widths outside."""


@dataclass(frozen=True)
class SimulatedTask:
    """What is asked: the participant's guess rate, the one the fit is told (None: free), and catch trials per trial."""

    name: str
    guess_rate: float
    told: float | None
    catch: float = 0.0

    def n_catch(self, n_trials: int) -> int:
        """Return the number of catch trials next to other trials."""
        return round(self.catch * n_trials)

    def false_alarms(self, n_trials: int, n_sets: int, rng: np.random.Generator) -> NDArray[np.int64]:
        """Draw the false alarms (n_sets,) in the catch trials."""
        return rng.binomial(self.n_catch(n_trials), self.guess_rate, n_sets)


TASKS = (
    SimulatedTask("yes/no", FALSE_ALARM_RATE, None),
    SimulatedTask("yes/no, catch trials", FALSE_ALARM_RATE, None, 0.25),
    *(SimulatedTask(f"{m}AFC", 1 / m, 1 / m) for m in (2, 3, 4)),
)


def constant() -> ConstantStimuli:
    return ConstantStimuli(CONSTANT_DB, math.ceil(N_TRIALS[-1] / len(CONSTANT_DB)))


def up_down(n_down: int) -> Staircase:
    start = (36.0, STEPS_DB, LOW_DB, HIGH_DB)
    return Staircase(*start, n_down=n_down, n_reversals=ENDLESS, n_trials=ENDLESS, n_at_bound=ENDLESS)


def weighted() -> WeightedStaircase:
    """Aimed at 0.75."""
    ups, downs = (tuple(part * step for step in STEPS_DB) for part in (1.5, 0.5))
    start = (36.0, ups, downs, LOW_DB, HIGH_DB)
    return WeightedStaircase(*start, n_reversals=ENDLESS, n_trials=ENDLESS, n_at_bound=ENDLESS)


def quest(guess_rate: float) -> Quest:
    target = 1 - (1 - guess_rate) / math.e
    return Quest(20.0, 10.0, LOW_DB, HIGH_DB, 0.5, target=target, guess_rate=guess_rate, n_trials=ENDLESS)


def quest_plus(guess_rate: float, aim: Aim) -> QuestPlus:
    levels_db = tuple(np.arange(LOW_DB, HIGH_DB + 1).tolist())
    grid = ParameterGrid(levels_db, (4.0, 6.0, 9.0, 13.5, 20.0), (guess_rate,), (0.0, 0.02, 0.05))
    return QuestPlus(levels_db, grid, ENDLESS, aim=aim)


PROCEDURES: Mapping[str, Callable[[float], Rule[Any]]] = {
    "constant stimuli": lambda guess_rate: constant(),
    "1 up 1 down": lambda guess_rate: up_down(1),
    "1 up 2 down": lambda guess_rate: up_down(2),
    "1 up 3 down": lambda guess_rate: up_down(3),
    "weighted, 0.75": lambda guess_rate: weighted(),
    "QUEST": quest,
    "QUEST+": lambda guess_rate: quest_plus(guess_rate, "parameters"),
    "QUEST+, threshold first": lambda guess_rate: quest_plus(guess_rate, "threshold"),
}
"""The rule of each procedure for a task of this guess rate."""


@dataclass(frozen=True)
class Tracks:
    """Thresholds and widths (n_sets,) of participants, the levels and answers (n_sets, n_trials) of their tracks (NaN
    after the end of one), and the rule's own estimates (n_sets,), NaN where it has none."""

    thresholds_db: Array
    widths_db: Array
    levels_db: Array
    answers: Array
    rule_db: Array


def widths_db(uniform: Array) -> Array:
    """Widths (n_sets,), of uniform numbers."""
    narrow, wide = np.log(WIDTHS_DB)
    return np.asarray(np.exp(narrow + (wide - narrow) * uniform))


def places_db(place: str, procedure: str, uniform: Array, width_db: Array) -> Array:
    """Thresholds (n_sets,) of participants of some widths, of uniform numbers."""
    low, high = (CONSTANT_DB[0], CONSTANT_DB[-1]) if procedure == "constant stimuli" else (LOW_DB, HIGH_DB)
    if place == INSIDE:
        return np.asarray(low + (high - low) * (0.25 + 0.5 * uniform))
    if place.startswith("at"):
        return np.full(len(uniform), low if "lower" in place else high)
    widths, side = place.split()
    beyond = float(widths) * width_db
    return low - beyond if side == "below" else high + beyond


def tracks(
    procedure: str,
    task: SimulatedTask,
    place: str,
    n_sets: int,
    rng: np.random.Generator,
    *,
    n_trials: int = N_TRIALS[-1],
    lapse_rate: float = LAPSE_RATE,
    procedures: Mapping[str, Callable[[float], Rule[Any]]] = PROCEDURES,
) -> Tracks:
    """Simulated participants, each with a track."""
    uniform = rng.random((n_sets, n_trials + 2))
    width_db = widths_db(uniform[:, 1])
    thresholds_db = places_db(place, procedure, uniform[:, 0], width_db)
    drawn = criteria(uniform[:, 2:], SHAPE, thresholds_db[:, None], width_db[:, None], task.guess_rate, lapse_rate)
    return answered(procedures[procedure](task.guess_rate), drawn, thresholds_db, width_db, rng)


def answered(rule: Rule[Any], drawn: Array, thresholds_db: Array, widths_db: Array, rng: np.random.Generator) -> Tracks:
    """Run a rule with participants whose criteria are drawn already."""
    orders = rule.orders(len(thresholds_db), rng) if isinstance(rule, SteppingRule) else None
    made = batch.tracks(rule, drawn, orders=orders)
    return Tracks(thresholds_db, widths_db, made.levels, made.answers.astype(np.float64), made.thresholds)


def fits(
    simulated: Tracks, task: SimulatedTask, n_trials: int, n_false_alarms: NDArray[np.int64], **options: Any
) -> tuple[ThresholdFit, ...]:
    """Fit the first trials of each track as an analysis does, but for the `options` given."""
    curve = CURVES["yes_no" if task.told is None else "forced_choice"]
    return fit_many(
        simulated.levels_db[:, :n_trials],
        simulated.answers[:, :n_trials],
        1,
        n_false_alarms=n_false_alarms,
        n_catch=task.n_catch(n_trials),
        **{"estimate": curve.estimate, **curve.options(round(1 / task.guess_rate), "dB"), **options},
    )


OUTCOMES = ("procedure", "task", "place", "n_trials", "status", "low_db", "high_db", "threshold_db", "true_db")
AT_CHANCE = ("1 up 1 down", "2AFC")
"""This rule aims at one half, which guesses reach: its track drifts away from the threshold. Left out."""


def settings(
    procedures: Sequence[str] = tuple(PROCEDURES),
    tasks: Sequence[SimulatedTask] = TASKS,
    places: Sequence[str] = PLACES,
) -> list[tuple[str, SimulatedTask, str]]:
    """Each procedure with each task and place."""
    return [setting for setting in product(procedures, tasks, places) if (setting[0], setting[1].name) != AT_CHANCE]


def census(
    chosen: Sequence[tuple[str, SimulatedTask, str]],
    n_sets: int,
    rng: np.random.Generator,
    *,
    n_trials: Sequence[int] = N_TRIALS,
    lapse_rate: float = LAPSE_RATE,
) -> Iterator[pd.DataFrame]:
    """A table for each setting, with a row (`OUTCOMES`) for each participant and number of trials."""
    for (procedure, task, place), stream in zip(chosen, rng.spawn(len(chosen)), strict=True):
        simulated = tracks(procedure, task, place, n_sets, stream, n_trials=max(n_trials), lapse_rate=lapse_rate)
        rows = [
            (procedure, task.name, place, n, one.status.value, *ends_of(one), one.threshold, true_db)
            for n in n_trials
            for one, true_db in zip(
                fits(simulated, task, n, task.false_alarms(n, n_sets, stream)), simulated.thresholds_db, strict=True
            )
        ]
        yield pd.DataFrame(rows, columns=OUTCOMES).astype({"threshold_db": float})


def ends_of(one: ThresholdFit) -> tuple[float, float]:
    """Return the ends of the interval, an open one infinite."""
    low, high = one.interval_low, one.interval_high
    return -math.inf if low is None else low, math.inf if high is None else high


def summary(outcomes: pd.DataFrame, by: Sequence[str]) -> pd.DataFrame:
    """Operating characteristics, in the order of the rows: shares of the statuses, of intervals that hold the truth
    (`covered`: of those that are `ok`; `covered_all`: of all), bias of the thresholds told in their standard
    deviations, and the median length of their intervals."""
    rows = [(*key, *_row(each)) for key, each in outcomes.groupby(list(by), sort=False)]
    return pd.DataFrame(rows, columns=[*by, *COLUMNS])


FEWEST = 20
"""Thresholds whose bias is told."""
TOLD, OUT = (Status.OK, Status.SEPARATED), (Status.BELOW, Status.ABOVE)
COLUMNS = ("n", "ok", "separated", "out", "flat", "other", "covered", "covered_all", "bias_sd", "length_db")


def _row(outcomes: pd.DataFrame) -> tuple[float, ...]:
    shares = [outcomes["status"].isin(of).mean() for of in ((Status.OK,), (Status.SEPARATED,), OUT, (Status.FLAT,))]
    holds = (outcomes["low_db"] <= outcomes["true_db"]) & (outcomes["true_db"] <= outcomes["high_db"])
    with_threshold = outcomes[outcomes["status"].isin(TOLD)]
    error_db = (with_threshold["threshold_db"] - with_threshold["true_db"]).to_numpy()
    return (
        len(outcomes),
        *shares,
        1 - sum(shares),
        holds[outcomes["status"] == Status.OK].mean(),
        holds.mean(),
        error_db.mean() / error_db.std() if len(error_db) >= FEWEST else math.nan,
        (with_threshold["high_db"] - with_threshold["low_db"]).median() if len(error_db) >= FEWEST else math.nan,
    )
