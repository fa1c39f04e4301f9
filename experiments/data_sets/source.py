"""Data set prepared for export: rows as text, and column descriptions."""

import json
import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from typing import TypeVar

import pandas as pd

from tactometry.analysis.reading.origin import Origin, choices_of, forms_of, of_one_kind
from tactometry.analysis.reading.text_table import text_cells
from tactometry.analysis.reading.trial_files import trial_files
from tactometry.analysis.reading.trials import Trials, read_trials, used_rows
from tactometry.config.quantity import unit_suffix, units
from tactometry.errors import InvalidFile, InvalidParameter, count_of
from tactometry.files.durable import files_in, make_folder, write_atomically
from tactometry.files.rows import cell_text, markdown_text
from tactometry.questionnaire import Questionnaire
from tactometry.records.description import NAME
from tactometry.records.traces import FOLDER, read_sidecar, sidecar_of
from tactometry.trials.columns import ALWAYS, FIRST, OPTIONAL, Column
from tactometry.trials.row_rules import RULES
from tactometry.trials.tasks import FORM_TASK

from .session_files import json_table

Row = Mapping[str, str]
T = TypeVar("T")


@dataclass(frozen=True)
class ExportedDataSet:
    """Rows as text, described columns, and the data set's description.

    `used` are the rows that enter an analysis and `forms` the answered questionnaires. `choices` are the names of
    answered choice forms. `origin` states whether participants are people or simulated, and `of_traces` are the columns
    of traces.
    """

    rows: tuple[Row, ...]
    columns: tuple[Column, ...]
    factors: tuple[str, ...]
    title: str
    description: str
    used: pd.DataFrame = field(default_factory=pd.DataFrame)
    forms: Mapping[str, Questionnaire] = field(default_factory=dict)
    origin: Origin = field(default_factory=Origin)
    of_traces: tuple[Column, ...] = ()
    choices: tuple[str, ...] = ()

    def sessions(self) -> list[tuple[str, str, list[Row]]]:
        """Return participant, session and rows of each session."""
        ordered = sorted(self.rows, key=_whose)
        return [(*key, list(rows)) for key, rows in groupby(ordered, key=_whose)]

    def tasks(self) -> list[str]:
        """Return the tasks of all rows, sorted."""
        return sorted({row["task"] for row in self.rows})

    @property
    def asked(self) -> tuple[str, ...]:
        """Names of all forms that were answered."""
        return (*self.forms, *self.choices)

    def form(self, row: Row) -> str:
        """Return the questionnaire of a row, or an empty text.

        A questionnaire's row is an answer, or a touch without an answer.

        >>> ExportedDataSet((), (), (), "", "").form({"task": "yes_no", "procedure": "staircase"})
        ''
        """
        name = row.get("procedure", "") if row.get("task") == FORM_TASK else ""
        return name if name in self.asked else ""

    def text(self, name: str) -> str:
        """Return the only value of a column, or an empty text for several values.

        >>> ExportedDataSet(({"study": "a"}, {"study": "a"}), (), (), "", "").text("study")
        'a'
        """
        values = {row.get(name, "") for row in self.rows}
        return values.pop() if len(values) == 1 else ""


def _whose(row: Row) -> tuple[str, str]:
    """Return participant and session. Accepts sessions such as 1.0 or 001."""
    session = row.get("session")
    return row["participant"], str(int(float(session))) if session else "1"


def read_source(path: Path) -> ExportedDataSet:
    """Read the rows of a data set or one trials file, as checked trials.

    Raises `InvalidFile` if there are no tables, a table is damaged, a study name is invalid, or the tables mix people
    and simulated participants.
    """
    trials = read_trials(path)
    kept, origin = of_one_kind(trials)
    n_simulated = len(trials.rows) - len(kept.rows)
    if n_simulated:
        raise InvalidFile(
            f"{path}: found {count_of(n_simulated, 'row')} of simulated participants next to those of people, expected "
            "only one kind: move one to a separate folder"
        )
    tables = [text_cells(file, verbatim=True) for file in trial_files(path)]
    for file, table in zip(trial_files(path), tables, strict=True):
        _check_study(table, file)
    fullest = max(tables, key=lambda table: table.shape[1])  # older sessions lack columns that later versions added
    names = [str(name) for name in fullest.columns if name != "row"]
    description = json_table(path / NAME)
    title = str(description.get("name") or path.stem)
    return ExportedDataSet(
        rows=tuple(row for table in tables for row in _rows(table, names)),
        columns=tuple(_column(name, description) for name in names),
        factors=trials.factors,
        title=title,
        description=str(description.get("description") or f"Trials of {title}."),
        used=used_rows(trials),
        forms=_asked_of(trials, forms_of(trials.path)),
        origin=origin,
        of_traces=_trace_columns(path, names),
        choices=tuple(_asked_of(trials, choices_of(trials.path))),
    )


def _trace_columns(root: Path, names: Sequence[str]) -> tuple[Column, ...]:
    """Return the columns of a data set's traces that its rows do not have."""
    explained = [read_sidecar(sidecar_of(file)) for file in files_in(root / FOLDER, "*.tsv.gz")]
    columns = {column.name: column for description in explained for column in description.columns}
    return tuple(column for name, column in columns.items() if name not in names)


def _rows(table: pd.DataFrame, names: Sequence[str]) -> list[Row]:
    whole = table.reindex(columns=list(names), fill_value="")
    return [dict(zip(names, cells, strict=True)) for cells in whole.itertuples(index=False, name=None)]


def _check_study(table: pd.DataFrame, file: Path) -> None:
    """Reject a study name that cannot be part of a file name."""
    rule = RULES["study"]
    for text in table["study"].unique() if "study" in table.columns else ():
        if text and not rule.holds(text):
            row = table.loc[table["study"] == text, "row"].iloc[0]
            raise InvalidFile(f"{file}, row {row}, column 'study': found {text!r:.60}, expected {rule.words}")


def _asked_of(trials: Trials, known: Mapping[str, T]) -> dict[str, T]:
    rows = trials.rows
    if not {"item", "procedure"} <= set(rows.columns):
        return {}
    answered = set(rows.loc[rows["task"] == FORM_TASK, "procedure"])
    return {name: form for name, form in sorted(known.items()) if name in answered}


def _column(name: str, description: Mapping[str, object]) -> Column:
    known = {column.name: column for column in (*FIRST, *ALWAYS, *OPTIONAL)}
    if name in known:
        return known[name]
    variables = description.get("variableMeasured")
    for variable in variables if isinstance(variables, list) else []:
        if isinstance(variable, dict) and variable.get("name") == name:
            return Column(name, str(variable.get("description", "")) or name, str(variable.get("unitText", "")))
    suffix = unit_suffix(name)
    return Column(name, f"Factor {name}", units(suffix)[0] if suffix else "")


def write_files(files: Iterable[tuple[str, bytes]], folder: Path) -> list[Path]:
    """Write files into a new or empty folder, and return their sorted paths.

    Raises `InvalidParameter` if the folder is not empty. Raises `DeviceFailed` if the disk is full or fails.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InvalidParameter(f"--out: found files in {folder}, expected a new or an empty folder")
    written = []
    for name, content in files:
        make_folder((folder / name).parent)
        write_atomically(folder / name, content)
        written.append(folder / name)
    return sorted(written)


def readme_heading(source: ExportedDataSet, *lines: str) -> str:
    r"""Format title, further lines and description of a data set as Markdown.

    >>> readme_heading(ExportedDataSet((), (), (), "<i>a", "A study."), "Simulated.")
    '# \\<i>a\n\nSimulated.\n\nA study.'
    """
    title = " ".join(markdown_text(source.title).split())
    return "\n\n".join([f"# {title}", *filter(None, lines), markdown_text(source.description)])


def how_to_read(factors: Sequence[str]) -> str:
    """Return the comment of a column map with the command that reads it.

    >>> how_to_read(["force_n", "frequency_hz"])
    '# tactometry analyse . --columns columns.toml --within force_n,frequency_hz'
    """
    named = " ".join(",".join(map(cell_text, factors)).split())
    within = f" --within {shlex.quote(named)}" if factors else ""
    return f"# tactometry analyse . --columns columns.toml{within}"


def json_text(value: object) -> bytes:
    """Format a value as indented JSON, keeping the order of keys."""
    return (json.dumps(value, indent=2, ensure_ascii=False) + "\n").encode()
