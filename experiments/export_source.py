"""A data set as it is exported: its rows as text, with what its columns mean."""

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from tactometry.analysis.table import read_trials, trial_files
from tactometry.columns import ALWAYS, FIRST, OPTIONAL, Column
from tactometry.errors import DeviceFailed, InvalidParameter
from tactometry.quantity import unit_suffix

Row = Mapping[str, str]


@dataclass(frozen=True)
class Source:
    """`rows` as text in order, `columns` in order with their meaning, and what the data set says of itself."""

    rows: tuple[Row, ...]
    columns: tuple[Column, ...]
    factors: tuple[str, ...]
    title: str
    description: str

    def sessions(self) -> list[tuple[str, str, list[Row]]]:
        """Participant, session and rows of each session."""
        ordered = sorted(self.rows, key=_whose)
        return [(*key, list(part)) for key, part in groupby(ordered, key=_whose)]

    def text(self, name: str) -> str:
        """The one value of a column; empty if there are several or none.

        >>> Source(({"study": "a"}, {"study": "a"}), (), (), "", "").text("study")
        'a'
        """
        values = {row.get(name, "") for row in self.rows}
        return values.pop() if len(values) == 1 else ""


def _whose(row: Row) -> tuple[str, str]:
    return row["participant"], row.get("session") or "1"


def read_source(path: Path) -> Source:
    """The rows of a data set's folder or of one trials file, after the checks of `read_trials`.

    Raises
    ------
    InvalidFile
        If there is nothing to read, or a table is damaged.
    """
    trials = read_trials(path)
    rows: list[Row] = []
    for file in trial_files(path):
        with file.open(newline="", encoding="utf-8-sig") as text:
            rows += csv.DictReader(text, delimiter="\t" if file.suffix == ".tsv" else ",")
    told = _description(path)
    names = [name.strip() for name in rows[0]]
    title = str(told.get("name") or path.stem)
    return Source(
        rows=tuple(rows),
        columns=tuple(_column(name, told) for name in names),
        factors=trials.factors,
        title=title,
        description=str(told.get("description") or f"Trials of {title}."),
    )


def _description(path: Path) -> Mapping[str, object]:
    file = path / "dataset_description.json"
    if not file.is_file():
        return {}
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}


def _column(name: str, told: Mapping[str, object]) -> Column:
    known = {column.name: column for column in (*FIRST, *ALWAYS, *OPTIONAL)}
    if name in known:
        return known[name]
    variables = told.get("variableMeasured")
    for variable in variables if isinstance(variables, list) else []:
        if isinstance(variable, dict) and variable.get("name") == name:
            return Column(name, str(variable.get("description", "")) or name, str(variable.get("unitText", "")))
    return Column(name, f"Factor {name}", unit_suffix(name) or "")


def write_files(files: Mapping[str, bytes], folder: Path) -> list[Path]:
    """Write all files below a new or empty folder; their paths, sorted.

    Raises
    ------
    InvalidParameter
        If the folder holds something.
    DeviceFailed
        If the disk is full or fails.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InvalidParameter(f"--out: found that {folder} holds something, expected a new or an empty folder")
    written = []
    for name, content in sorted(files.items()):
        path = folder / name
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        except OSError as failure:
            raise DeviceFailed(
                f"{path}: cannot be written ({failure.strerror}), expected room and permission"
            ) from None
        written.append(path)
    return written


def separated(header: Sequence[str], rows: Sequence[Sequence[str]], separator: str) -> bytes:
    """A table as text with line feeds."""
    import io

    text = io.StringIO()
    writer = csv.writer(text, delimiter=separator, lineterminator="\n")
    writer.writerows([header, *rows])
    return text.getvalue().encode()


def pretty(value: object) -> bytes:
    """JSON for people, with sorted order as given."""
    return (json.dumps(value, indent=2, ensure_ascii=False) + "\n").encode()
