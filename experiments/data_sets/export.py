"""Exports for other programs: Psych-DS, PsychoPy, BIDS, jsPsych and R.

A recorded data set already follows Psych-DS. The Psych-DS export also converts single tables, omits journals, and uses
official keywords only. The PsychoPy and jsPsych forms suit scripts that read such files. The exported `columns.toml`
lets `analyse --columns` read them back.
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Final

import pandas as pd

from tactometry.analysis.tasks.cells import alternatives
from tactometry.analysis.tasks.kinds import ANALYSES
from tactometry.analysis.tasks.task_analysis import R_OF_FORM
from tactometry.arguments.require import expect, one_of
from tactometry.files.json_file import json_value
from tactometry.files.rows import cell_text, spreadsheet_text
from tactometry.questionnaire import Questionnaire
from tactometry.records.description import KEYWORD
from tactometry.trials.cells import cell
from tactometry.trials.columns import ALWAYS, FIRST, OPTIONAL
from tactometry.trials.row_rules import COUNTS, FLAGS, NUMBERS

from .bids import bids_files, task_label
from .exported_traces import traces_as
from .source import ExportedDataSet, Row, how_to_read, json_text, read_source, readme_heading, write_files

TEXT = {column.name for column in (*FIRST, *ALWAYS, *OPTIONAL)}.difference(NUMBERS, COUNTS, FLAGS)
MOST_CATEGORIES = 15
"""Scales with more answer categories are modelled as continuous."""
SCRIPT = """# Reads trials.csv with its types. Written by tactometry export --to r.
trials <- read.csv("trials.csv", na.strings = "NA", stringsAsFactors = FALSE, check.names = FALSE,
                   encoding = "UTF-8", colClasses = c({classes}))
trials$participant <- factor(trials$participant)
used <- subset(trials, {used})
{factors}{forms}
# A model for each task begins so:
{models}
"""
FORM = """
# {title}: answers to reversed items are turned around.
{name} <- subset(used, procedure == {text})
{name} <- transform(
  {name}, response = ifelse(item %in% c({turned}), {sum:g} - as.numeric(response), as.numeric(response)))
"""
CONTINUOUS = "lme4::lmer(response ~ {plus} + (1 | participant) + (1 | item), {data})"


def r_files(source: ExportedDataSet) -> dict[str, bytes]:
    """Return `trials.csv` and `trials.R`. Equal data give equal bytes."""
    names = [column.name for column in source.columns]
    ordered = [row for _, _, rows in source.sessions() for row in rows]
    body = [[row.get(name) or "NA" for name in names] for row in ordered]
    return {"trials.csv": spreadsheet_text([names, *body]), "trials.R": _script(source, names).encode()}


def r_string(text: str) -> str:
    r"""Return any text as an R string literal on one line.

    >>> print(r_string('a "b"'), r_string("x" + chr(10) + "y"))
    "a \"b\"" "x\u{a}y"
    """
    return f'"{_escape(text, chr(34))}"'


def name(text: str) -> str:
    r"""Return a column name quoted for a formula.

    >>> print(name("force_n"), name("x; system('rm')"), name("a`b"))
    `force_n` `x; system('rm')` `a\`b`
    """
    return f"`{_escape(text, '`')}`"


def _escape(text: str, quote: str) -> str:
    signs = {"\\": "\\\\", quote: f"\\{quote}"}
    return "".join(signs.get(sign, sign if sign.isprintable() else f"\\u{{{ord(sign):x}}}") for sign in text)


def _script(source: ExportedDataSet, names: Sequence[str]) -> str:
    textual = {factor for factor in source.factors if not _is_number(source, factor)}.union(TEXT)
    kinds = ",\n      ".join(
        f'{r_string(cell_text(column))} = "{"character" if column in textual else "numeric"}"' for column in names
    )
    conditions = ["!is.na(response)"]
    conditions += ["valid == 1"] if "valid" in names else []
    conditions += [f"(is.na({flag}) | {flag} != 1)" for flag in ("practice", "catch") if flag in names]
    columns = [r_string(cell_text(factor)) for factor in source.factors]
    return SCRIPT.format(
        classes=kinds,
        used=" & ".join(conditions),
        factors="".join(f"used[[{column}]] <- factor(used[[{column}]])\n" for column in columns),
        forms="".join(_form(form) for form in source.forms.values()),
        models="\n".join(f"# {model}" for model in _models(source)),
    )


def _form(form: Questionnaire) -> str:
    return FORM.format(
        title=" ".join(form.title.split()),
        name=name(form.name),
        text=r_string(cell_text(form.name)),
        turned=", ".join(r_string(cell_text(item.id)) for item in form.items if item.reversed),
        sum=form.low + form.high,
    )


def _models(source: ExportedDataSet) -> Iterator[str]:
    """Yield a model for each task and each questionnaire."""
    scored = source.used["procedure"].isin(source.asked) if source.asked else pd.Series(False, source.used.index)
    for task in source.tasks():
        rows = source.used[(source.used["task"] == task) & ~scored]
        if len(rows):
            is_alone = source.tasks() == [task] and not scored.any()
            of_task = () if is_alone else (f"task == {r_string(task)}",)
            numbers = alternatives(rows, source.factors)
            for number, alike in rows.groupby(numbers):
                of_number = of_task if numbers.nunique() == 1 else (*of_task, _conditions(alike, source.factors))
                data = f"subset(used, {' & '.join(of_number)})" if of_number else "used"
                yield _fill_model(ANALYSES[task].r_model, alike, source, data, int(number))
    for form in source.forms.values():
        rows = source.used[scored & (source.used["procedure"] == form.name)]
        is_continuous = form.steps is None or form.steps > MOST_CATEGORIES
        yield _fill_model(CONTINUOUS if is_continuous else R_OF_FORM, rows, source, name(form.name))


def _conditions(rows: pd.DataFrame, factors: Sequence[str]) -> str:
    values = rows[list(factors)].drop_duplicates().itertuples(index=False, name=None)
    each = (
        " & ".join(f"{name(cell_text(key))} == {r_string(cell(at))}" for key, at in zip(factors, of, strict=True))
        for of in values
    )
    return f"({' | '.join(each)})"


def _fill_model(model: str, rows: pd.DataFrame, source: ExportedDataSet, data: str, n_choices: int = 2) -> str:
    varied = [name(cell_text(factor)) for factor in source.factors if rows[factor].nunique() > 1]
    times, plus = "".join(f" * {factor}" for factor in varied), " * ".join(varied) or "1"
    return model.format(times=times, plus=plus, data=data, n_choices=n_choices)


def _is_number(source: ExportedDataSet, name: str) -> bool:
    try:
        # A column without values counts as text.
        return bool([float(text) for row in source.rows if (text := row.get(name))])
    except ValueError:
        return False


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
"""Last columns, where PsychoPy writes the values that apply to the whole session."""

MS: Final = 1000.0
THEIRS = ("subject", "trial_type", "trial_index", "rt", "time_elapsed")
LEFT_OUT = ("participant", "task", "latency_s")
"""Columns with another name in jsPsych."""
COLUMNS = """\
{how_to_read}
[columns]
participant = "subject"
task = "trial_type"
latency_s = "rt"

[units]
latency_s = "ms"
{flags}"""
OF_A_FLAG = """
[values.{name}]
true = 1
false = 0
"""


def psychds_files(source: ExportedDataSet) -> dict[str, bytes]:
    """Return the Psych-DS files by path. Equal data give equal bytes."""
    names = [column.name for column in source.columns]
    study = (source.text("study") or "trials").replace("-", "")  # in file names, a hyphen separates key and value
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
    """Return PsychoPy files by path, with blocks and trials numbered from 0."""
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


def jspsych_files(source: ExportedDataSet) -> dict[str, bytes]:
    """Return jsPsych files by path, with times in ms and trials from 0."""
    names = [column.name for column in source.columns]
    clash = next((name for name in names if name in THEIRS), None)
    expect(
        not clash,
        "--to",
        f"jspsych, which uses the name {clash!r} itself",
        "another form, or another name of that column",
    )
    meanings = "".join(OF_A_FLAG.format(name=name) for name in names if name in FLAGS)
    files = {"columns.toml": COLUMNS.format(how_to_read=how_to_read(source.factors), flags=meanings).encode()}
    for participant, session, rows in source.sessions():
        study = source.text("study") or "study"
        trials = [_trial(n, row) for n, row in enumerate(rows)]
        text = ",\n".join(json.dumps(trial, ensure_ascii=False) for trial in trials)
        files[f"data/{participant}_{study}_session-{session}.json"] = f"[{text}]\n".encode()
    return files


def _trial(n: int, row: Row) -> dict[str, object]:
    onset_ms, rt_ms = _ms(row.get("onset_s", "")), _ms(row.get("latency_s", ""))
    known = [time_ms for time_ms in (onset_ms, rt_ms) if time_ms is not None]
    return {
        "subject": row["participant"],
        "trial_type": row["task"],
        "trial_index": n,
        "rt": rt_ms,
        "time_elapsed": sum(known) if onset_ms is not None else None,
        **{name: _value(name, text) for name, text in row.items() if name not in LEFT_OUT},
    }


def _ms(seconds: str) -> float | None:
    """
    >>> _ms("0.4735"), _ms("")
    (473.5, None)
    """
    return round(float(seconds) * MS, 3) if seconds else None


def _value(name: str, text: str) -> object:
    """Convert a cell to a bool, a number or null. Codes remain text.

    >>> _value("correct", "1"), _value("level", "34.0"), _value("item", ""), _value("pattern", "P0"), _value("x", "007")
    (True, 34.0, None, 'P0', '007')
    """
    if not text:
        return None
    if name in FLAGS:
        return text == "1"
    try:
        number = json_value(text)
    except ValueError:
        return text
    return number if json.dumps(number) == text and isinstance(number, int | float) else text


FORMS: Mapping[str, Callable[[ExportedDataSet], dict[str, bytes]]] = {
    "jspsych": jspsych_files,
    "psych-ds": psychds_files,
    "psychopy": psychopy_files,
    "r": r_files,
}


def export(path: Path, form: str, out: Path, authors: Sequence[str] = ()) -> list[Path]:
    """Write a data set or trials file in another form.

    The form is `bids` or one of `FORMS`. The folder must be new or empty.

    Raises `InvalidParameter` if the form is unknown or the folder is not empty. Raises `InvalidFile` if the data set is
    damaged. Raises `DeviceFailed` if the folder cannot be written.
    """
    one_of("--to", form, ("bids", *FORMS))
    source = read_source(path)
    files = bids_files(source, authors) if form == "bids" else FORMS[form](source)
    return write_files(chain(files.items(), traces_as(form, path, task_label(source), files)), out)
