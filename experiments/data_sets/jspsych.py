"""Export to jsPsych: a JSON file for each session, an object for each trial."""

import json
from typing import Final

from tactometry.arguments.require import expect
from tactometry.files.json_file import json_value
from tactometry.trials.row_rules import FLAGS

from .source import ExportedDataSet, Row, how_to_read

MS: Final = 1000.0
THEIRS = ("subject", "trial_type", "trial_index", "rt", "time_elapsed")
LEFT_OUT = ("participant", "task", "latency_s")
"""They stand under jsPsych's own names."""
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


def jspsych_files(source: ExportedDataSet) -> dict[str, bytes]:
    """Return the files by path, with times in ms and trials from 0."""
    names = [column.name for column in source.columns]
    clash = next((name for name in names if name in THEIRS), None)
    expect(
        not clash, "--to", f"jspsych, which has a {clash!r} of its own", "another form, or another name of that column"
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
    """Return a cell as jsPsych has it: bool, number or null; codes stay text.

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
