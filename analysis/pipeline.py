"""Analysis of a data set from trials to report."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from tactometry.arguments.require import expect
from tactometry.errors import InvalidFile

from .outcomes.categories import categories
from .outcomes.findings import Outcome
from .outcomes.hierarchical_outcome import HierarchicalOutcome, group_fit
from .outcomes.outcome import outcome
from .outcomes.ratings import ratings
from .plan import AnalysisPlan, plan_of
from .reading.column_map import ColumnMap
from .reading.course import happenings, sittings
from .reading.origin import of_one_kind
from .reading.quality import exclude, frames, quality, with_frames
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
UNSCORED = "; a forced choice needs a column 'correct' or 'target'"
NOTHING = (
    f"no valid answer of a task ({', '.join((*CURVES, *RESULTS))}) nor to a known questionnaire, expected some to "
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
        HTML file to write; its tables go into the folder ``<name>_tables``.
    pdf : bool
        Also print the report to ``<name>.pdf`` with an installed browser or WeasyPrint.
    within : str or sequence of str, optional
        Factors; by default the columns between ``trial`` and ``procedure``.
    column_map : ColumnMap, optional
        Names of a foreign table's columns.
    level_scale : str, optional
        ``linear``, ``log10`` or ``db``: axis of the fits; by default that of the map, else linear.
    plan : AnalysisPlan, optional
        Exclusions and equivalence bounds; by default those in ``[analysis]`` of the data set's study.
    figures : str or Path, optional
        Folder for every figure as SVG and as PNG at 300 dots per inch.
    warnings : sequence of str
        Further warnings, listed first.
    replay : callable, optional
        Estimates of the procedure that chose the levels of a block; by default the mean of staircase reversals.
    touches : callable, optional
        Returns percentiles of force and speed by participant, quantity, target and time from onset.
    spread : callable
        Distributes the drawing of figures, as `map` does in this process.

    Raises
    ------
    InvalidFile, InvalidParameter
        If the table cannot be read or contains nothing to analyse.
    DeviceFailed
        If the report cannot be written or printed.
    """
    path = Path(path)
    expect(report is not None or not pdf, "--pdf", "no --report", "one: the PDF is printed from it")
    if report is not None:
        check_report(Path(report))  # before the analysis, which may take minutes

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
    """Analyse a trials table without writing anything."""
    plan = plan or AnalysisPlan()
    plan.check(everything.factors)
    everything, origin = of_one_kind(everything)
    recorded = quality(everything)
    trials, excluded = exclude(everything, plan.exclusion, recorded)

    answers = _answers(everything, trials)
    forms, direct = ratings(trials, plan.primary), _direct_tables(answers.used, trials.factors)
    if not (answers.cells or forms or direct):
        is_choice = used_rows(everything)["task"].isin(counting.CHOICES).any()
        raise InvalidFile(f"{trials.path}: found {NOTHING}{UNSCORED if is_choice else ''}")

    unit = counting.level_unit(trials)
    fits = counting.estimates(answers.cells, unit)
    thresholds = _threshold_table(answers, fits, trials.factors, unit, replay)
    forces = force_of_participants(answers.used, trials.factors) if has_force(answers.used) else None

    outcomes = tuple(_outcomes(thresholds, direct, trials.factors, plan, forces))
    hierarchical = tuple(_hierarchical(fits, trials.factors, unit)) if plan.hierarchical else ()
    study = study_text(trials.path, unit)
    analysis = Analysis(trials, unit, tuple(fits), outcomes, {}, (), "", hierarchical, forms, plan, origin, study)

    tables = {"quality": with_frames(recorded, frames(trials.path)), "excluded": excluded, **direct}
    tables |= _curve_tables(answers, fits, thresholds, trials.factors) | _compared_tables(analysis)
    if forces is not None:
        tables |= {"force_participants": forces, "force": force_table(forces, trials.factors)}
    jnds = next((outcome.group for outcome in outcomes if outcome.dependent == "jnd"), None)
    tables[TESTS] = standard_tests(thresholds, answers.used, trials.factors, jnds)
    tables |= {"categories": categories(trials), "sittings": sittings(origin.heads)}
    tables["happenings"] = happenings(trials.path)
    analysis = replace(analysis, tables={name: table for name, table in tables.items() if len(table)})
    return replace(analysis, warnings=warnings_of(analysis), methods=methods(analysis))


@dataclass(frozen=True)
class CountedAnswers:
    """Used rows, and rows of tasks with a curve with their cells.

    `all_judged` includes the rows that the plan excludes.
    """

    used: pd.DataFrame
    judged: pd.DataFrame
    all_judged: pd.DataFrame
    cells: list[Cell]


def _answers(everything: Trials, trials: Trials) -> CountedAnswers:
    all_used = used_rows(everything)
    all_judged = counting.judgements(all_used)
    used, judged = (rows[rows.index.isin(trials.rows.index)] for rows in (all_used, all_judged))
    return CountedAnswers(used, judged, all_judged, counting.cells(counting.counted_answers(judged), trials.factors))


def _direct_tables(used: pd.DataFrame, factors: Sequence[str]) -> Tables:
    """Return the tables of each task without a curve."""
    rows_of = dict(iter(used.groupby("task")))
    tables: Tables = {}
    for task in (task for task in RESULTS if task in rows_of):
        tables |= {name: table_of(rows_of[task], factors) for name, table_of in RESULTS[task].tables.items()}
    return {name: table for name, table in tables.items() if len(table)}


def _threshold_table(
    answers: CountedAnswers, fits: Sequence[Estimate], factors: Sequence[str], unit: str, replay: Replay | None
) -> pd.DataFrame:
    """Return all fits with goodness of fit and the procedures' estimates."""
    table = counting.estimate_table(fits, factors, unit)
    if table.empty:
        return table
    # The procedure saw all answers, including excluded ones.
    table = table.join(rule_columns(counting.counted_answers(answers.all_judged), factors, fits, replay))
    options = {(task, n): CURVES[task].options(n, unit) for task, n in counting.curves_of(answers.cells)}
    judged, rng = counting.counted_answers(answers.judged), np.random.default_rng(SEED)
    return table.join(goodness_columns(judged, factors, fits, options, rng, counting.COUNTING))


def _outcomes(
    thresholds: pd.DataFrame,
    direct: Tables,
    factors: Sequence[str],
    plan: AnalysisPlan,
    forces: pd.DataFrame | None,
) -> Iterator[Outcome]:
    """Compare the conditions in each dependent value of each task."""
    tables = dict(direct)
    if len(thresholds):
        tables |= {str(task): rows for task, rows in thresholds.groupby("task")}
    for task in (task for task in ANALYSES if task in tables):
        results = RESULTS.get(task, Results({}))
        compared = tables[results.compared or task]
        conditions = [name for name in (*factors, *results.further) if name in compared.columns]
        of_forces = forces if set(conditions) == set(factors) else None  # known only by the factors
        bounds = plan.equivalence if results.in_levels else {}  # in the unit of the levels
        for dependent in ANALYSES[task].dependents:
            yield outcome(compared, conditions, task, dependent, forces=of_forces, bounds=bounds, primary=plan.primary)


def _hierarchical(estimates: Sequence[Estimate], factors: Sequence[str], unit: str) -> Iterator[HierarchicalOutcome]:
    for task in CURVES:
        fits = {estimate.cell: estimate.fit for estimate in estimates if estimate.cell.task == task}
        fit = group_fit(list(fits), factors, unit, fits) if fits else None
        if fit is not None:
            yield fit


def _curve_tables(
    answers: CountedAnswers, fits: Sequence[Estimate], thresholds: pd.DataFrame, factors: Sequence[str]
) -> Tables:
    if not fits:
        return {}
    counts = counting.count_table(answers.cells, factors)
    return {
        "thresholds": thresholds,
        "goodness": goodness_table(thresholds),
        "rates": counting.detection_rates(counts, factors),
        "mean_rates": counting.mean_rates(counts, factors),
        "counts": counts,
        "tracks": tracks(answers.judged, factors),
        FLOORS: lowest_levels(answers.cells, factors),
        LAPSES: lapse_table(fits, factors),
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
