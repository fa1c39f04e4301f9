"""Whether a data set is sound: every defect, with file and row."""

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tactometry.dataset import Session, sessions, trials_csv
from tactometry.errors import InvalidFile, TactometryError
from tactometry.event import events_tsv
from tactometry.experiments.study import parse
from tactometry.experiments.wiring import Experiment, wire
from tactometry.formats import ADDED, columns_in
from tactometry.journal import Recording, read
from tactometry.provenance import sha256
from tactometry.rows import Defect, defects
from tactometry.sittings import changes

CSV_NAME = re.compile(r"[a-z]+-[a-zA-Z0-9]+(_[a-z]+-[a-zA-Z0-9]+)*_data\.csv")


@dataclass(frozen=True)
class Soundness:
    """What was found: a data set is sound if it has no defect; notes are no defects."""

    n_sessions: int
    n_trials: int
    defects: tuple[Defect, ...]
    notes: tuple[str, ...]


def validate(path: Path) -> Soundness:
    """Check a data set folder, or a single trials file.

    Raises
    ------
    InvalidFile
        If there is no such folder or file.
    """
    if path.is_file():
        return Soundness(1, n_rows(path), tuple(defects(_content(path), path.name)), ())
    if not path.is_dir():
        raise InvalidFile(f"{path}: found no such folder or file, expected a data set or a trials file")
    experiment, found = _study(path)
    notes: list[str] = []
    found += [*_description(path), *_trials_files(path)]
    for journal in sessions(path):
        found += _session(path, journal, experiment, notes)
    n_trials = sum(map(n_rows, _csv_files(path)))
    return Soundness(len(_csv_files(path)), n_trials, tuple(found), tuple(notes))


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InvalidFile(f"{path}: cannot read ({error.strerror}), expected a readable file") from None


def _csv_files(root: Path) -> list[Path]:
    return sorted((root / "data").glob("*.csv"))


def _study(root: Path) -> tuple[Experiment | None, list[Defect]]:
    path = root / "study.toml"
    if not path.is_file():
        return None, [Defect("study.toml", None, "found no such file, expected the study that ran")]
    try:
        return wire(parse(_content(path), "study.toml"), "study.toml"), []
    except TactometryError as error:
        return None, [Defect("study.toml", None, str(error).removeprefix("study.toml").lstrip(":, "))]


def _description(root: Path) -> Iterator[Defect]:
    name = "dataset_description.json"
    if not (root / name).is_file():
        yield Defect(name, None, "found no such file, expected the description that Psych-DS asks for")
        return
    try:
        description = json.loads(_content(root / name))
        described = {variable["name"] for variable in description["variableMeasured"]}
        wanted = {"@context": "https://schema.org/", "@type": "Dataset"}
        wrong = [key for key, value in wanted.items() if description.get(key) != value]
        missing = [key for key in ("name", "description") if not description.get(key)]
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        yield Defect(name, None, f"found no description ({type(error).__name__}: {error}), expected that of Psych-DS")
        return
    for key in (*wrong, *missing):
        yield Defect(name, None, f"{key}: found {description.get(key)!r}, expected {wanted.get(key, 'a text')!r}")
    for file in _csv_files(root):
        header = set(_header(file))
        for column in sorted(header - described | described - header - ADDED):
            where = "has no such column" if column in described else "has a column"
            yield Defect(name, None, f"variableMeasured: {file.name} {where} {column!r}, expected both to agree")


def _trials_files(root: Path) -> Iterator[Defect]:
    if not _csv_files(root):
        yield Defect("data", None, "found no trials file, expected at least one")
    stems = {path.stem for path in sessions(root)}
    for file in _csv_files(root):
        if not CSV_NAME.fullmatch(file.name):
            yield Defect(
                f"data/{file.name}",
                None,
                "found a name that Psych-DS forbids, expected key-value_..._data.csv",
            )
        if file.stem.removesuffix("_data") not in stems:
            yield Defect(f"data/{file.name}", None, "found no journal of this session, expected one in journals/")
        yield from _sidecar(file)
        yield from defects(_content(file), f"data/{file.name}")


def _sidecar(file: Path) -> Iterator[Defect]:
    sidecar = file.with_suffix(".json")
    name = f"data/{sidecar.name}"
    if not sidecar.is_file():
        yield Defect(name, None, "found no such file, expected the description of every column; use --resume")
        return
    try:
        described = list(json.loads(_content(sidecar)))
    except (ValueError, TypeError, RecursionError) as error:
        yield Defect(name, None, f"found no JSON ({error}), expected the description of every column; use --resume")
        return
    for column in _header(file):
        if column not in described:
            yield Defect(name, None, f"found no description of the column {column!r}, expected one; use --resume")


def _header(file: Path) -> list[str]:
    return _content(file).split(b"\n", 1)[0].decode("utf-8", "replace").strip().split(",")


def _session(root: Path, journal: Path, experiment: Experiment | None, notes: list[str]) -> Iterator[Defect]:
    name = f"journals/{journal.name}"
    try:
        recording = read(journal)
    except TactometryError as error:
        line = re.search(r"line (\d+): (.*)", str(error), re.DOTALL)
        yield Defect(name, int(line[1]) if line else None, line[2] if line else str(error))
        return
    if recording.head is None:
        yield from _not_begun(root, journal, notes)
        return
    notes += [f"{name}: {change}" for change in changes(recording.sittings)]
    if not recording.complete:
        notes.append(f"{name}: the session is not finished ({len(recording.trials)} trials); go on with --resume")
    if experiment is None:
        return
    if sha256(_content(root / "study.toml")) != recording.head.study_sha256:
        yield Defect(name, 1, "found the digest of another study.toml, expected that of this data set")
    else:
        yield from _agreement(root, journal, recording, experiment)
        yield from _events(journal, recording)


def _not_begun(root: Path, journal: Path, notes: list[str]) -> Iterator[Defect]:
    if n_rows(trials_file(root, journal)):
        yield Defect(f"journals/{journal.name}", None, "found no trial, expected those of the trials file")
    else:
        notes.append(f"journals/{journal.name}: the session has not begun; start it with --resume")


def trials_file(root: Path, journal: Path) -> Path:
    """The trials file of a journal."""
    return root / "data" / f"{journal.stem}_data.csv"


def n_rows(path: Path) -> int:
    """Rows of a trials file below its header; 0 where there is none."""
    return max(_content(path).count(b"\n") - 1, 0) if path.is_file() else 0


def _agreement(root: Path, journal: Path, recording: Recording, experiment: Experiment) -> Iterator[Defect]:
    """Whether the trials file is what the journal says."""
    assert recording.head is not None
    file = trials_file(root, journal)
    if not file.is_file():
        yield Defect(f"data/{file.name}", None, "found no such file, expected the trials of the journal; use --resume")
        return
    row = first_difference(_content(file), derived_csv(recording, experiment))
    if row is not None:
        yield Defect(f"data/{file.name}", row, "found another row than the journal holds, expected the same")


def _events(journal: Path, recording: Recording) -> Iterator[Defect]:
    """Whether the events file is what the journal says."""
    file = journal.with_name(f"{journal.stem}_events.tsv")
    name = f"journals/{file.name}"
    if not file.is_file():
        if recording.events:
            yield Defect(name, None, "found no such file, expected the events of the journal; use --resume")
        return
    row = first_difference(_content(file), events_tsv(recording.events))
    if row is not None:
        yield Defect(name, row, "found another row than the journal holds, expected the same; use --resume")
    if not file.with_suffix(".json").is_file():
        yield Defect(name, None, "found no description of its columns beside it, expected a JSON file; use --resume")


def derived_csv(recording: Recording, experiment: Experiment) -> bytes:
    """The trials file that a journal stands for."""
    assert recording.head is not None
    head = recording.head
    columns = columns_in(experiment.design(b"").columns, head.format)
    return trials_csv(recording.trials, Session(head.participant, head.session, head.study), head.rig, columns)


def first_difference(found: bytes, expected: bytes) -> int | None:
    """The first line, from 1, in which two files differ; None if they are equal."""
    if found == expected:
        return None
    pairs = zip(found.split(b"\n"), expected.split(b"\n"), strict=False)
    alike = next((n for n, (a, b) in enumerate(pairs, 1) if a != b), None)
    return alike if alike is not None else min(found.count(b"\n"), expected.count(b"\n")) + 1
