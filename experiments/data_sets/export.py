"""Exports for other programs: Psych-DS, PsychoPy, BIDS, jsPsych and R.

A recorded data set is already Psych-DS. This export converts single tables too, omits journals, and uses official
keywords only. PsychoPy's and jsPsych's forms are for scripts and people that read such files; `columns.toml` next to
them reads them back with `--columns`.
"""

from collections.abc import Callable, Mapping, Sequence
from itertools import chain
from pathlib import Path

from tactometry.arguments.require import one_of
from tactometry.files.rows import cell_text, spreadsheet_text
from tactometry.records.description import KEYWORD

from .bids import bids_files, task_label
from .exported_traces import traces_as
from .jspsych import jspsych_files
from .r_table import r_files
from .source import ExportedDataSet, how_to_read, json_text, read_source, readme_heading, write_files

SCHEMA_VERSION = "Psych-DS 1.5.0"
RENAMED = {
    "study": "expName",
    "timestamp_utc": "date",
    "response": "response.keys",
    "correct": "response.corr",
    "latency_s": "response.rt",
    "onset_s": "stimulus.started",
    "block": "blocks.thisN",
    "trial": "trials.thisN",
}
FROM_ZERO = ("block", "trial")
LAST = ("participant", "session", "study", "timestamp_utc")
"""PsychoPy writes what it knows of the whole session into the last columns."""


def psychds_files(source: ExportedDataSet) -> dict[str, bytes]:
    """Return the files by path; equal data, equal bytes."""
    names = [column.name for column in source.columns]
    study = (source.text("study") or "trials").replace("-", "")  # a hyphen parts key and value in names of files
    files = {
        "dataset_description.json": json_text(_description(source)),
        "README.md": f"{readme_heading(source)}\n\nWritten by tactometry export.\n".encode(),
        "CHANGES.md": b"# Changes\n\n1.0.0: as exported.\n",
    }
    for participant, session, rows in source.sessions():
        body = [[row.get(name, "") for name in names] for row in rows]
        stem = f"subject-{participant}_session-{session}_study-{study}"
        files[f"data/{stem}_data.csv"] = spreadsheet_text([names, *body])
    return files


def _description(source: ExportedDataSet) -> Mapping[str, object]:
    return {
        "@context": "https://schema.org/",
        "@type": "Dataset",
        "name": source.title,
        "description": source.description,
        "schemaVersion": SCHEMA_VERSION,
        **({"keywords": [KEYWORD]} if source.origin.is_simulated else {}),
        "variableMeasured": [
            {"@type": "PropertyValue", "name": cell_text(column.name), "description": column.description}
            | ({"unitText": column.unit} if column.unit else {})
            for column in (*source.columns, *source.of_traces)
        ],
    }


def psychopy_files(source: ExportedDataSet) -> dict[str, bytes]:
    """Return the files by path, with blocks and trials numbered from 0."""
    names = [column.name for column in source.columns]
    ordered = [*(name for name in names if name not in LAST), *(name for name in LAST if name in names)]
    header = [RENAMED.get(name, name) for name in ordered]
    files = {"columns.toml": _column_map(ordered, source.factors).encode()}
    for participant, session, rows in source.sessions():
        study = source.text("study") or "study"
        body = [[_cell(name, row.get(name, "")) for name in ordered] for row in rows]
        files[f"data/{participant}_{study}_session-{session}.csv"] = spreadsheet_text([header, *body])
    return files


def _cell(name: str, text: str) -> str:
    return str(int(float(text)) - 1) if name in FROM_ZERO and text else text


def _column_map(names: Sequence[str], factors: Sequence[str]) -> str:
    lines = [f'{name} = "{RENAMED[name]}"' for name in names if name in RENAMED and name not in FROM_ZERO]
    return "\n".join([how_to_read(factors), "[columns]", *lines, ""])


FORMS: Mapping[str, Callable[[ExportedDataSet], dict[str, bytes]]] = {
    "jspsych": jspsych_files,
    "psych-ds": psychds_files,
    "psychopy": psychopy_files,
    "r": r_files,
}


def export(path: Path, form: str, out: Path, authors: Sequence[str] = ()) -> list[Path]:
    """Write a data set or trials file in a form into a new or empty folder.

    The form is `bids` or one of `FORMS`.

    Raises
    ------
    InvalidParameter
        If the form is unknown or the folder is not empty.
    InvalidFile
        If the data set is damaged.
    DeviceFailed
        If the folder cannot be written.
    """
    one_of("--to", form, ("bids", *FORMS))
    source = read_source(path)
    files = bids_files(source, authors) if form == "bids" else FORMS[form](source)
    return write_files(chain(files.items(), traces_as(form, path, task_label(source), files)), out)
