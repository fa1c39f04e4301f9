"""Export to the Brain Imaging Data Structure (BIDS), for behaviour.

`events.tsv` contains trials with an onset. `beh.tsv` contains rows without an onset, questionnaire answers, and touches
without an answer. `phenotype/` contains a table of questionnaire scores.
"""

from collections.abc import Mapping, Sequence

import pandas as pd

from tactometry import __version__
from tactometry.analysis.attrakdiff.scoring import scores
from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter
from tactometry.files.rows import markdown_text, spreadsheet_text
from tactometry.questionnaire import Questionnaire
from tactometry.records.description import KEYWORD
from tactometry.trials.cells import cell
from tactometry.trials.columns import Column
from tactometry.trials.tasks import FORM_TASK

from .source import ExportedDataSet, Row, json_text, readme_heading

BIDS_VERSION = "1.10.1"
OWN = ("participant", "session", "study")
MISSING = "n/a"
NOT_STATED = ("Not stated", "Tactometry (the software that wrote this data set)")
LICENSE = "Not stated"
HED_VERSION = "8.3.0"
"""Version required by the validator, although no HED tag is used."""
UNKNOWN = ("Instructions", "InstitutionName", "InstitutionAddress", "InstitutionalDepartmentName")
TERMS = ("https://www.cognitiveatlas.org", "http://www.cogpo.org")
"""Front pages of the task ontologies, as no ontology defines these tasks."""


def bids_files(source: ExportedDataSet, authors: Sequence[str] = ()) -> dict[str, bytes]:
    """Return the BIDS files by path. Equal data give equal bytes.

    Raises `InvalidParameter` if a column cannot be named in BIDS.
    """
    files = _heading(source, authors)
    for participant, session, rows in source.sessions():
        stem = f"sub-{participant}/ses-{session}/beh/sub-{participant}_ses-{session}"
        for name in source.asked:
            answers = [row for row in rows if source.form(row) == name]
            files |= _table(f"{stem}_task-{_label(name)}_beh", answers, source, f"Questionnaire {name}.", timed=False)
        stem += f"_task-{task_label(source)}"
        trials = [row for row in rows if not source.form(row)]
        for timed, name in ((True, f"{stem}_run-01_events"), (False, f"{stem}_beh")):
            chosen = [row for row in trials if bool(row.get("onset_s")) is timed]
            files |= _table(name, chosen, source, source.description, timed=timed)
    return files | _phenotypes(source)


def task_label(source: ExportedDataSet) -> str:
    """Return the BIDS task label of the trials."""
    return _label(source.text("study") or "trials")


def _label(text: str) -> str:
    """Return a name's letters and digits only.

    >>> _label("time-reversal-patterns")
    'timereversalpatterns'
    """
    return "".join(letter for letter in text if letter.isalnum() and letter.isascii()) or "trials"


def _heading(source: ExportedDataSet, authors: Sequence[str]) -> dict[str, bytes]:
    description = {
        "Name": source.title,
        "BIDSVersion": BIDS_VERSION,
        "DatasetType": "raw",
        "License": LICENSE,
        "Authors": list(authors) if authors else list(NOT_STATED),
        "HEDVersion": HED_VERSION,
        **({"Keywords": [KEYWORD]} if source.origin.is_simulated else {}),
        "SourceDatasets": [{"Version": source.text("study") or MISSING}],
        "GeneratedBy": [{"Name": "Tactometry", "Version": __version__}],
    }
    people = sorted({row["participant"] for row in source.rows})
    files = {
        "dataset_description.json": json_text(description),
        "README.md": _readme(source).encode(),
        "participants.tsv": spreadsheet_text([["participant_id"], *([f"sub-{code}"] for code in people)], "\t"),
        "participants.json": json_text({"participant_id": {"Description": "Code of the participant"}}),
    }
    for code in people:
        files[f"sub-{code}/sub-{code}_sessions.tsv"] = _sessions(source, code)
    return files


def _sessions(source: ExportedDataSet, code: str) -> bytes:
    """Return the sessions table, with the time of each first answer if known."""
    rows = []
    for participant, session, of_session in source.sessions():
        times = sorted(time for row in of_session if (time := row.get("timestamp_utc")))
        if participant == code:
            rows.append([f"ses-{session}", times[0][:19] if times else MISSING])
    return spreadsheet_text([["session_id", "acq_time"], *rows], "\t")


def _readme(source: ExportedDataSet) -> str:
    names = markdown_text(", ".join(source.factors)) or "none"
    did = "simulated" if source.origin.is_simulated else "recorded"
    return (
        f"{readme_heading(source, source.origin.line)}\n\n"
        f"Psychophysics on touch, {did} with Tactometry and exported from its data set. Each row of an\n"
        "events.tsv is one trial: the level of the stimulus, the answer, the applied force, and whether the trial was\n"
        "valid. A beh.tsv holds the rows without an onset, and those of a questionnaire: one for each item, and one\n"
        f"without an item for a touch that led to no answers. Factors: {names}. Cells with n/a were not measured.\n"
        "Times are seconds since the start of the session. Participants are known by their codes only.\n"
    )


def _table(
    stem: str, rows: Sequence[Row], source: ExportedDataSet, description: str, *, timed: bool
) -> dict[str, bytes]:
    """Return a TSV file and its JSON sidecar, or no files without rows."""
    if not rows:
        return {}
    columns = [c for c in source.columns if c.name not in OWN and any(row.get(c.name) for row in rows)]
    kept = [c for c in columns if not (timed and c.name == "onset_s")]
    header = [*(("onset", "duration") if timed else ()), *(c.name for c in kept)]
    _check_names(header)
    body = [
        [*((row["onset_s"], MISSING) if timed else ()), *(row.get(c.name) or MISSING for c in kept)] for row in rows
    ]
    task = stem.split("_task-")[1].split("_", maxsplit=1)[0]
    sidecar = _sidecar(task, description, kept, rows, timed=timed)
    return {f"{stem}.tsv": spreadsheet_text([header, *body], "\t"), f"{stem}.json": json_text(sidecar)}


def _check_names(header: Sequence[str]) -> None:
    for place, name in enumerate(header):
        is_word = name.replace("_", "").isalnum() and name.isascii()
        expect(
            is_word,
            f"column {name!r}",
            "characters other than letters, digits and _",
            "a name that BIDS allows; rename it",
        )
        if name in header[:place]:
            raise InvalidParameter(f"column {name!r}: found a name that BIDS uses for another column; rename it")


def _sidecar(
    task: str, description: str, columns: Sequence[Column], rows: Sequence[Row], *, timed: bool
) -> Mapping[str, object]:
    units = {row.get("level_unit", "") for row in rows}
    level_unit = units.pop() if len(units) == 1 else ""
    software = {"SoftwareName": "Tactometry", "SoftwareVersion": __version__}
    sidecar: dict[str, object] = {"StimulusPresentation": software}
    if not timed:
        sidecar |= {"TaskName": task, "TaskDescription": description, **dict.fromkeys(UNKNOWN, MISSING)}
        sidecar |= {"CogAtlasID": TERMS[0], "CogPOID": TERMS[1]}
    else:  # bids-validator 1 reads every key of an events.json as a column, bids-validator 3 only warns of missing keys
        sidecar["onset"] = {"Description": "Onset of the (first) stimulus since the start of the session", "Units": "s"}
        sidecar["duration"] = {"Description": "Duration of the stimulus; n/a: see the study", "Units": "s"}
    for column in columns:
        unit = column.unit or (level_unit if column.name in LEVELS else "")
        sidecar[column.name] = {"Description": column.description} | ({"Units": unit} if unit else {})
    return sidecar


LEVELS = ("level", "level_delivered", "level_measured", "standard_level")


def _phenotypes(source: ExportedDataSet) -> dict[str, bytes]:
    """Return scores: rows are participants, columns condition and dimension."""
    files: dict[str, bytes] = {}
    for name, form in source.forms.items():
        answers = source.used[(source.used["task"] == FORM_TASK) & (source.used["procedure"] == name)]
        files |= _phenotype(form, answers, source) if len(answers) else {}
    return files


def _phenotype(form: Questionnaire, answers: pd.DataFrame, source: ExportedDataSet) -> dict[str, bytes]:
    factors = [name for name in ("session", *source.factors) if name in answers and answers[name].nunique() > 1]
    scored = scores(answers, questionnaire=form, within=factors)
    long = scored.melt(["participant", *factors], list(form.dimensions), "dimension", "score")
    keys = sorted({tuple(row) for row in long[[*factors, "dimension"]].itertuples(index=False, name=None)})
    known = {tuple(row[:-1]): row[-1] for row in long.itertuples(index=False, name=None)}
    people = sorted(set(answers["participant"]))
    rows = [[f"sub-{code}", *(_score(known.get((code, *key))) for key in keys)] for code in people]
    columns = {_score_name(factors, key): _score_text(form, factors, key) for key in keys}
    sidecar = {"MeasurementToolMetadata": {"Description": f"{form.title}: {form.reference}"}}
    sidecar |= {"participant_id": {"Description": "Code of the participant"}}
    sidecar |= {name: {"Description": text} for name, text in columns.items()}
    stem = f"phenotype/{_label(form.name)}"
    return {
        f"{stem}.tsv": spreadsheet_text([["participant_id", *columns], *rows], "\t"),
        f"{stem}.json": json_text(sidecar),
    }


def _score(value: float | None) -> str:
    return MISSING if value is None or pd.isna(value) else cell(value)


def _level_texts(factors: Sequence[str], key: Sequence[object]) -> list[tuple[str, str]]:
    texts = [value if isinstance(value, str) else f"{value:g}" for value in key]
    return list(zip(factors, texts, strict=False))


def _score_name(factors: Sequence[str], key: Sequence[object]) -> str:
    parts = [f"ses{text}" if name == "session" else text for name, text in _level_texts(factors, key)]
    return "_".join([*map(_label, parts), str(key[-1])])


def _score_text(form: Questionnaire, factors: Sequence[str], key: Sequence[object]) -> str:
    place = ", ".join(f"{name} = {text}" for name, text in _level_texts(factors, key))
    title = form.dimensions[str(key[-1])].title.get("en", str(key[-1]))
    return f"{title}{' for ' + place if place else ''}: mean of its items, {form.score_low:g} to {form.score_high:g}"
