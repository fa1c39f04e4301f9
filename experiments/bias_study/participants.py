"""Tasks, procedures and tracks of simulated participants."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactometry.analysis.tasks.kinds import CURVES
from tactometry.analysis.threshold.fitting import ThresholdFit, fit_many
from tactometry.protocols import ConstantStimuli, Quest, QuestPlus, Staircase, WeightedStaircase
from tactometry.protocols.batch import tracks as batch
from tactometry.protocols.batch.answers import criteria
from tactometry.protocols.bayesian.parameter_grid import ParameterGrid
from tactometry.protocols.bayesian.quest_plus import Aim
from tactometry.protocols.procedures.procedure import Rule
from tactometry.protocols.procedures.stepping import SteppingRule

Array = NDArray[np.float64]
SHAPE, LAPSE_RATE, FALSE_ALARM_RATE = "gumbel", 0.02, 0.03
WIDTHS_DB = (4.0, 16.0)
"""Smallest and largest width of a participant. Widths are uniform on a logarithmic scale."""
LOW_DB, HIGH_DB = 0.0, 40.0
CONSTANT_DB = tuple(np.arange(8.0, 33.0, 4.0).tolist())
MOST_TRIALS = 160
ENDLESS = 10**6
ENDS: dict[str, Any] = {"n_reversals": ENDLESS, "n_trials": ENDLESS, "n_at_bound": ENDLESS}
"""Stopping parameters of a track that ends only with its number of trials."""
STEPS_DB = (8.0, 4.0, 2.0)
INSIDE = "inside"
PLACES = (
    INSIDE,
    "at the lower end",
    "at the upper end",
    *(f"{k} {side}" for side in ("below", "above") for k in (1, 2, 3)),
)
"""Places of the threshold: in the middle half of the levels, at their ends, or some widths outside."""


@dataclass(frozen=True)
class SimulatedTask:
    """Task with the guess rates of participant and fit, and catch trials.

    A guess rate of None is a free parameter of the fit. The share of catch trials is per trial.
    """

    name: str
    guess_rate: float
    told: float | None
    catch: float = 0.0

    def n_catch(self, n_trials: int) -> int:
        """Return the number of catch trials for a number of trials."""
        return round(self.catch * n_trials)

    def false_alarms(self, n_trials: int, n_sets: int, rng: np.random.Generator) -> NDArray[np.int64]:
        """Draw the number of false alarms (n_sets,) in the catch trials."""
        return rng.binomial(self.n_catch(n_trials), self.guess_rate, n_sets)


TASKS = (
    SimulatedTask("yes/no", FALSE_ALARM_RATE, None),
    SimulatedTask("yes/no, catch trials", FALSE_ALARM_RATE, None, 0.25),
    *(SimulatedTask(f"{m}AFC", 1 / m, 1 / m) for m in (2, 3, 4)),
)


def constant() -> ConstantStimuli:
    return ConstantStimuli(CONSTANT_DB, math.ceil(MOST_TRIALS / len(CONSTANT_DB)))


def up_down(n_down: int, start_db: float = 36.0, steps_db: tuple[float, ...] = STEPS_DB) -> Staircase:
    return Staircase(start_db, steps_db, LOW_DB, HIGH_DB, n_down=n_down, **ENDS)


def weighted() -> WeightedStaircase:
    """Return a weighted staircase with a target of 0.75."""
    ups, downs = (tuple(part * step for step in STEPS_DB) for part in (1.5, 0.5))
    return WeightedStaircase(36.0, ups, downs, LOW_DB, HIGH_DB, **ENDS)


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
"""Functions that return the rule of each procedure for a guess rate."""
AT_CHANCE = ("1 up 1 down", "2AFC")
"""Excluded combination: guessing alone reaches the target of this rule (one half), so the track drifts."""


@dataclass(frozen=True)
class Tracks:
    """Tracks of simulated participants.

    Thresholds and widths have the shape (n_sets,). Levels and answers have the shape (n_sets, n_trials), with NaN after
    the end of a track. The estimates of the rule (n_sets,) are NaN where the rule has none.
    """

    thresholds_db: Array
    widths_db: Array
    levels_db: Array
    answers: Array
    rule_db: Array


def widths_db(uniform: Array) -> Array:
    """Return widths (n_sets,) for uniform random numbers."""
    narrow, wide = np.log(WIDTHS_DB)
    return np.asarray(np.exp(narrow + (wide - narrow) * uniform))


def places_db(place: str, procedure: str, uniform: Array, width_db: Array) -> Array:
    """Return thresholds (n_sets,) at a place of `PLACES`."""
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
    n_trials: int = MOST_TRIALS,
    lapse_rate: float = LAPSE_RATE,
    procedures: Mapping[str, Callable[[float], Rule[Any]]] = PROCEDURES,
) -> Tracks:
    """Simulate one track per participant."""
    uniform = rng.random((n_sets, n_trials + 2))
    width_db = widths_db(uniform[:, 1])
    thresholds_db = places_db(place, procedure, uniform[:, 0], width_db)
    drawn = criteria(uniform[:, 2:], SHAPE, thresholds_db[:, None], width_db[:, None], task.guess_rate, lapse_rate)
    return answered(procedures[procedure](task.guess_rate), drawn, thresholds_db, width_db, rng)


def answered(rule: Rule[Any], drawn: Array, thresholds_db: Array, widths_db: Array, rng: np.random.Generator) -> Tracks:
    """Run a rule with participants whose random numbers are already drawn."""
    orders = rule.orders(len(drawn), rng) if isinstance(rule, SteppingRule) else None
    made = batch.tracks(rule, drawn, orders=orders)
    return Tracks(thresholds_db, widths_db, made.levels, made.answers.astype(np.float64), made.thresholds)


def fits(
    simulated: Tracks, task: SimulatedTask, n_trials: int, n_false_alarms: NDArray[np.int64], **options: Any
) -> tuple[ThresholdFit, ...]:
    """Fit the first trials of each track as `analyse` does."""
    curve = CURVES["yes_no" if task.told is None else "forced_choice"]
    return fit_many(
        simulated.levels_db[:, :n_trials],
        simulated.answers[:, :n_trials],
        1,
        n_false_alarms=n_false_alarms,
        n_catch=task.n_catch(n_trials),
        **{"estimate": curve.estimate, **curve.options(round(1 / task.guess_rate), "dB"), **options},
    )


def ends_of(one: ThresholdFit) -> tuple[float, float]:
    """Return the ends of the interval. An open end is infinite."""
    low, high = one.interval_low, one.interval_high
    return -math.inf if low is None else low, math.inf if high is None else high
