"""From a path to tables, warnings and a report: what `tactometry analyse` and `tactometry demo` call."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from tactometry.errors import InvalidFile, InvalidParameter

from .outcomes.findings import Outcome
from .outcomes.hierarchical_outcome import HierarchicalOutcome, together
from .outcomes.outcome import outcome
from .outcomes.ratings import Ratings, ratings
from .plan import AnalysisPlan, plan_of
from .reading.column_map import ColumnMap
from .reading.exclusion import exclude
from .reading.origin import of_one_kind
from .reading.quality import frames, quality, with_frames
from .reading.study_text import study_text
from .reading.trials import Trials, read_trials
from .report import data_warnings
from .report.methods import methods
from .result import Analysis
from .tasks import adjustment, cells, magnitude
from .tasks.applied_force import force_of_participants, force_table, has_force
from .tasks.goodness import SEED, goodness_columns, goodness_table, goodness_warnings
from .tasks.measurement import loss_table, losses
from .tasks.preference import preference_table
from .tasks.rates import detection_rates, mean_rates
from .tasks.rule_estimate import Replay, rule_columns
from .tasks.same_different import same_different_table
from .tasks.tracks import tracks

OUTCOMES = {
    "yes_no": ("threshold",),
    "forced_choice": ("threshold",),
    "comparison": ("pse", "jnd"),
}
DIRECT = {adjustment.TASK: adjustment.DEPENDENT, magnitude.TASK: magnitude.DEPENDENT}
"""Tasks whose answers are estimates: what stands in the table of participants for the value."""


def analyse(
    path: Path,
    *,
    report: Path | None = None,
    pdf: bool = False,
    within: Sequence[str] | None = None,
    column_map: ColumnMap | None = None,
    level_scale: str | None = None,
    plan: AnalysisPlan | None = None,
    figures: Path | None = None,
    warnings: Sequence[str] = (),
    replay: Replay | None = None,
) -> Analysis:
    """Analyse a data set's folder or a trials file; write the report and its tables if `report` names a file.

    Parameters
    ----------
    path : Path
        Data set or CSV file of trials.
    report : Path, optional
        An HTML file to write; the tables go into the folder ``<name>_tables`` beside it.
    pdf : bool
        Also print the report to ``<name>.pdf`` through an installed browser or WeasyPrint.
    within : sequence of str, optional
        Factors, or none where it is empty; by default the columns between ``trial`` and ``procedure``.
    column_map : ColumnMap, optional
        How a foreign table's columns are called.
    level_scale : str, optional
        ``linear``, ``log10`` or ``db``: the axis on which levels are fitted; by default that of the map, else linear.
    plan : AnalysisPlan, optional
        What is left out, and which differences count as none, stated before the data; by default what the study of
        the data set states in its table ``[analysis]``.
    figures : Path, optional
        A folder for every figure as SVG and, at 300 dots per inch, PNG.
    warnings : sequence of str
        What is known of the data beside the table; it stands before the other warnings.
    replay : callable, optional
        What the rule that chose the levels makes of the answers of a block (`rule_estimate.Replay`); without it
        only the reversals of staircases are known.

    Raises
    ------
    InvalidFile, InvalidParameter
        If the table cannot be read or holds nothing to analyse.
    DeviceFailed
        If the report cannot be written, or nothing prints it.
    """
    if report is None and pdf:
        raise InvalidParameter("--pdf: found no --report, expected one: the PDF is printed from it")
    if report is not None:
        from .report.page import check_report

        check_report(report)
    trials = read_trials(path, within=within, column_map=column_map, level_scale=level_scale)
    found = analysed(
        replace(trials, notes=(*warnings, *trials.notes)),
        plan or plan_of(path),
        replay if level_scale in (None, "linear") else None,
    )
    if report is None and figures is None:
        return found
    from .report.page import write_figures, write_report

    if figures is not None:
        found = write_figures(found, figures)
    return found if report is None else write_report(found, report, pdf=pdf)


def analysed(everything: Trials, plan: AnalysisPlan | None = None, replay: Replay | None = None) -> Analysis:
    """All estimates, tables and warnings of a trials table; nothing is written."""
    plan = plan or AnalysisPlan()
    plan.check(everything.factors)
    everything, origin = of_one_kind(everything)
    recorded = quality(everything)
    trials, excluded = exclude(everything, plan.exclusion, recorded)
    found, forms, lost = cells.cells(trials), ratings(trials, plan.primary), losses(trials)
    choices = _choice_tables(trials)
    if not found and not forms and not choices and lost.empty:
        raise InvalidFile(
            f"{trials.path}: found no valid answer of a yes/no, forced-choice, comparison, same-different, preference, "
            "adjustment or magnitude task nor to a known questionnaire, and no measured level, expected some to analyse"
        )
    unit, n_choices = cells.level_unit(trials), cells.n_alternatives(trials)
    estimates = cells.estimates(found, n_choices, unit)
    table = cells.estimate_table(estimates, trials.factors, unit)
    if len(table):
        table = table.join(rule_columns(everything, estimates, replay))
        table = table.join(goodness_columns(trials, estimates, n_choices, unit, np.random.default_rng(SEED)))
    forces = force_of_participants(trials) if has_force(trials) else None
    outcomes = tuple(
        outcome(
            values, trials.factors, task, dependent, forces=forces, bounds=_bounds(plan, task), primary=plan.primary
        )
        for task, dependent, values in _dependents(table, choices)
    )
    by_task = [[cell for cell in found if cell.task == task] for task in OUTCOMES if plan.hierarchical]
    fits = tuple(
        fit for part in by_task if part and (fit := together(part, trials.factors, n_choices, unit)) is not None
    )
    recorded = with_frames(recorded, frames(everything.path))
    return Analysis(
        trials=trials,
        unit=unit,
        estimates=tuple(estimates),
        outcomes=outcomes,
        together=fits,
        forms=forms,
        plan=plan,
        tables=_tables(table, outcomes, found, trials, recorded)
        | _together_tables(fits)
        | choices
        | _other_tables(forms, forces, trials.factors, excluded)
        | _growth(trials)
        | ({} if lost.empty else {"loss_participants": lost, "loss": loss_table(lost, trials.factors)}),
        origin=origin,
        study=study_text(everything.path, unit),
        warnings=(
            *origin.warnings,
            *trials.notes,
            *data_warnings.exclusion_warnings(excluded),
            *_missing(choices, trials.factors),
            *data_warnings.warnings(trials, table, recorded, n_choices),
            *(goodness_warnings(table, trials.factors) if len(table) else []),
        ),
        methods=origin.method
        + methods(
            table,
            n_choices,
            forms,
            plan,
            is_hierarchical=any(each.fit for each in fits),
            choices=tuple(choices),
            outcomes=outcomes,
            procedures=set(trials.rows["procedure"]) if "procedure" in trials.rows.columns else (),
        ),
    )


def _dependents(table: pd.DataFrame, choices: Mapping[str, pd.DataFrame]) -> Iterator[tuple[str, str, pd.DataFrame]]:
    """Each task with a dependent value of its own, and the rows that hold it."""
    for task, dependents in OUTCOMES.items():
        if len(table) and (table["task"] == task).any():
            yield from ((task, dependent, table[table["task"] == task]) for dependent in dependents)
    yield from ((task, dependent, choices[task]) for task, dependent in DIRECT.items() if task in choices)


def _missing(choices: Mapping[str, pd.DataFrame], factors: Sequence[str]) -> Iterator[str]:
    """What is to be said of cells without a value, of tasks that are analysed directly."""
    for task in DIRECT:
        if task in choices:
            yield from data_warnings.missing_cells(choices[task], factors)


def _bounds(plan: AnalysisPlan, task: str) -> Mapping[str, float]:
    """The differences that count as none, which are in the unit of the levels."""
    return {} if task == magnitude.TASK else plan.equivalence


def _other_tables(
    forms: Sequence[Ratings], forces: pd.DataFrame | None, factors: Sequence[str], excluded: pd.DataFrame
) -> dict[str, pd.DataFrame]:
    found: dict[str, pd.DataFrame] = {}
    for form in forms:
        found |= form.tables()
    if forces is not None:
        found |= {"force_participants": forces, "force": force_table(forces, factors)}
    return found | ({"excluded": excluded} if len(excluded) else {})


def _choice_tables(trials: Trials) -> dict[str, pd.DataFrame]:
    found = {
        "same_different": same_different_table(trials),
        "preference": preference_table(trials),
        adjustment.TASK: adjustment.adjustment_table(trials),
        magnitude.TASK: magnitude.magnitude_table(trials),
    }
    return {name: table for name, table in found.items() if len(table)}


def _growth(trials: Trials) -> dict[str, pd.DataFrame]:
    table = magnitude.growth_table(trials)
    return {magnitude.GROWTH: table} if len(table) else {}


def _together_tables(fits: Sequence[HierarchicalOutcome]) -> dict[str, pd.DataFrame]:
    return {name: table for each in fits for name, table in each.tables(each.task).items()}


def _tables(
    table: pd.DataFrame,
    outcomes: Sequence[Outcome],
    found: Sequence[cells.Cell],
    trials: Trials,
    recorded: pd.DataFrame,
) -> dict[str, pd.DataFrame]:
    tables = _fit_tables(table, found, trials) | {"quality": recorded}
    several = len({o.task for o in outcomes}) > 1
    for each in outcomes:
        tables |= each.tables(f"{each.task}_{each.dependent}" if several else each.dependent)
    return {name: part for name, part in tables.items() if len(part)}


def _fit_tables(table: pd.DataFrame, found: Sequence[cells.Cell], trials: Trials) -> dict[str, pd.DataFrame]:
    if not found:
        return {}
    return {
        "thresholds": table,
        "goodness": goodness_table(table),
        "rates": detection_rates(found, trials.factors),
        "mean_rates": mean_rates(found, trials.factors),
        "counts": cells.count_table(found, trials.factors),
        "tracks": tracks(trials),
    }
