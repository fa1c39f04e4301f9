"""Trials files that no longer say what their journals hold: somebody edited them, or a crash cut them."""

import json
from pathlib import Path

from tactometry.errors import TactometryError, counted
from tactometry.files.durable import read_file
from tactometry.records.agreement import disagreement
from tactometry.records.data_set import trials_csv
from tactometry.records.journal import read
from tactometry.trials.columns import Column

from .session_files import header_of, session_of


def edit_warnings(path: Path) -> list[str]:
    """A warning if trials files of a data set, or the one that `path` is, differ from the journals beside them.

    Empty where there is no journal. What cannot be compared is told too.
    """
    root = path if path.is_dir() else path.parent.parent
    files = sorted(path.glob("data/*_data.csv")) if path.is_dir() else [path]
    pairs = [(file, root / "journals" / f"{file.stem.removesuffix('_data')}.jsonl") for file in files]
    known = [(file, journal) for file, journal in pairs if journal.is_file()]
    texts = [text for file, journal in known if (text := _difference(file, journal)) is not None]
    if not texts:
        return []
    differ = "differs from its journal" if len(texts) == 1 else "differ from their journals"
    return [
        f"{len(texts)} of {counted(len(known), 'trials file')} {differ}, and what stands in the table is analysed: "
        f"{texts[0]}{'; tactometry validate names all' if len(texts) > 1 else ''}"
    ]


def _difference(file: Path, journal: Path) -> str | None:
    """How a trials file differs from its journal."""
    content = read_file(file, "a trials file")
    names = header_of(content)
    try:
        recording = read(journal)
    except TactometryError as damage:
        return f"{file.name}: {damage}"
    head = recording.head
    if head is None:
        return None if content.count(b"\n") < 2 else f"{file.name}: holds trials, and its journal none"
    described = _description_columns(file)
    if described and names != described:
        return f"{file.name}, row 1: found other columns than {file.with_suffix('.json').name} describes"
    columns = [Column(name, "") for name in described or names]
    try:
        expected = trials_csv(recording.trials, session_of(head), head.rig, columns)
    except KeyError as unknown:
        return f"{file.name}, row 1: found the column {unknown}, which the journal does not hold"
    differs = disagreement(content, expected)
    return None if differs is None else f"{file.name}, row {differs[0]}: {differs[1]}"


def _description_columns(file: Path) -> list[str]:
    """The columns that the description beside a trials file names, in their order; empty without one."""
    try:
        described = json.loads(file.with_suffix(".json").read_bytes())
    except (OSError, ValueError, RecursionError):
        return []
    return list(described) if isinstance(described, dict) else []
