"""A data set in the form of the Brain Imaging Data Structure (BIDS), for behaviour.

Trials with an onset become `events.tsv`; answers to questionnaires and rows without an onset become `beh.tsv`, and the
scores of questionnaires a table in `phenotype/`.
"""

from collections.abc import Mapping, Sequence

import pandas as pd

from tactometry import __version__
from tactometry.analysis.attrakdiff import scores
from tactometry.columns import Column
from tactometry.dataset import cell
from tactometry.errors import InvalidParameter
from tactometry.experiments.export_source import Row, Source, pretty, separated
from tactometry.questionnaire import Questionnaire, load, shipped

BIDS_VERSION = "1.10.1"
OWN = ("participant", "session", "study")
MISSING = "n/a"
NOT_STATED = ("Not stated", "Tactometry (the software that wrote this data set)")
LICENSE = "Not stated"
HED_VERSION = "8.3.0"
"""No tag is used; the validator asks for it all the same."""
UNKNOWN = ("Instructions", "InstitutionName", "InstitutionAddress", "InstitutionalDepartmentName")
TERMS = ("https://www.cognitiveatlas.org", "http://www.cogpo.org")
"""Of the task, which no ontology names: their front pages."""


def bids_files(source: Source, authors: Sequence[str] = ()) -> dict[str, bytes]:
    """Every file of the BIDS data set, by its path; the same data give the same bytes.

    Raises
    ------
    InvalidParameter
        If a column cannot be named in BIDS.
    """
    files = _heading(source, authors)
    for participant, session, rows in source.sessions():
        stem = f"sub-{participant}/ses-{session}/beh/sub-{participant}_ses-{session}"
        forms = sorted({row["procedure"] for row in rows if _is_form(row)})
        for form in forms:
            answers = [row for row in rows if _is_form(row) and row["procedure"] == form]
            files |= _table(f"{stem}_task-{_label(form)}_beh", answers, source, f"Questionnaire {form}.", timed=False)
        trials = [row for row in rows if not _is_form(row)]
        timed = bool(trials) and all(row.get("onset_s") for row in trials)
        task = _label(source.text("study") or "trials")
        if trials:
            stem += f"_task-{task}" + ("_run-01_events" if timed else "_beh")
            files |= _table(stem, trials, source, source.description, timed=timed)
    return files | _phenotypes(source)


def _is_form(row: Row) -> bool:
    return row.get("task") == "rating" and row.get("procedure") in shipped()


def _label(text: str) -> str:
    """Letters and digits of a name.

    >>> _label("time-reversal-patterns")
    'timereversalpatterns'
    """
    return "".join(letter for letter in text if letter.isalnum() and letter.isascii()) or "trials"


def _heading(source: Source, authors: Sequence[str]) -> dict[str, bytes]:
    description = {
        "Name": source.title,
        "BIDSVersion": BIDS_VERSION,
        "DatasetType": "raw",
        "License": LICENSE,
        "Authors": list(authors) if authors else list(NOT_STATED),
        "HEDVersion": HED_VERSION,
        "SourceDatasets": [{"Version": source.text("study") or MISSING}],
        "GeneratedBy": [{"Name": "Tactometry", "Version": __version__}],
    }
    people = sorted({row["participant"] for row in source.rows})
    found = {
        "dataset_description.json": pretty(description),
        "README.md": _readme(source).encode(),
        "participants.tsv": separated(["participant_id"], [[f"sub-{code}"] for code in people], "\t"),
        "participants.json": pretty({"participant_id": {"Description": "Code of the participant"}}),
    }
    for code in people:
        found[f"sub-{code}/sub-{code}_sessions.tsv"] = _sessions(source, code)
    return found


def _sessions(source: Source, code: str) -> bytes:
    """Sessions with the time of their first answer, where it is known."""
    rows = []
    for participant, session, part in source.sessions():
        times = sorted(time for row in part if (time := row.get("timestamp_utc")))
        if participant == code:
            rows.append([f"ses-{session}", times[0][:19] if times else MISSING])
    return separated(["session_id", "acq_time"], rows, "\t")


def _readme(source: Source) -> str:
    names = ", ".join(source.factors) or "none"
    return (
        f"# {source.title}\n\n{source.description}\n\n"
        "Psychophysics on touch, recorded or simulated with Tactometry and exported from its data set. Each row of an\n"
        "events.tsv is one trial: the level of the stimulus, the answer, the applied force, and whether the trial was\n"
        f"valid. Factors: {names}. Cells that hold n/a were not measured. Times are seconds since the start of the\n"
        "session. Participants are known by their codes only.\n"
    )


def _table(stem: str, rows: Sequence[Row], source: Source, description: str, *, timed: bool) -> dict[str, bytes]:
    """A TSV file with its sidecar."""
    columns = [c for c in source.columns if c.name not in OWN and any(row.get(c.name) for row in rows)]
    kept = [c for c in columns if not (timed and c.name == "onset_s")]
    header = [*(("onset", "duration") if timed else ()), *(c.name for c in kept)]
    for name in header:
        if not name.replace("_", "").isalnum() or not name.isascii():
            raise InvalidParameter(f"column {name!r}: found other than letters, digits and _, expected a name for BIDS")
    body = [
        [*((row["onset_s"], MISSING) if timed else ()), *(row.get(c.name) or MISSING for c in kept)] for row in rows
    ]
    task = stem.split("_task-")[1].split("_", maxsplit=1)[0]
    sidecar = _sidecar(task, description, kept, rows, timed=timed)
    return {f"{stem}.tsv": separated(header, body, "\t"), f"{stem}.json": pretty(sidecar)}


def _sidecar(
    task: str, description: str, columns: Sequence[Column], rows: Sequence[Row], *, timed: bool
) -> Mapping[str, object]:
    units = {row.get("level_unit", "") for row in rows}
    level_unit = units.pop() if len(units) == 1 else ""
    found: dict[str, object] = {
        "TaskName": task,
        "TaskDescription": description,
        **dict.fromkeys(UNKNOWN, MISSING),
        "CogAtlasID": TERMS[0],
        "CogPOID": TERMS[1],
        "StimulusPresentation": {"SoftwareName": "Tactometry", "SoftwareVersion": __version__},
    }
    if timed:
        found["onset"] = {"Description": "Onset of the (first) stimulus since the start of the session", "Units": "s"}
        found["duration"] = {"Description": "Duration of the stimulus; n/a: see the study", "Units": "s"}
    for column in columns:
        unit = column.unit or (level_unit if column.name in LEVELS else "")
        found[column.name] = {"Description": column.description} | ({"Units": unit} if unit else {})
    return found


LEVELS = ("level", "level_delivered", "level_measured", "standard_level")


def _phenotypes(source: Source) -> dict[str, bytes]:
    """Scores of each questionnaire: a row per participant, a column per condition (and session) and dimension."""
    files: dict[str, bytes] = {}
    for name in sorted({row["procedure"] for row in source.rows if _is_form(row)}):
        answers = pd.DataFrame([dict(row) for row in source.rows if _is_form(row) and row["procedure"] == name])
        files |= _phenotype(load(name), answers, source)
    return files


def _phenotype(form: Questionnaire, answers: pd.DataFrame, source: Source) -> dict[str, bytes]:
    factors = [name for name in ("session", *source.factors) if name in answers and answers[name].nunique() > 1]
    scored = scores(answers, questionnaire=form, within=factors)
    long = scored.melt(["participant", *factors], list(form.dimensions), "dimension", "score")
    keys = sorted({tuple(row) for row in long[[*factors, "dimension"]].itertuples(index=False, name=None)})
    known = {tuple(row[:-1]): row[-1] for row in long.itertuples(index=False, name=None)}
    people = sorted(set(answers["participant"]))
    rows = [[f"sub-{code}", *(_score(known.get((code, *key))) for key in keys)] for code in people]
    columns = {_score_name(factors, key): _score_text(form, factors, key) for key in keys}
    told = {"MeasurementToolMetadata": {"Description": f"{form.title}: {form.reference}"}}
    told |= {"participant_id": {"Description": "Code of the participant"}}
    told |= {name: {"Description": text} for name, text in columns.items()}
    stem = f"phenotype/{_label(form.name)}"
    return {f"{stem}.tsv": separated(["participant_id", *columns], rows, "\t"), f"{stem}.json": pretty(told)}


def _score(value: float | None) -> str:
    return MISSING if value is None or pd.isna(value) else cell(value)


def _score_name(factors: Sequence[str], key: Sequence[object]) -> str:
    parts = [f"ses{value}" if name == "session" else str(value) for name, value in zip(factors, key, strict=False)]
    return "_".join([*map(_label, parts), str(key[-1])])


def _score_text(form: Questionnaire, factors: Sequence[str], key: Sequence[object]) -> str:
    place = ", ".join(f"{name} = {value}" for name, value in zip(factors, key, strict=False))
    title = form.dimensions[str(key[-1])].title.get("en", str(key[-1]))
    return f"{title}{' for ' + place if place else ''}: mean of its items, {form.score_low:g} to {form.score_high:g}"
