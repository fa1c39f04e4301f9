"""From a path to tables, warnings and a report: what `tactometry analyse` and `tactometry demo` call."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from tactometry.analysis import apa, cells, group, words
from tactometry.analysis.anova import MAX_FACTORS, repeated_measures
from tactometry.analysis.column_map import ColumnMap
from tactometry.analysis.complete import largest_complete
from tactometry.analysis.table import Trials, read_trials
from tactometry.errors import InvalidFile, InvalidParameter

OUTCOMES = {
    "yes_no": ("threshold",),
    "forced_choice": ("threshold",),
    "comparison": ("pse", "jnd"),
}


@dataclass(frozen=True)
class Outcome:
    """One dependent value of one task: its group table and, where it could be done, its analysis of
    variance."""

    task: str
    dependent: str
    estimates: pd.DataFrame
    group: pd.DataFrame
    cross: pd.DataFrame
    anova: pd.DataFrame | None
    notes: tuple[str, ...]
    sentences: tuple[str, ...]


@dataclass(frozen=True)
class Analysis:
    """What was found in one data set.

    `tables` maps a name to the table that is written as NAME.csv. `report` and `tables_folder` are None until
    written.
    """

    trials: Trials
    unit: str
    estimates: tuple[cells.Estimate, ...]
    outcomes: tuple[Outcome, ...]
    tables: Mapping[str, pd.DataFrame]
    warnings: tuple[str, ...]
    methods: str
    report: Path | None = None
    tables_folder: Path | None = None

    def summary(self) -> dict[str, object]:
        """The result as plain values for JSON."""
        return {
            "path": str(self.trials.path),
            "n_trials": len(self.trials.rows),
            "n_participants": int(self.trials.rows["participant"].nunique()),
            "factors": list(self.trials.factors),
            "level_unit": self.unit,
            "warnings": list(self.warnings),
            "thresholds": words.plain_rows(self.tables["thresholds"]),
            "outcomes": [_plain_outcome(outcome) for outcome in self.outcomes],
            "report": None if self.report is None else str(self.report),
            "tables": None if self.tables_folder is None else str(self.tables_folder),
        }


def _plain_outcome(outcome: Outcome) -> dict[str, object]:
    return {
        "task": outcome.task,
        "dependent": outcome.dependent,
        "group": words.plain_rows(outcome.group),
        "anova": None if outcome.anova is None else words.plain_rows(outcome.anova),
        "sentences": list(outcome.sentences),
        "notes": list(outcome.notes),
    }


def analyse(
    path: Path,
    *,
    report: Path | None = None,
    pdf: bool = False,
    within: Sequence[str] = (),
    column_map: ColumnMap | None = None,
) -> Analysis:
    """Analyse a data set's folder or a trials file; write the report and its tables if `report` names a file.

    Parameters
    ----------
    path : Path
        Data set or CSV file of trials.
    report : Path, optional
        An HTML file to write; the tables go into the folder ``<name>_tables`` beside it.
    pdf : bool
        Also print the report to ``<name>.pdf`` through an installed browser.
    within : sequence of str
        Factors; by default the columns between ``trial`` and ``procedure``.
    column_map : ColumnMap, optional
        How a foreign table's columns are called.

    Raises
    ------
    InvalidFile, InvalidParameter
        If the table cannot be read or holds nothing to analyse.
    DeviceFailed
        If the report cannot be written, or no browser prints it.
    """
    found = analysed(read_trials(path, within=within, column_map=column_map))
    if report is None:
        if pdf:
            raise InvalidParameter("--pdf: found no --report, expected one: the PDF is printed from it")
        return found
    from tactometry.analysis.report import write_report

    return write_report(found, report, pdf=pdf)


def analysed(trials: Trials) -> Analysis:
    """All estimates, tables and warnings of a trials table; nothing is written."""
    unit = cells.level_unit(trials)
    found = cells.cells(trials)
    if not found:
        raise InvalidFile(
            f"{trials.path}: found no valid answer of a yes/no, forced-choice or comparison task, "
            "expected some to analyse"
        )
    n_choices = cells.n_alternatives(trials)
    estimates = cells.estimates(found, n_choices, unit)
    table = cells.estimate_table(estimates, trials.factors, unit)
    outcomes = tuple(
        _outcome(table[table["task"] == task], trials.factors, task, dependent)
        for task, dependents in OUTCOMES.items()
        if (table["task"] == task).any()
        for dependent in dependents
    )
    quality = group.quality(trials)
    return Analysis(
        trials=trials,
        unit=unit,
        estimates=tuple(estimates),
        outcomes=outcomes,
        tables=_tables(table, outcomes, found, trials, quality),
        warnings=words.warnings(trials, table, quality, n_choices),
        methods=words.methods(table, n_choices),
    )


def _outcome(table: pd.DataFrame, factors: Sequence[str], task: str, dependent: str) -> Outcome:
    together = group.group_table(table, factors, dependent)
    anova, notes = _variance(table, factors, dependent)
    return Outcome(
        task=task,
        dependent=dependent,
        estimates=table,
        group=together,
        cross=group.cross_table(together, factors),
        anova=anova,
        notes=tuple(notes),
        sentences=() if anova is None else tuple(apa.anova_sentences(anova)),
    )


def _variance(table: pd.DataFrame, factors: Sequence[str], dependent: str) -> tuple[pd.DataFrame | None, list[str]]:
    """The analysis of variance of the largest complete sub-design, with what was left out; or why there is
    none."""
    varied = [name for name in factors if table[name].nunique() > 1]
    if not varied:
        return None, ["no analysis of variance: no factor has two levels"]
    if len(varied) > MAX_FACTORS:
        return None, [f"no analysis of variance: {len(varied)} factors, at most {MAX_FACTORS} can be taken"]
    if table.groupby("participant")[varied[0]].nunique().max() < 2:
        return None, [f"no analysis of variance: {varied[0]} does not vary within participants"]
    part = largest_complete(table, dependent=dependent, within=varied, subject="participant")
    if part is None:
        return None, ["no analysis of variance: no three participants share two conditions with a value"]
    notes = []
    if part.left_out:
        notes = [f"the analysis of variance uses the largest complete sub-design; left out: {', '.join(part.left_out)}"]
    try:
        anova = repeated_measures(part.table, dependent=dependent, within=list(part.within), subject="participant")
    except InvalidParameter as refusal:
        return None, [*notes, f"no analysis of variance: {refusal}"]
    return anova, [*notes, *anova.attrs["notes"]]


def _tables(
    table: pd.DataFrame,
    outcomes: Sequence[Outcome],
    found: Sequence[cells.Cell],
    trials: Trials,
    quality: pd.DataFrame,
) -> dict[str, pd.DataFrame]:
    tables = {
        "thresholds": table,
        "rates": group.detection_rates(found, trials.factors),
        "mean_rates": group.mean_rates(found, trials.factors),
        "quality": quality,
    }
    for outcome in outcomes:
        name = outcome.dependent if len({o.task for o in outcomes}) == 1 else f"{outcome.task}_{outcome.dependent}"
        tables[f"group_{name}"] = outcome.group
        tables[f"cross_{name}"] = outcome.cross
        if outcome.anova is not None:
            tables[f"anova_{name}"] = outcome.anova
    return tables
