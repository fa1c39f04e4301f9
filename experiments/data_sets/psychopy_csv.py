"""A data set in the form that PsychoPy's experiment handler writes: a row per trial, a file per session.

For scripts and people that read PsychoPy's files; `columns.toml` beside them reads them back with `--columns`.
"""

import shlex
from collections.abc import Sequence

from tactometry.files.safe_text import cell_text

from .source import ExportedDataSet, delimited_text

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


def psychopy_files(source: ExportedDataSet) -> dict[str, bytes]:
    """Every file, by its path; the same data give the same bytes. Numbers of blocks and trials start at 0 there."""
    names = [column.name for column in source.columns]
    ordered = [*(name for name in names if name not in LAST), *(name for name in LAST if name in names)]
    header = [RENAMED.get(name, name) for name in ordered]
    files = {"columns.toml": _column_map(ordered, source.factors).encode()}
    for participant, session, rows in source.sessions():
        study = source.text("study") or "study"
        body = [[_cell(name, row.get(name, "")) for name in ordered] for row in rows]
        files[f"data/{participant}_{study}_session-{session}.csv"] = delimited_text(header, body, ",")
    return files


def _cell(name: str, text: str) -> str:
    return str(int(float(text)) - 1) if name in FROM_ZERO and text else text


def _column_map(names: Sequence[str], factors: Sequence[str]) -> str:
    named = " ".join(",".join(map(cell_text, factors)).split())
    within = f" --within {shlex.quote(named)}" if factors else ""
    lines = [f'{name} = "{RENAMED[name]}"' for name in names if name in RENAMED and name not in FROM_ZERO]
    return "\n".join([f"# tactometry analyse . --columns columns.toml{within}", "[columns]", *lines, ""])
