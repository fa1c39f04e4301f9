"""From a path to tables, warnings and a report: what `tactometry analyse` and `tactometry demo` call."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
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
from .report.page import DrawEach, check_report, draw_figures, figures_of, sections_of, write_figures, write_report
from .report.study_text import study_text
from .result import Analysis
from .tasks import cells
from .tasks.applied_force import force_of_participants, force_table, has_force
from .tasks.cell import Estimate
from .tasks.goodness import SEED, goodness_columns, goodness_table
from .tasks.kinds import ANALYSES, CURVES, RESULTS
from .tasks.lapses import LAPSES, lapse_table
from .tasks.rule_estimate import Replay, rule_columns, tracks
from .tasks.standard import FLOORS, TESTS, lowest_levels, standard_tests
from .tasks.task_analysis import Results


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
    """Analyse a data set's folder or a trials file; write the report and its tables if `report` names a file.

    Parameters
    ----------
    path : str or Path
        Data set or CSV file of trials.
    report : str or Path, optional
        An HTML file to write; the tables go into the folder ``<name>_tables`` beside it.
    pdf : bool
        Also print the report to ``<name>.pdf`` through an installed browser or WeasyPrint.
    within : str or sequence of str, optional
        Factors, or none where it is empty; by default the columns between ``trial`` and ``procedure``.
    column_map : ColumnMap, optional
        How a foreign table's columns are called.
    level_scale : str, optional
        ``linear``, ``log10`` or ``db``: the axis on which levels are fitted; by default that of the map, else linear.
    plan : AnalysisPlan, optional
        What is left out, and which differences count as none, stated before the data; by default what the study of
        the data set states in its table ``[analysis]``.
    figures : str or Path, optional
        A folder for every figure as SVG and, at 300 dots per inch, PNG.
    warnings : sequence of str
        What is known of the data beside the table; it stands before the other warnings.
    replay : callable, optional
        What the rule that chose the levels makes of the answers of a block (`rule_estimate.Replay`); without it
        only the reversals of staircases are known.
    touches : callable, optional
        Gives the courses of force and speed over the touches, for a report or figures: a row for each participant,
        quantity, target and time from the onset, with percentiles.
    spread : callable
        Distributes the drawing of figures, as `map` does in this process; with any the files are the same.

    Raises
    ------
    InvalidFile, InvalidParameter
        If the table cannot be read or holds nothing to analyse.
    DeviceFailed
        If the report cannot be written, or nothing prints it.
    """
    expect(report is not None or not pdf, "--pdf", "no --report", "one: the PDF is printed from it")
    path, report, figures = Path(path), _path(report), _path(figures)
    if report is not None:
        check_report(report)  # before the analysis, which may take minutes
    trials = read_trials(path, within=within, column_map=column_map, level_scale=level_scale)
    analysis = analyse_trials(
        replace(trials, notes=(*warnings, *_group_notes(trials, trials.factors if within else ()), *trials.notes)),
        plan or plan_of(path),
        replay if level_scale in (None, "linear") else None,
    )
    if report is None and figures is None:
        return analysis
    if touches is not None and len(courses := touches()):
        analysis = replace(analysis, tables={**analysis.tables, "touches": courses})
    sections = sections_of(analysis)
    if figures is not None:
        svgs = write_figures(analysis, figures, sections, spread)
        analysis = replace(analysis, figures_folder=figures)
    else:
        svgs = draw_figures(figures_of(analysis, sections), spread)
    if report is None:
        return analysis
    return write_report(analysis, report, pdf=pdf, sections=sections, svgs=svgs)


def _group_notes(trials: Trials, within: Sequence[str]) -> list[str]:
    """Name the factors of `within` that no participant met at two levels, though others met another."""
    levels = trials.rows.groupby("participant")[list(within)].nunique() if within else pd.DataFrame()
    apart = [name for name in within if levels[name].max() < 2 and trials.rows[name].nunique() > 1]
    return [f"--within {name}: it differs between participants, each of whom has one of its levels" for name in apart]


def _path(given: str | Path | None) -> Path | None:
    return None if given is None else Path(given)


def analyse_trials(everything: Trials, plan: AnalysisPlan | None = None, replay: Replay | None = None) -> Analysis:
    """All estimates, tables and warnings of a trials table; nothing is written."""
    plan = plan or AnalysisPlan()
    plan.check(everything.factors)
    everything, origin = of_one_kind(everything)
    recorded = quality(everything)
    trials, excluded = exclude(everything, plan.exclusion, recorded)
    factors, all_used = trials.factors, used_rows(everything)
    all_judged = cells.judgements(all_used)  # a rule was told the answers, too, that the plan leaves out
    used, judged = (rows[rows.index.isin(trials.rows.index)] for rows in (all_used, all_judged))
    answers = cells.counted_answers(judged)
    every, forms = cells.cells(answers, factors), ratings(trials, plan.primary)
    direct = _direct_tables(used, factors)
    if not every and not forms and not direct:
        why = UNSCORED if all_used["task"].isin(cells.CHOICES).any() else ""
        raise InvalidFile(f"{trials.path}: found {NOTHING}{why}")
    unit = cells.level_unit(trials)
    estimates = cells.estimates(every, unit)
    table = cells.estimate_table(estimates, factors, unit)
    if len(table):
        table = table.join(rule_columns(cells.counted_answers(all_judged), factors, estimates, replay))
        table = table.join(_goodness(answers, factors, estimates, unit))
    forces = force_of_participants(used, factors) if has_force(used) else None
    values = Analysis(
        trials=trials,
        unit=unit,
        estimates=tuple(estimates),
        outcomes=tuple(_outcomes(table, direct, factors, forces, plan)),
        hierarchical=tuple(_hierarchical(estimates, factors, unit)) if plan.hierarchical else (),
        forms=forms,
        plan=plan,
        tables={},
        origin=origin,
        study=study_text(everything.path, unit),
    )
    tables = {"quality": with_frames(recorded, frames(everything.path)), "excluded": excluded, **direct}
    tables |= _curve_tables(table, estimates, used, judged, factors) | _force_tables(forces, factors)
    tables |= _compared_tables(values) | {TESTS: _standard(values, table, used), "categories": categories(trials)}
    tables |= {"sittings": sittings(origin.heads), "happenings": happenings(everything.path)}
    values = replace(values, tables={name: rows for name, rows in tables.items() if len(rows)})
    return replace(values, warnings=warnings_of(values), methods=methods(values))  # last: they tell of all tables


UNSCORED = "; a forced choice needs a column 'correct' or 'target'"
NOTHING = (
    f"no valid answer of a task ({', '.join((*CURVES, *RESULTS))}) nor to a known questionnaire, expected some to "
    "analyse"
)


def _goodness(answers: pd.DataFrame, factors: Sequence[str], estimates: Sequence[Estimate], unit: str) -> pd.DataFrame:
    fitted = cells.curves_of([estimate.cell for estimate in estimates])
    options = {(task, n): CURVES[task].options(n, unit) for task, n in fitted}
    rng = np.random.default_rng(SEED)
    return goodness_columns(answers, factors, estimates, options, rng, cells.COUNTING)


def _direct_tables(used: pd.DataFrame, factors: Sequence[str]) -> dict[str, pd.DataFrame]:
    """What is read off the answers of a task without a curve: the tables of each task that has used rows."""
    rows_of = dict(iter(used.groupby("task")))
    tables: dict[str, pd.DataFrame] = {}
    for task in (task for task in RESULTS if task in rows_of):
        tables |= {name: table_of(rows_of[task], factors) for name, table_of in RESULTS[task].tables.items()}
    return {name: table for name, table in tables.items() if len(table)}


def _outcomes(
    table: pd.DataFrame,
    direct: Mapping[str, pd.DataFrame],
    factors: Sequence[str],
    forces: pd.DataFrame | None,
    plan: AnalysisPlan,
) -> Iterator[Outcome]:
    """Of each dependent value of each task that has estimates."""
    estimates = dict(direct)
    if len(table):
        estimates |= {str(task): rows for task, rows in table.groupby("task")}
    for task in (task for task in ANALYSES if task in estimates):
        results = RESULTS.get(task, Results({}))
        compared = estimates[results.compared or task]
        conditions = [name for name in (*factors, *results.further) if name in compared.columns]
        # the force applied is known by the factors alone
        applied = forces if set(conditions) == set(factors) else None
        # differences that count as none are in the unit of the levels, which an exponent has not
        bounds = plan.equivalence if results.in_levels else {}
        for dependent in ANALYSES[task].dependents:
            yield outcome(compared, conditions, task, dependent, forces=applied, bounds=bounds, primary=plan.primary)


def _hierarchical(estimates: Sequence[Estimate], factors: Sequence[str], unit: str) -> Iterator[HierarchicalOutcome]:
    for task in CURVES:
        fits = {estimate.cell: estimate.fit for estimate in estimates if estimate.cell.task == task}
        fit = group_fit(list(fits), factors, unit, fits) if fits else None
        if fit is not None:
            yield fit


def _curve_tables(
    table: pd.DataFrame,
    estimates: Sequence[Estimate],
    used: pd.DataFrame,
    judged: pd.DataFrame,
    factors: Sequence[str],
) -> dict[str, pd.DataFrame]:
    if not estimates:
        return {}
    every = [estimate.cell for estimate in estimates]
    counts = cells.count_table(every, factors)
    return {
        "thresholds": table,
        "goodness": goodness_table(table),
        "rates": cells.detection_rates(counts, factors),
        "mean_rates": cells.mean_rates(counts, factors),
        "counts": counts,
        "tracks": tracks(judged, factors),
        FLOORS: lowest_levels(every, factors),
        LAPSES: lapse_table(estimates, factors),
    }


def _standard(analysis: Analysis, table: pd.DataFrame, used: pd.DataFrame) -> pd.DataFrame:
    jnds = next((one.group for one in analysis.outcomes if one.dependent == "jnd"), None)
    return standard_tests(table, used, analysis.factors, jnds)


def _force_tables(forces: pd.DataFrame | None, factors: Sequence[str]) -> dict[str, pd.DataFrame]:
    return {} if forces is None else {"force_participants": forces, "force": force_table(forces, factors)}


def _compared_tables(analysis: Analysis) -> dict[str, pd.DataFrame]:
    """Of outcomes, hierarchical fits and questionnaires."""
    tables: dict[str, pd.DataFrame] = {}
    for compared in analysis.outcomes:
        tables |= compared.tables(analysis.stem(compared))
    for fit in analysis.hierarchical:
        tables |= fit.tables(fit.task)
    for form in analysis.forms:
        tables |= form.tables()
    return tables
