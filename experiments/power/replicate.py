"""Simulate one study, and test it for each number of participants."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from math import log10

import numpy as np
import pandas as pd
from scipy.special import ndtr, ndtri

from tactometry.analysis.outcomes.findings import Primary
from tactometry.analysis.outcomes.outcome import outcome
from tactometry.analysis.plan import AnalysisPlan
from tactometry.analysis.reading.quality import exclude, quality
from tactometry.analysis.reading.trials import Trials, used_rows
from tactometry.analysis.tasks import cells
from tactometry.analysis.tasks.applied_force import force_of_participants, has_force
from tactometry.analysis.tasks.kinds import RESULTS
from tactometry.analysis.tasks.signal_detection import forced_choice_sensitivity
from tactometry.observers.people import Feeling
from tactometry.observers.signal_detection import SignalDetectionObserver
from tactometry.protocols.tasks.task import Task
from tactometry.records.head import LARGEST_SEED
from tactometry.rigs.simulated import meeting

from ..sessions.in_memory import simulated_trials
from ..sessions.recording import Who
from ..study.dry_run import ITEM_S
from ..study.experiment import Experiment
from ..study.session_plan import Key, all_sessions, stream
from .design import Case, PowerDesign
from .level_map import with_stated_levels
from .scenario import experiment_of, growth, maps_of, middle_of, plan_of_study
from .scores import applied_effect, form_of_task, p_of, p_of_scores, task_scores

TRUTH = "truth"
Grown = Callable[[Key], tuple[float, float]]
"""Function that returns the growth of a cell."""


def true_thresholds(experiment: Experiment, codes: list[str], seed: int) -> pd.DataFrame:
    """Return a table of true thresholds by participant and cell.

    The column `TRUTH` contains the thresholds. The table is empty if they are unknown. A threshold is the level at
    which the psychometric function, without lapses and at the requested touch, is half-way between its asymptotes.
    Sensation is extrapolated from the middle of the levels.
    """
    if experiment.table.kind not in ("yes_no", "forced_choice"):
        return pd.DataFrame()
    grown = cache(lambda key: growth(experiment, experiment.cells[key]))  # the same for all participants
    rows = [row for code in codes for row in _of_person(experiment, code, seed, grown)]
    return pd.DataFrame(rows)


def _of_person(experiment: Experiment, code: str, seed: int, grown: Grown) -> Iterator[dict[str, object]]:
    observer, feelings = experiment.simulated_participant(code, seed), experiment.feelings(code, seed)
    for key, cell in experiment.cells.items():
        stimulus = cell.condition.stimulus
        feeling = feelings[meeting(stimulus, cell.condition.touch.request(stimulus, None, None))]
        level = _level(experiment, key, observer, feeling, grown)
        if level is not None:
            yield {"participant": code, **cell.condition.factors, TRUTH: level}


def _level(experiment: Experiment, key: Key, observer: object, feeling: Feeling, grown: Grown) -> float | None:
    if feeling.threshold is not None:
        return feeling.threshold - feeling.deviation_db
    if not isinstance(observer, SignalDetectionObserver):
        return None
    at_db, slope = grown(key)
    own_db = _half_way_db(observer, experiment.task) - feeling.deviation_db
    return middle_of(experiment.cells[key]) + (own_db - at_db) / slope


def _half_way_db(observer: SignalDetectionObserver, task: Task) -> float:
    """Return the half-way sensation level, by inverting the observer's d'."""
    n_intervals = getattr(task, "n_intervals", 0)
    d_prime = half_way_of_choice(n_intervals) if n_intervals else half_way_of_yes(observer.criterion + observer.bias)
    return 20 / observer.exponent * log10(d_prime / observer.criterion) - observer.sensitivity_db


def half_way_of_yes(criterion: float) -> float:
    """Return the d' with a yes rate half-way from false alarms to 1.

    >>> round(half_way_of_yes(1.645), 3)
    1.708
    """
    return float(criterion + ndtri((1 + ndtr(-criterion)) / 2))


@lru_cache(maxsize=8)
def half_way_of_choice(n_intervals: int) -> float:
    """Return the d' with a correct rate half-way from chance to 1.

    Green and Swets (1966), chapter 2.

    >>> round(half_way_of_choice(2), 4)
    0.9539
    """
    return forced_choice_sensitivity((1 + 1 / n_intervals) / 2, n_intervals)


@dataclass(frozen=True)
class Row:
    """Result of one simulated study with a number of participants.

    `n_trials` is 0 for the number of trials in the study file. `p` is None if no test had a result, which counts as not
    significant. `found` is the effect in the data, in the unit of the dependent variable. `error` is the mean
    difference of known thresholds from the true ones, and `width` the mean width of intervals. `n_unknown` of `n_cells`
    (participants times conditions) have no value. The test excludes `n_left_out` participants.
    """

    n_trials: int
    has_effect: bool
    replicate: int
    n_participants: int
    p: float | None
    significant: bool
    found: float | None
    error: float | None
    width: float | None
    n_cells: int
    n_unknown: int
    n_left_out: int
    minutes: float


def replicate(design: PowerDesign, case: Case, number: int) -> tuple[Row, ...]:
    """Simulate study `number` of a case, and return its rows.

    The function is pure. Studies with the same number share participants, orders and noise in all cases.
    """
    rows, _ = studied(design, case, number)
    return rows


def studied(design: PowerDesign, case: Case, number: int) -> tuple[tuple[Row, ...], Trials]:
    """Simulate a study like `replicate`, and return its trials too."""
    experiment = experiment_of(design, case)
    plan = plan_of_study(experiment.study)
    seed = seed_of(design.seed, number)
    truth = true_thresholds(experiment, codes(design.n_participants), seed)
    trials, maps = simulated(design, experiment, seed), maps_of(design, case)
    if maps:
        trials = replace(trials, rows=with_stated_levels(trials.rows, design.effect.factor, maps))
    every = _Compared(design, experiment, plan, trials, truth)
    return tuple(every.row(case, number, n) for n in design.participants), trials


def seed_of(seed: int, number: int) -> int:
    """Return the seed of a simulated study, independent of all others.

    >>> len({seed_of(1, number) for number in range(1000)})
    1000
    """
    (word,) = np.random.SeedSequence(seed, spawn_key=(number,)).generate_state(1, np.uint64)
    return int(word) & LARGEST_SEED


def codes(n: int) -> list[str]:
    """Return the codes of the first `n` participants."""
    return [f"P{number:03d}" for number in range(1, n + 1)]


def simulated(design: PowerDesign, experiment: Experiment, seed: int) -> Trials:
    """Simulate the study with most participants, without trials after dropout."""
    study = experiment.study
    sessions = [
        Who(code, session, seed=seed)
        for number, code in enumerate(codes(design.n_participants), 1)
        for session in range(1, len(all_sessions(study, None, number, seed)) + 1)
    ]
    trials = simulated_trials(experiment, sessions)
    if not design.dropout_share:
        return trials
    stays = [
        _stays(rows, design.dropout_share, seed, str(code))
        for code, rows in trials.rows.groupby("participant", sort=True)
    ]
    return replace(trials, rows=pd.concat(stays, ignore_index=True))


def _stays(rows: pd.DataFrame, share: float, seed: int, code: str) -> pd.DataFrame:
    leaves, place = stream(seed, code, "dropout").random(2)
    return rows.iloc[: int(place * len(rows))] if leaves < share else rows


class _Compared:
    """Simulated study, fitted once and tested for each number of participants."""

    def __init__(
        self,
        design: PowerDesign,
        experiment: Experiment,
        plan: AnalysisPlan,
        everything: Trials,
        truth: pd.DataFrame,
    ) -> None:
        self.design, self.experiment, self.plan, self.everything = design, experiment, plan, everything
        self.trials, _ = exclude(everything, plan.exclusion, quality(everything))
        self.task, self.form = experiment.table.kind, form_of_task(experiment)
        self.used = used_rows(self.trials)
        self.minutes = _minutes(everything.rows, experiment)
        self.values = _with_truth(self._values(), truth)

    def _values(self) -> pd.DataFrame:
        """Return the dependent values by participant and condition."""
        factors = self.trials.factors
        if self.form is not None:
            return task_scores(self.trials, self.form)
        if self.task in RESULTS:
            results = RESULTS[self.task]
            of_task = self.used[self.used["task"] == self.task]
            return results.tables[results.compared or self.task](of_task, factors)
        every = cells.cells(cells.counted_answers(cells.judgements(self.used)), factors)
        unit = cells.level_unit(self.trials)
        return cells.estimate_table(cells.estimates(every, unit), factors, unit)

    def row(self, case: Case, number: int, n: int) -> Row:
        """Return the result for the first `n` participants."""
        these, dependent = codes(n), self.design.dependent
        values = self.values[self.values["participant"].isin(these)] if len(self.values) else self.values
        known = values[dependent].notna() if len(values) else pd.Series(dtype=bool)
        p = self._p(values, these) if len(values) else None
        has_any = set(values.loc[known, "participant"]) if len(values) else set()
        return Row(
            n_trials=case.n_trials or 0,
            has_effect=case.has_effect,
            replicate=number,
            n_participants=n,
            p=p,
            significant=p is not None and p < self.design.alpha,
            found=self._found(values) if len(values) else None,
            error=_error(values, dependent),
            width=_width(values, dependent) if len(values) else None,
            n_cells=n * self._n_conditions(),
            n_unknown=n * self._n_conditions() - int(known.sum()),
            n_left_out=n - len(has_any),
            minutes=mean_minutes(self.minutes, n),
        )

    def _n_conditions(self) -> int:
        study, over = self.experiment.study, self.experiment.table.over
        kept = [levels for name, levels in study.factors.items() if name != over and name not in study.plan.between]
        return int(np.prod([len(levels) for levels in kept]))

    def _p(self, values: pd.DataFrame, these: list[str]) -> float | None:
        """Return the p value of the factor, or None without a result."""
        factor, dependent, primary = self.design.effect.factor, self.design.dependent, self.plan.primary
        if self.form is not None:
            return p_of_scores(values, self.experiment.study, dependent, factor, primary)
        results = RESULTS.get(self.task)
        further = results.further if results is not None else ()
        factors = [name for name in (*self.trials.factors, *further) if name in values.columns]
        forces = self._forces(these) if primary == Primary.MIXED_MODEL.value else None
        result = outcome(values, factors, self.task, dependent, forces=forces, primary=primary, compared=False)
        return p_of(result, factor)

    def _forces(self, these: list[str]) -> pd.DataFrame | None:
        used = self.used[self.used["participant"].isin(these)]
        return force_of_participants(used, self.trials.factors) if has_force(used) else None

    def _found(self, values: pd.DataFrame) -> float | None:
        """Return the effect in the data.

        Computed as the slope of the level means over the stated effect, times the range of that effect.
        """
        study = self.experiment.study
        effect = applied_effect(self.design.effect, study)
        if effect.factor not in values.columns:
            return None
        levels = study.factors[effect.factor]
        by_level = dict(zip(levels, effect.of_levels(levels).values(), strict=True))
        means = values.groupby(effect.factor)[self.design.dependent].mean()
        x = np.array([by_level[level] for level in means.index])
        y = means.to_numpy(dtype=float)
        x = x - x.mean()
        if np.isnan(y).any() or not np.any(x):
            return None
        return float(x @ y / (x @ x) * np.ptp(list(by_level.values())))


def _with_truth(values: pd.DataFrame, truth: pd.DataFrame) -> pd.DataFrame:
    if not len(values) or not len(truth):
        return values
    keys = [name for name in truth.columns if name != TRUTH and name in values.columns]
    return values.merge(truth, on=keys, how="left")


def _error(values: pd.DataFrame, dependent: str) -> float | None:
    """Return the mean difference of known values from the true ones."""
    if TRUTH not in values.columns:
        return None
    error = (pd.to_numeric(values[dependent]) - values[TRUTH]).mean()
    return None if pd.isna(error) else float(error)


def _width(values: pd.DataFrame, dependent: str) -> float | None:
    low, high = (
        ("interval_low", "interval_high") if "interval_low" in values else (f"{dependent}_low", f"{dependent}_high")
    )
    if low not in values or high not in values:
        return None
    widths = pd.to_numeric(values[high]) - pd.to_numeric(values[low])
    width = widths[values[dependent].notna()].mean()
    return None if pd.isna(width) else float(width)


def mean_minutes(minutes: "pd.Series[float]", n: int) -> float:
    """Average the minutes of the first `n` participants who have trials.

    The sum has a fixed order. The order of a set differs between processes and would change the last bits.
    """
    return float(minutes[[code for code in codes(n) if code in minutes]].mean())


def _minutes(rows: pd.DataFrame, experiment: Experiment) -> "pd.Series[float]":
    """Return each participant's minutes of trials and questionnaire items."""
    keys = ["participant", *(name for name in ("session", "block", "trial", "attempt") if name in rows)]
    is_item = rows["item"] != "" if "item" in rows else pd.Series(False, rows.index)
    trials = rows[rows["level"].notna() | ~is_item].drop_duplicates(keys).groupby("participant").size()
    items = is_item.groupby(rows["participant"]).sum()
    return (trials.reindex(items.index, fill_value=0) * experiment.study.trial_s + items * ITEM_S) / 60
