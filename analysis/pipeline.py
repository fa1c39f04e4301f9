"""Analysis of a data set in five stages."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from tactometry.arguments.require import expect
from tactometry.errors import InvalidFile

from .outcomes.findings import Outcome
from .outcomes.hierarchical_outcome import HierarchicalOutcome, group_fit
from .outcomes.outcome import outcome
from .outcomes.ratings import Ratings, categories, ratings
from .plan import AnalysisPlan, plan_of
from .reading.column_map import ColumnMap
from .reading.origin import Origin, of_one_kind
from .reading.quality import exclude, frames, happenings, quality, sittings, with_frames
from .reading.trials import Trials, read_trials, used_rows
from .report.data_warnings import warnings_of
from .report.methods import methods
from .report.page import DrawEach, check_report, draw_figures, write_report
from .report.study_text import study_text
from .result import Analysis
from .tasks import cells as counting
from .tasks.applied_force import force_of_participants, force_table, has_force
from .tasks.cell import Cell, Estimate
from .tasks.goodness import SEED, goodness_columns, goodness_table
from .tasks.kinds import ANALYSES, CURVES, RESULTS
from .tasks.lapses import LAPSES, lapse_table
from .tasks.rule_estimate import Replay, rule_columns, tracks
from .tasks.standard import FLOORS, TESTS, lowest_levels, standard_tests
from .tasks.task_analysis import Results

Tables = dict[str, pd.DataFrame]
UNSCORED = "; forced choices need a column 'correct' or 'target'"
NOTHING = (
    f"no valid answer to a task ({', '.join((*CURVES, *RESULTS))}) or a known questionnaire, expected answers to "
    "analyse"
)


def analyse(
    path: str | Path,
    *,
    report: str | Path | None = None,
    pdf: bool = False,
    within: Sequence[str] | str | None = None,
    column_map: ColumnMap | None = None,
    level_scale: str | None = None,
    plan: AnalysisPlan | None = None,
    figures: str | Path | None = None,
    warnings: Sequence[str] = (),
    replay: Replay | None = None,
    touches: Callable[[], pd.DataFrame] | None = None,
    spread: DrawEach = map,
) -> Analysis:
    """Analyse a data set or a trials file, and write its report and figures.

    Parameters
    ----------
    path : str or Path
        Data set folder or CSV file of trials.
    report : str or Path, optional
        HTML file to write. The tables are written to the folder ``<name>_tables``.
    pdf : bool
        Also print the report to ``<name>.pdf`` with an installed browser or WeasyPrint.
    within : str or sequence of str, optional
        Factors; by default the columns between ``trial`` and ``procedure``.
    column_map : ColumnMap, optional
        Translation of the columns of another program's tables.
    level_scale : str, optional
        Axis of the fits: ``linear``, ``log10`` or ``db``. The default is that of the map, or else linear.
    plan : AnalysisPlan, optional
        Exclusions, equivalence bounds and primary analysis. The default is ``[analysis]`` in the data set's study.
    figures : str or Path, optional
        Folder to which every figure is written as SVG and as PNG at 300 dots per inch.
    warnings : sequence of str
        Additional warnings, listed before all others.
    replay : callable, optional
        Returns the threshold estimate of the procedure that chose the levels of a block. The default is the mean of
        staircase reversals.
    touches : callable, optional
        Returns percentiles of force and speed by participant, quantity, target and time from stimulus onset.
    spread : callable
        Replacement for `map` that draws figures in parallel.

    Raises
    ------
    InvalidFile, InvalidParameter
        If the table cannot be read or contains nothing to analyse.
    DeviceFailed
        If the report cannot be written or printed.
    """
    path = Path(path)
    expect(report is not None or not pdf, "--pdf", "no --report", "--report FILE.html, from which the PDF is printed")
    if report is not None:
        check_report(Path(report))  # fail before the analysis, which may take minutes

    trials = read_trials(path, within=within, column_map=column_map, level_scale=level_scale)
    trials = replace(trials, notes=(*warnings, *trials.notes))
    analysis = analyse_trials(trials, plan or plan_of(path), replay if level_scale in (None, "linear") else None)
    if report is None and figures is None:
        return analysis

    if touches is not None and len(courses := touches()):
        analysis = replace(analysis, tables={**analysis.tables, "touches": courses})
    folder = None if figures is None else Path(figures)
    svgs = draw_figures(analysis, spread, folder)
    analysis = replace(analysis, figures_folder=folder)
    return analysis if report is None else write_report(analysis, report, pdf=pdf, svgs=svgs)


def analyse_trials(everything: Trials, plan: AnalysisPlan | None = None, replay: Replay | None = None) -> Analysis:
    """Analyse a trials table without writing files."""
    trials = select_trials(everything, plan or AnalysisPlan())
    cells = count_cells(trials)
    estimates = estimate_cells(cells, replay)
    outcomes = compare_conditions(estimates)
    return report_outcomes(outcomes)


@dataclass(frozen=True)
class SelectedTrials:
    """Stage 1: included trials, and `everything` including excluded trials."""

    everything: Trials
    trials: Trials
    plan: AnalysisPlan
    origin: Origin
    quality: pd.DataFrame
    excluded: pd.DataFrame


def select_trials(everything: Trials, plan: AnalysisPlan) -> SelectedTrials:
    """Apply the plan's exclusions."""
    plan.check(everything.factors)
    everything, origin = of_one_kind(everything)
    recorded = quality(everything)
    trials, excluded = exclude(everything, plan.exclusion, recorded)
    return SelectedTrials(everything, trials, plan, origin, recorded, excluded)


@dataclass(frozen=True)
class Cells:
    """Stage 2: answers counted by participant and condition.

    `judged` contains the rows of tasks with a psychometric function, `all_judged` also the rows that the plan excludes.
    `direct` contains the tables of tasks without a psychometric function.
    """

    selected: SelectedTrials
    used: pd.DataFrame
    judged: pd.DataFrame
    all_judged: pd.DataFrame
    cells: list[Cell]
    direct: Tables
    forms: tuple[Ratings, ...]

    @property
    def factors(self) -> tuple[str, ...]:
        return self.selected.trials.factors


def count_cells(selected: SelectedTrials) -> Cells:
    """Count answers by participant and condition; score questionnaires.

    Raises `InvalidFile` if there is nothing to analyse.
    """
    trials = selected.trials
    all_used = used_rows(selected.everything)
    all_judged = counting.judgements(all_used)
    used, judged = (rows[rows.index.isin(trials.rows.index)] for rows in (all_used, all_judged))
    result = counting.cells(counting.counted_answers(judged), trials.factors)
    rows_of = dict(iter(used.groupby("task")))
    tables: Tables = {}
    for task in (task for task in RESULTS if task in rows_of):
        tables |= {name: table_of(rows_of[task], trials.factors) for name, table_of in RESULTS[task].tables.items()}
    direct = {name: table for name, table in tables.items() if len(table)}
    forms = ratings(trials, selected.plan.primary)
    if not (result or forms or direct):
        why = UNSCORED if all_used["task"].isin(counting.CHOICES).any() else ""
        raise InvalidFile(f"{trials.path}: found {NOTHING}{why}")
    return Cells(selected, used, judged, all_judged, result, direct, forms)


@dataclass(frozen=True)
class CellEstimates:
    """Stage 3: fits of cells, and their `table` with goodness of fit."""

    cells: Cells
    fits: list[Estimate]
    table: pd.DataFrame
    unit: str
    forces: pd.DataFrame | None


def estimate_cells(cells: Cells, replay: Replay | None) -> CellEstimates:
    """Fit a psychometric function to each cell, and average the force."""
    factors, unit = cells.factors, counting.level_unit(cells.selected.trials)
    fits = counting.estimates(cells.cells, unit)
    table = counting.estimate_table(fits, factors, unit)
    if len(table):
        # The procedure used all answers, including excluded ones.
        table = table.join(rule_columns(counting.counted_answers(cells.all_judged), factors, fits, replay))
        options = {(task, n): CURVES[task].options(n, unit) for task, n in counting.curves_of(cells.cells)}
        answers, rng = counting.counted_answers(cells.judged), np.random.default_rng(SEED)
        table = table.join(goodness_columns(answers, factors, fits, options, rng, counting.COUNTING))
    forces = force_of_participants(cells.used, factors) if has_force(cells.used) else None
    return CellEstimates(cells, fits, table, unit, forces)


@dataclass(frozen=True)
class Outcomes:
    """Stage 4: comparisons of conditions, and hierarchical fits."""

    estimates: CellEstimates
    outcomes: tuple[Outcome, ...]
    hierarchical: tuple[HierarchicalOutcome, ...]


def compare_conditions(estimates: CellEstimates) -> Outcomes:
    """Compare the conditions for each dependent variable of each task."""
    is_planned = estimates.cells.selected.plan.hierarchical
    return Outcomes(estimates, tuple(_outcomes(estimates)), tuple(_hierarchical(estimates)) if is_planned else ())


def _outcomes(estimates: CellEstimates) -> Iterator[Outcome]:
    plan, factors = estimates.cells.selected.plan, estimates.cells.factors
    tables = dict(estimates.cells.direct)
    if len(estimates.table):
        tables |= {str(task): rows for task, rows in estimates.table.groupby("task")}
    for task in (task for task in ANALYSES if task in tables):
        results = RESULTS.get(task, Results({}))
        compared = tables[results.compared or task]
        conditions = [name for name in (*factors, *results.further) if name in compared.columns]
        # forces are known only by the factors of the study
        forces = estimates.forces if set(conditions) == set(factors) else None
        bounds = plan.equivalence if results.in_levels else {}  # bounds are in the unit of the levels
        for dependent in ANALYSES[task].dependents:
            yield outcome(compared, conditions, task, dependent, forces=forces, bounds=bounds, primary=plan.primary)


def _hierarchical(estimates: CellEstimates) -> Iterator[HierarchicalOutcome]:
    for task in CURVES:
        fits = {estimate.cell: estimate.fit for estimate in estimates.fits if estimate.cell.task == task}
        fit = group_fit(list(fits), estimates.cells.factors, estimates.unit, fits) if fits else None
        if fit is not None:
            yield fit


def report_outcomes(outcomes: Outcomes) -> Analysis:
    """Stage 5: collect all tables, warnings and the methods text."""
    estimates, cells = outcomes.estimates, outcomes.estimates.cells
    selected = cells.selected
    analysis = Analysis(
        trials=selected.trials,
        unit=estimates.unit,
        estimates=tuple(estimates.fits),
        outcomes=outcomes.outcomes,
        hierarchical=outcomes.hierarchical,
        forms=cells.forms,
        plan=selected.plan,
        tables={},
        origin=selected.origin,
        study=study_text(selected.everything.path, estimates.unit),
    )
    path = selected.everything.path
    tables = {"quality": with_frames(selected.quality, frames(path)), "excluded": selected.excluded, **cells.direct}
    tables |= _curve_tables(estimates) | _compared_tables(analysis)
    if estimates.forces is not None:
        tables |= {"force_participants": estimates.forces, "force": force_table(estimates.forces, cells.factors)}
    jnds = next((one.group for one in outcomes.outcomes if one.dependent == "jnd"), None)
    tables[TESTS] = standard_tests(estimates.table, cells.used, cells.factors, jnds)
    tables |= {"categories": categories(selected.trials), "sittings": sittings(selected.origin.heads)}
    tables["happenings"] = happenings(path)
    analysis = replace(analysis, tables={name: rows for name, rows in tables.items() if len(rows)})
    return replace(analysis, warnings=warnings_of(analysis), methods=methods(analysis))


def _curve_tables(estimates: CellEstimates) -> Tables:
    cells, factors = estimates.cells, estimates.cells.factors
    if not estimates.fits:
        return {}
    counts = counting.count_table(cells.cells, factors)
    return {
        "thresholds": estimates.table,
        "goodness": goodness_table(estimates.table),
        "rates": counting.detection_rates(counts, factors),
        "mean_rates": counting.mean_rates(counts, factors),
        "counts": counts,
        "tracks": tracks(cells.judged, factors),
        FLOORS: lowest_levels(cells.cells, factors),
        LAPSES: lapse_table(estimates.fits, factors),
    }


def _compared_tables(analysis: Analysis) -> Tables:
    tables: Tables = {}
    for compared in analysis.outcomes:
        tables |= compared.tables(analysis.stem(compared))
    for fit in analysis.hierarchical:
        tables |= fit.tables(fit.task)
    for form in analysis.forms:
        tables |= form.tables()
    return tables
