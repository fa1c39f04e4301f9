"""Files of a session, and checks that they agree with its journal."""

import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from tactometry.errors import InvalidFile, TactometryError, count_of
from tactometry.files.durable import read_file
from tactometry.files.json_file import json_object
from tactometry.provenance import digest_of
from tactometry.records.data_set import REBUILD, Session, disagreement, trials_csv
from tactometry.records.head import Head, columns_in
from tactometry.records.journal import Recording, read
from tactometry.trials.columns import Column
from tactometry.trials.row_rules import Defect
from tactometry.trials.trial import Trial

from ..study.experiment import Experiment

OTHER_STUDY = "found the digest of another study.toml, expected that of this data set"


def session_of(head: Head) -> Session:
    return Session(head.participant, head.session, head.study)


def name_defect(journal: Path, head: Head) -> str | None:
    """Return an error if a journal is not named after its session, else None.

    A renamed copy would otherwise count as another session.
    """
    if session_of(head).stem == journal.stem:
        return None
    whose = f"session {head.session} of {head.participant} ({head.study})"
    return f"found {whose}, expected the session in the file name; remove the copy"


def header_of(content: bytes) -> list[str]:
    """Return the column names in the bytes of a trials file.

    >>> header_of(b"a,b\\n1,2\\n")
    ['a', 'b']
    """
    return content.split(b"\n", 1)[0].decode("utf-8-sig", "replace").strip().split(",")


def trials_file(root: Path, journal: Path) -> Path:
    """Return the trials file of a journal."""
    return root / "data" / f"{journal.stem}_data.csv"


def n_rows(content: bytes) -> int:
    """Count the rows of a trials file below its header.

    >>> n_rows(b"a,b\\n1,2\\n3,4"), n_rows(b"")
    (2, 0)
    """
    return max(sum(bool(line.strip()) for line in content.split(b"\n")) - 1, 0)


def json_table(path: Path) -> Mapping[str, Any]:
    """Return the object of a JSON file, or {} if the file has none."""
    try:
        return json_object(path, "a JSON object")
    except InvalidFile:
        return {}


def has_rows(root: Path, journal: Path) -> bool:
    """Return True if the trials file of a journal exists and has rows."""
    path = trials_file(root, journal)
    return os.path.lexists(path) and n_rows(read_file(path, "a trials file")) > 0


def derived_defects(file: Path, name: str, what: str, rows: str, expected: bytes) -> Iterator[Defect]:
    """Yield defects where a file differs from its journal."""
    if not os.path.lexists(file):
        yield Defect(name, None, f"found no such file, expected the {rows} of the journal; {REBUILD}")
        return
    differs = disagreement(read_file(file, what), expected)
    if differs is not None:
        yield Defect(name, *differs)


def trials_defects(root: Path, journal: Path, recording: Recording, experiment: Experiment) -> Iterator[Defect]:
    """Yield defects where a trials file differs from its journal."""
    assert recording.head is not None
    file = trials_file(root, journal)
    columns = columns_in(experiment.design(b"").columns, recording.head.format)
    expected = trials_csv(recording.trials, session_of(recording.head), recording.head.rig, columns)
    yield from derived_defects(file, f"data/{file.name}", "a trials file", "trials", expected)


def edit_warnings(path: Path) -> list[str]:
    """Return warnings for trials files that differ from their journals.

    Files without a journal are skipped. A file that cannot be compared is also reported.
    """
    root = path if path.is_dir() else path.parent.parent
    files = sorted(path.glob("data/*_data.csv")) if path.is_dir() else [path]
    journals = {file: root / "journals" / f"{file.stem.removesuffix('_data')}.jsonl" for file in files}
    known = [file for file in files if journals[file].is_file()]
    texts = [text for file in known if (text := _difference(file, journals[file])) is not None]
    if not texts:
        return []
    differ = "differs from its journal" if len(texts) == 1 else "differ from their journals"
    return [
        f"{len(texts)} of {count_of(len(known), 'trials file')} {differ}, but the tables are analysed unchanged: "
        f"{texts[0]}{'; tactometry validate lists all' if len(texts) > 1 else ''}"
    ]


def _difference(file: Path, journal: Path) -> str | None:
    content = read_file(file, "a trials file")
    names = header_of(content)
    try:
        recording = read(journal)
    except TactometryError as damage:
        return f"{file.name}: {damage}"
    head = recording.head
    if head is None:
        return None if content.count(b"\n") < 2 else f"{file.name}: contains trials, but its journal has none"
    described = list(json_table(file.with_suffix(".json")))
    if described and names != described:
        return f"{file.name}, row 1: found other columns than {file.with_suffix('.json').name} describes"
    columns = [Column(name, "") for name in described or names]
    try:
        expected = trials_csv(recording.trials, session_of(head), head.rig, columns)
    except KeyError as unknown:
        return f"{file.name}, row 1: found the column {unknown}, which the journal does not contain"
    differs = disagreement(content, expected)
    return None if differs is None else f"{file.name}, row {differs[0]}: {differs[1]}"


WHAT = "the positions of a session"


def paths_in(content: bytes) -> dict[str, bytes]:
    """Return the rows (time and position) of each path, by its digest.

    >>> paths_in(b"positions_digest\\ttime_s\\tposition_m\\nab\\t0.001000\\t0.050000000\\n")
    {'ab': b'0.001000\\t0.050000000\\n'}
    """
    paths: dict[str, list[bytes]] = {}
    for line in content.splitlines()[1:]:
        digest, _, place = line.partition(b"\t")
        paths.setdefault(digest.decode("ascii", "replace"), []).append(place + b"\n")
    return {digest: b"".join(lines) for digest, lines in paths.items()}


def positions_defects(journal: Path, trials: Iterable[Trial]) -> Iterator[Defect]:
    """Yield defects for texture trials whose path is missing or differs."""
    required = dict.fromkeys(trial.positions_digest for trial in trials if trial.positions_digest is not None)
    file = journal.with_name(f"{journal.stem}_positions.tsv")
    name = f"journals/{file.name}"
    if not required:
        return
    if not file.is_file():
        yield Defect(
            name, None, f"found no such file, expected the positions of {len(required)} trials; restore a copy"
        )
        return
    paths = paths_in(read_file(file, WHAT))
    for digest in required:
        lines = paths.get(digest, b"")  # A touch during which the sensor was silent has an empty path, without rows.
        if digest_of(lines) != digest:
            found = "another path than the recorded one" if lines else "no path"
            yield Defect(name, None, f"found {found} under {digest}, expected the recorded path; restore a copy")
