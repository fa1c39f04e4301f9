"""Warnings about the data, listed in the report before the results."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import pandas as pd

from tactometry.errors import count_of
from tactometry.trials.tasks import FORM_TASK, PRACTICE_MISSED

from ..outcomes.ratings import asked_forms
from ..reading.origin import choices_of, forms_of
from ..reading.rows import correctness
from ..reading.trials import Trials, used_rows
from ..result import Analysis
from ..tasks.cells import CHOICES, STATED
from ..tasks.goodness import goodness_warnings
from ..tasks.kinds import CURVES, RESULTS
from ..tasks.lapses import LAPSES, lapse_warnings
from ..tasks.localisation import OF_PARTICIPANTS, conditions_of_fits
from ..tasks.standard import FLOORS, floor_warnings
from ..threshold.status import Status
from ..wording import first_named, named_cells, percent_text

MANY_FALSE_ALARMS = 0.25
MANY_INVALID = 0.2
MANY_DROPPED = 0.01
"""Shares above these cause a warning; unverified defaults."""
FEW_TRIALS = 15
STATUS_WORDS = {
    Status.BELOW: "with a threshold below the levels: only its upper bound is known",
    Status.ABOVE: "with a threshold above the levels: only its lower bound is known",
    Status.SEPARATED: "with a single step between two levels: only an upper bound of the width is known",
    Status.FLAT: "in which the rate does not clearly rise with the level: only an interval is reported",
    Status.NON_MONOTONE: "in which the rate falls with rising level by more than chance",
    Status.TOO_FEW_LEVELS: "with fewer than three levels",
    Status.NO_DATA: "without trials at any level",
}


def warnings_of(analysis: Analysis) -> tuple[str, ...]:
    """Return all warnings in the order of the report."""
    trials, estimates, resolutions = analysis.trials, analysis.table("thresholds"), analysis.table(OF_PARTICIPANTS)
    warnings = [*analysis.origin.warnings, *trials.notes]
    warnings += _exclusion_warnings(analysis.table("excluded"))
    warnings += _unused_warnings(trials)
    for outcome in analysis.outcomes:
        if outcome.task in RESULTS:  # tasks without a psychometric function
            warnings += _missing_cells(outcome.estimates, outcome.factors)
    warnings += _curve_warnings(analysis, estimates) if len(estimates) else ()
    warnings += _other_tasks(trials)
    warnings += _unanswered_forms(trials)
    warnings += _quality_warnings(analysis.tables["quality"])
    warnings += _practice_warnings(analysis)
    warnings += goodness_warnings(estimates, trials.factors) if len(estimates) else ()
    warnings += goodness_warnings(resolutions, conditions_of_fits(resolutions)) if len(resolutions) else ()
    return tuple(warnings)


def _exclusion_warnings(excluded: pd.DataFrame) -> Iterator[str]:
    for rule, lost in excluded.groupby("rule", sort=False) if len(excluded) else ():
        numbers = ", ".join(f"{row.participant} {row.n_trials}" for row in lost.itertuples(index=False))
        yield f"excluded by the rule {rule} = {lost['bound'].iloc[0]:g} (numbers of trials): {numbers}"


def _curve_warnings(analysis: Analysis, estimates: pd.DataFrame) -> Iterator[str]:
    factors = analysis.factors
    yield from _missing_cells(estimates, factors)
    few = f"with fewer than {FEW_TRIALS} trials: the priors strongly influence these intervals"
    kinds = [(text, estimates["status"] == status.value) for status, text in STATUS_WORDS.items()]
    for text, concerned in (*kinds, (few, estimates["n_trials"] < FEW_TRIALS)):
        if concerned.any():
            cells = estimates[concerned]
            yield f"{len(cells)} of {len(estimates)} cells {text} ({named_cells(cells, factors)})"
    yield from floor_warnings(analysis.table(FLOORS), factors)
    yield from lapse_warnings(analysis.table(LAPSES), factors)
    for task, n_catch in estimates.groupby("task", sort=False)["n_catch"]:
        if CURVES[str(task)].counts_catch and not n_catch.sum():
            yield f"no catch trials in the task {task}: only the prior determines the guess rate"
    yield from _alternatives_warnings(analysis)


def _missing_cells(table: pd.DataFrame, factors: Sequence[str]) -> Iterator[str]:
    """Warn about conditions that only some participants have, by task."""
    for task, of_task in table.groupby("task", sort=False):
        # Ignore factors that vary only between participants.
        inside = [name for name in factors if of_task.groupby("participant")[name].nunique().max() > 1]
        keys = ["participant", *inside]
        whole = of_task[["participant"]].drop_duplicates().merge(of_task[inside].drop_duplicates(), how="cross")
        held = whole.merge(of_task[keys].drop_duplicates(), how="left", indicator=True)
        lost = held[held["_merge"] == "left_only"].sort_values(keys)
        if len(lost):
            yield f"{len(lost)} of {len(held)} cells of {task} have no valid trial ({named_cells(lost, inside)})"


def _unused_warnings(trials: Trials) -> Iterator[str]:
    """Warn about participants and forced choices without a usable answer."""
    used = used_rows(trials)
    lost = sorted(set(trials.rows["participant"].unique()) - set(used["participant"].unique()))
    if lost:
        yield f"no valid answers, and therefore no results, of {first_named(lost)}"
    choices = used[used["task"].isin(CHOICES)]
    unknown = choices[correctness(choices).isna()]
    if len(unknown):
        first = unknown.iloc[0]
        yield (
            f"{count_of(len(unknown), 'row')} of a forced choice with neither 'correct' nor 'target' left out (the "
            f"first: {Path(str(first['source'])).name}, row {first['row']})"
        )


def _alternatives_warnings(analysis: Analysis) -> Iterator[str]:
    """Warn if the number of alternatives is inferred, or differs by condition."""
    result, columns = analysis.n_choices, analysis.trials.rows.columns
    if not result or STATED in columns:
        return
    if "target" not in columns:
        numbers = " and ".join(map(str, result))
        yield f"no column 'target' in a forced choice: {numbers} alternatives were inferred from the answers"
    if len(result) > 1:
        conditions = {n: ", ".join(" ".join(map(str, one)) for one in each) for n, each in result.items()}
        named = "; ".join(f"{n}: {text}" for n, text in conditions.items())
        yield (
            "according to their answers, conditions of the forced choice differ in the number of alternatives "
            f"({named}). If this is wrong, set {STATED!r} in a column map"
        )


def _other_tasks(trials: Trials) -> Iterator[str]:
    rows = trials.rows
    known = rows["task"].isin((*CURVES, *RESULTS))
    if "procedure" in rows.columns:
        forms = [*forms_of(trials.path), *choices_of(trials.path)]
        known |= (rows["task"] == FORM_TASK) & rows["procedure"].isin(forms)
    other = rows[~known]
    if len(other):
        yield f"rows of other tasks, not analysed: {len(other)} ({', '.join(sorted(other['task'].unique()))})"


def _unanswered_forms(trials: Trials) -> Iterator[str]:
    for form, rows in asked_forms(trials):
        if (rows["response"] == "").all():
            who = count_of(rows["participant"].nunique(), "participant")
            yield f"{form.title}: none of {who} answered, so there is no score"


def _quality_warnings(quality: pd.DataFrame) -> Iterator[str]:
    many = quality[quality["false_alarm_rate"] > MANY_FALSE_ALARMS]
    if len(many):
        of_participants = zip(many["participant"], many["false_alarm_rate"], strict=True)
        rates = ", ".join(f"{code} {percent_text(rate)}" for code, rate in of_participants)
        yield f"more than {percent_text(MANY_FALSE_ALARMS)} false alarms in catch trials: {rates}"
    if "n_dropped_frames" in quality.columns:
        frames = quality.assign(n_due=quality["n_frames"] + quality["n_dropped_frames"])
        lost = frames[frames["n_dropped_frames"] > MANY_DROPPED * frames["n_due"]]
        numbers = ", ".join(f"{row.participant} {row.n_dropped_frames} of {row.n_due}" for row in lost.itertuples())
        if numbers:
            yield f"more than {percent_text(MANY_DROPPED)} of screen frames dropped: {numbers}"
    invalid = quality[quality["n_invalid"] > MANY_INVALID * quality["n_rows"]]
    if len(invalid):
        yield f"more than {percent_text(MANY_INVALID)} invalid trials: {', '.join(invalid['participant'])}"


def _practice_warnings(analysis: Analysis) -> Iterator[str]:
    """Warn about missed practice criteria, and list the decisions."""
    quality, events = analysis.tables["quality"], analysis.table("happenings")
    if "practice_missed" in quality.columns and quality["practice_missed"].any():
        missed = quality.loc[quality["practice_missed"] == 1, "participant"]
        yield f"practice criterion not met: {', '.join(missed)}"
    if len(events):
        answers = events[events["text"].str.startswith(PRACTICE_MISSED)]
        chosen = answers["text"].str.removeprefix(PRACTICE_MISSED).groupby(answers["participant"]).agg(", ".join)
        if len(chosen):
            choices = "; ".join(f"{participant} {words}" for participant, words in chosen.items())
            yield f"decision of the experimenter after missed practice criterion: {choices}"
