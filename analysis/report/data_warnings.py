"""What a reader must know before the numbers."""

from collections.abc import Iterator, Sequence

import pandas as pd

from tactometry.errors import counted
from tactometry.trials.tasks import FORM_TASK

from ..outcomes.ratings import asked_forms
from ..reading.study_file import forms_of
from ..reading.trials import Trials
from ..result import Analysis
from ..tasks.cells import CHOICES
from ..tasks.goodness import goodness_warnings
from ..tasks.kinds import CURVES, RESULTS
from ..threshold.status import Status
from ..wording.labels import named_cells
from ..wording.numbers import percent_text

MANY_FALSE_ALARMS = 0.25
MANY_INVALID = 0.2
MANY_DROPPED = 0.01
"""Shares above these are warned of; unverified defaults."""
FEW_TRIALS = 15
STATUS_WORDS = {
    Status.BELOW: "with a threshold below the levels: its upper bound is given",
    Status.ABOVE: "with a threshold above the levels: its lower bound is given",
    Status.SEPARATED: "with one step between two levels: the width has an upper bound only",
    Status.FLAT: "without a rise with the level: no threshold is given",
    Status.NON_MONOTONE: "with a fall somewhere at rising level, more than chance explains",
    Status.TOO_FEW_LEVELS: "with fewer than three levels",
    Status.NO_DATA: "without a trial at a level",
}


def warnings_of(found: Analysis) -> tuple[str, ...]:
    """All of them, in the order in which a report says them."""
    return (
        *found.origin.warnings,
        *found.trials.notes,
        *(_exclusion_warnings(found.tables["excluded"]) if "excluded" in found.tables else ()),
        *_missing_values(found),
        *(_curve_warnings(found) if "thresholds" in found.tables else ()),
        *_other_tasks(found.trials),
        *_unanswered(found.trials),
        *_quality_warnings(found.tables["quality"]),
        *(goodness_warnings(found.tables["thresholds"], found.trials.factors) if "thresholds" in found.tables else ()),
    )


def _missing_values(found: Analysis) -> Iterator[str]:
    """Of tasks whose values are read off the answers."""
    for outcome in found.outcomes:
        if outcome.task in found.tables:
            yield from missing_cells(found.tables[outcome.task], found.trials.factors)


def _curve_warnings(found: Analysis) -> list[str]:
    """Of the fits of curves to the answers."""
    table, factors = found.tables["thresholds"], found.trials.factors
    told = [*missing_cells(table, factors), *_status_warnings(table, factors), *_few_trials(table, factors)]
    return told + _answer_warnings(found.trials, table, found.n_choices)


def _exclusion_warnings(excluded: pd.DataFrame) -> list[str]:
    """One for each rule that left something out."""
    return [
        f"left out by the rule {rule} = {part['bound'].iloc[0]:g}, numbers of trials: "
        + ", ".join(f"{code} {n}" for code, n in zip(part["participant"], part["n_trials"], strict=True))
        for rule, part in excluded.groupby("rule", sort=False)
    ]


def missing_cells(table: pd.DataFrame, factors: Sequence[str]) -> list[str]:
    """Conditions that others have and a participant has not; a factor that varies between participants alone is none of
    theirs."""
    found = []
    for task, part in table.groupby("task", sort=False):
        inside = [name for name in factors if part.groupby("participant")[name].nunique().max() > 1]
        conditions = part[inside].drop_duplicates()
        whole = part[["participant"]].drop_duplicates().merge(conditions, how="cross")
        held = whole.merge(part[["participant", *inside]].drop_duplicates(), how="left", indicator=True)
        lost = held[held["_merge"] == "left_only"].sort_values(["participant", *inside])
        if len(lost):
            found.append(
                f"{len(lost)} of {len(held)} cells of {task} without a valid trial ({named_cells(lost, inside)})"
            )
    return found


def _status_warnings(table: pd.DataFrame, factors: Sequence[str]) -> list[str]:
    found = []
    for status, text in STATUS_WORDS.items():
        part = table[table["status"] == status.value]
        if len(part):
            found.append(f"{len(part)} of {len(table)} cells {text} ({named_cells(part, factors)})")
    return found


def _few_trials(table: pd.DataFrame, factors: Sequence[str]) -> list[str]:
    part = table[table["n_trials"] < FEW_TRIALS]
    if not len(part):
        return []
    return [
        f"{len(part)} of {len(table)} cells with fewer than {FEW_TRIALS} trials: such intervals rest on the priors "
        f"({named_cells(part, factors)})"
    ]


def _answer_warnings(trials: Trials, table: pd.DataFrame, n_choices: int) -> list[str]:
    found = []
    for task in (task for task, curve in CURVES.items() if curve.counts_catch):
        part = table[table["task"] == task]
        if len(part) and not part["n_catch"].sum():
            found.append(f"no catch trials where the task is {task}: the guess rate rests on its prior alone")
    choice = trials.rows["task"].isin(CHOICES)
    if choice.any() and "target" not in trials.rows.columns:
        found.append(
            f"no column 'target' in a forced choice: {n_choices} alternatives were taken from the answers given"
        )
    return found


def _other_tasks(trials: Trials) -> list[str]:
    rows = trials.rows
    known = rows["task"].isin((*CURVES, *RESULTS))
    if "procedure" in rows.columns:
        known |= (rows["task"] == FORM_TASK) & rows["procedure"].isin(forms_of(trials.path))
    other = rows[~known]
    if not len(other):
        return []
    return [f"not analysed here, rows of other tasks: {len(other)} ({', '.join(sorted(other['task'].unique()))})"]


def _unanswered(trials: Trials) -> list[str]:
    """A warning for each questionnaire that was put and that nobody answered."""
    return [
        f"{form.title}: of {counted(rows['participant'].nunique(), 'participant')} none answered, so it has no score"
        for form, rows in asked_forms(trials)
        if (rows["response"] == "").all()
    ]


def _frame_warnings(quality: pd.DataFrame) -> list[str]:
    due = quality["n_frames"] + quality["n_dropped_frames"]
    lost = quality.assign(n_due=due)[quality["n_dropped_frames"] > MANY_DROPPED * due]
    if not len(lost):
        return []
    names = [f"{row.participant} {row.n_dropped_frames} of {row.n_due}" for row in lost.itertuples(index=False)]
    return [f"more than {percent_text(MANY_DROPPED)} of the screen's frames dropped: {', '.join(names)}"]


def _quality_warnings(quality: pd.DataFrame) -> list[str]:
    found = []
    many = quality[quality["false_alarm_rate"] > MANY_FALSE_ALARMS]
    if len(many):
        names = ", ".join(
            f"{code} {percent_text(rate)}"
            for code, rate in zip(many["participant"], many["false_alarm_rate"], strict=True)
        )
        found.append(f"more than {percent_text(MANY_FALSE_ALARMS)} false alarms in catch trials: {names}")
    if "n_dropped_frames" in quality.columns:
        found += _frame_warnings(quality)
    invalid = quality[quality["n_invalid"] > MANY_INVALID * quality["n_rows"]]
    if len(invalid):
        found.append(f"more than {percent_text(MANY_INVALID)} invalid trials: {', '.join(invalid['participant'])}")
    return found
