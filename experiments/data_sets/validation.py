"""Validate a data set, and report every defect with its file and row."""

import csv
import io
import os
import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from tactometry.errors import InvalidFile, InvalidParameter, TactometryError, count_of
from tactometry.files.durable import drafts, files_in, read_file
from tactometry.files.json_file import json_object
from tactometry.provenance import sha256
from tactometry.records.data_set import REBUILD, keys_of, participants, sessions
from tactometry.records.description import NAME, SIMULATED, read_description, variable_names
from tactometry.records.erasures import RECORD, read_erasures
from tactometry.records.head import ADDED, changes, columns_in, heads
from tactometry.records.journal import Recording, read
from tactometry.records.traces import FOLDER, read_sidecar, sidecar_of
from tactometry.session.event import COLUMNS, events_tsv
from tactometry.trials.row_rules import Defect, defects, merge_alike
from tactometry.trials.trial import tally

from ..study.experiment import Experiment, wire
from ..study.study_file import parse
from .session_files import (
    OTHER_STUDY,
    derived_defects,
    has_rows,
    header_of,
    n_rows,
    name_defect,
    positions_defects,
    trials_defects,
)
from .traces import trace_defects

CSV_NAME = re.compile(r"[a-z]+-[a-zA-Z0-9]+(_[a-z]+-[a-zA-Z0-9]+)*_data\.csv")


@dataclass(frozen=True)
class Soundness:
    """Result of a validation. Defects make a data set invalid, notes do not."""

    n_sessions: int
    n_trials: int
    defects: tuple[Defect, ...]
    notes: tuple[str, ...]


def validate(path: Path) -> Soundness:
    """Check a data set folder, or a single trials file.

    Raises `InvalidFile` if the folder or file does not exist or cannot be read.
    """
    if path.is_dir():
        return _data_set(path)
    if not os.path.lexists(path):
        raise InvalidFile(f"{path}: found no such folder or file, expected a data set or a trials file")
    content = read_file(path, "a data set or a trials file")
    n_trials, unsound = n_rows(content), list(defects(content, path.name))
    if not unsound and n_trials == 0:
        unsound = [Defect(path.name, None, "found only a header, expected a row for each trial")]
    unsound += _refusals(path) if not unsound else ()
    return Soundness(1, n_trials, tuple(merge_alike(unsound)), ())


def _data_set(root: Path) -> Soundness:
    unsound: list[Defect] = []
    experiment = _study(root, unsound)
    notes = [*_codes_by_capitals(root), *_drafts(root)]
    files, journals = files_in(root / "data", "*.csv"), sessions(root)
    contents = {file: content for file in files if (content := _read(file, f"data/{file.name}", unsound)) is not None}
    unsound += _with_unreadable(root, NAME, _description(root, contents))
    n_erased = _erasures(root, unsound, notes)
    if not files and not n_erased:
        unsound.append(Defect("data", None, "found no trials file, expected at least one"))
    stems = [path.stem for path in journals]
    for file, content in contents.items():
        unsound += _with_unreadable(root, f"data/{file.name}", _trials_file(file, content, stems))
    unsound += _mixture(journals)
    for journal in journals:
        unsound += _with_unreadable(root, f"journals/{journal.name}", _session(root, journal, experiment, notes))
    unsound += _trace_descriptions(root)
    different = dict.fromkeys(unsound)  # a session and its trace files may report the same defect
    return Soundness(len(files), sum(map(n_rows, contents.values())), tuple(merge_alike(different)), tuple(notes))


def _trace_descriptions(root: Path) -> Iterator[Defect]:
    """Yield unreadable trace descriptions, including those in no journal."""
    for file in files_in(root / FOLDER, "*.tsv.gz"):
        try:
            read_sidecar(sidecar_of(file))
        except InvalidFile as error:
            yield _unreadable(root, FOLDER, error)


def _refusals(path: Path) -> Iterator[Defect]:
    """Yield errors of `analyse` and `export` for an otherwise valid file."""
    from .source import read_source  # slow to load

    try:
        read_source(path)
    except TactometryError as error:
        yield _unreadable(path.parent, path.name, error)


def _with_unreadable(root: Path, name: str, unsound: Iterator[Defect]) -> Iterator[Defect]:
    """Yield defects, and a last one for an unreadable file."""
    try:
        yield from unsound
    except InvalidFile as error:
        yield _unreadable(root, name, error)


def _unreadable(root: Path, name: str, error: TactometryError) -> Defect:
    """Return an error as a defect of the file it names, or of `name`."""
    path, _, what = str(error).partition(": ")
    within = Path(path).is_relative_to(root)
    return Defect(Path(path).relative_to(root).as_posix() if within else name, None, what if within else str(error))


def _read(file: Path, name: str, unsound: list[Defect], what: str = "a trials file") -> bytes | None:
    try:
        return read_file(file, what)
    except InvalidFile as error:
        unsound.append(Defect(name, None, str(error).removeprefix(f"{file}: ")))
        return None


def _codes_by_capitals(root: Path) -> Iterator[str]:
    for _, group in groupby(sorted(participants(root), key=str.casefold), key=str.casefold):
        codes = list(group)
        if len(codes) > 1:
            yield f"journals: {' and '.join(codes)} differ only in capital letters, which some disks do not distinguish"


def _mixture(journals: list[Path]) -> Iterator[Defect]:
    """Yield a defect if people and simulated participants are in one folder."""
    kinds: dict[bool, list[str]] = {}
    for journal in journals:
        with suppress(InvalidFile):  # `_session` reports damaged journals
            for head in heads(journal)[:1]:
                kinds.setdefault(head.rig == SIMULATED, []).append(head.participant)
    if len(kinds) > 1:
        text = f"found simulated participants ({kinds[True][0]}, ...) next to people ({kinds[False][0]}, ...), expected"
        yield Defect("journals", None, f"{text} only one kind: move one to a separate folder")


def _drafts(root: Path) -> Iterator[str]:
    for folder in (root, root / "data", root / "journals"):
        for path in drafts(folder):
            way = "remove it" if folder == root else "tactometry rebuild removes it"
            yield f"{path.relative_to(root)}: a temporary file left by an interruption; {way}"


def _erasures(root: Path, unsound: list[Defect], notes: list[str]) -> int:
    """Add a note or a defect per erasure, and return their number."""
    try:
        erasures = read_erasures(root)
    except InvalidFile as error:
        unsound.append(Defect(RECORD, None, str(error).removeprefix(f"{root / RECORD}").lstrip(":, ")))
        return 0
    for number, erasure in enumerate(erasures, 1):
        who = erasure.participant
        if erasure.finished_utc is None:
            text = f"found an unfinished erasure of {who}, expected a finished one; repeat tactometry erase"
            unsound.append(Defect(RECORD, number, text))
        else:
            sessions_of = count_of(erasure.n_sessions, "session")
            notes.append(f"{RECORD}: {who} ({sessions_of}) was erased at {erasure.finished_utc}")
    return len(erasures)


def _study(root: Path, unsound: list[Defect]) -> Experiment | None:
    content = _read(root / "study.toml", "study.toml", unsound, "the study that ran")
    try:
        return None if content is None else wire(parse(content, "study.toml"), "study.toml", plays=False)
    except TactometryError as error:
        unsound.append(Defect("study.toml", None, str(error).removeprefix("study.toml").lstrip(":, ")))
        return None


def _description(root: Path, contents: dict[Path, bytes]) -> Iterator[Defect]:
    name = NAME
    if not os.path.lexists(root / name):
        yield Defect(name, None, "found no such file, expected the description that Psych-DS requires")
        return
    description = read_description(root / name)
    expected = {"@context": "https://schema.org/", "@type": "Dataset"}
    wrong = [key for key, value in expected.items() if description.get(key) != value]
    texts = {key: description.get(key) for key in ("name", "description")}
    missing = [key for key, text in texts.items() if not text or not isinstance(text, str)]
    for key in (*wrong, *missing):
        yield Defect(name, None, f"{key}: found {description.get(key)!r:.60}, expected {expected.get(key, 'a text')!r}")
    try:
        described = set(variable_names(description))
    except InvalidParameter as error:
        yield Defect(name, None, str(error))
        return
    for file, content in contents.items():
        header = set(header_of(content))
        for column in sorted(header - described | described - header - ADDED):
            where = "has no such column" if column in described else "has a column"
            yield Defect(name, None, f"variableMeasured: {file.name} {where} {column!r}, expected both to agree")


def _trials_file(file: Path, content: bytes, stems: list[str]) -> Iterator[Defect]:
    name = f"data/{file.name}"
    if not CSV_NAME.fullmatch(file.name):
        yield Defect(name, None, "found a name that Psych-DS forbids, expected key-value_..._data.csv")
    if file.stem.removesuffix("_data") not in stems:
        yield Defect(name, None, "found no journal of this session, expected one in journals/")
    yield from defects(content, name)
    yield from _strange_rows(file, content)
    yield from _sidecar(file, header_of(content))


def _strange_rows(file: Path, content: bytes) -> Iterator[Defect]:
    """Yield a defect for the first row of another session or study."""
    named = keys_of(file.stem)
    try:
        header, *rows = csv.reader(io.StringIO(content.decode("utf-8-sig"), newline=""))
    except (UnicodeDecodeError, csv.Error, ValueError):
        return
    for key in ("participant", "session", "study"):
        if key not in named or key not in header:
            continue
        place = header.index(key)
        for number, cells in enumerate(rows, 2):
            value = "".join(cells[place : place + 1])  # empty if the row ends before the column
            if value.replace("-", "") != named[key]:  # file names use hyphens only after their keys
                text = f"column {key!r}: found {value!r}, expected {named[key]!r} as in"
                yield Defect(f"data/{file.name}", number, f"{text} the file's name")
                return


def _sidecar(file: Path, header: list[str]) -> Iterator[Defect]:
    sidecar = file.with_suffix(".json")
    name = f"data/{sidecar.name}"
    if not os.path.lexists(sidecar):
        yield Defect(name, None, f"found no such file, expected the description of every column; {REBUILD}")
        return
    described = json_object(sidecar, f"the description of every column; {REBUILD}")
    for column in header:
        if column not in described:
            yield Defect(name, None, f"found no description of the column {column!r}, expected one; {REBUILD}")


def _session(root: Path, journal: Path, experiment: Experiment | None, notes: list[str]) -> Iterator[Defect]:
    name = f"journals/{journal.name}"
    try:
        recording = read(journal)
    except TactometryError as error:
        line = re.search(r"line (\d+): (.*)", str(error), re.DOTALL)
        yield Defect(name, int(line[1]) if line else None, line[2] if line else str(error).removeprefix(f"{journal}: "))
        return
    head = recording.head
    if head is None:
        yield from _not_begun(root, journal, notes)
        return
    wrong_name = name_defect(journal, head)
    if wrong_name is not None:
        yield Defect(name, 1, wrong_name)
    notes += [f"{name}: {change}" for change in changes(recording.sittings)]
    if recording.complete and recording.n_torn_bytes:
        n_bytes, kept = count_of(recording.n_torn_bytes, "byte"), f"{journal.stem}_interruptions.jsonl"
        text = f"found {n_bytes} after the end of the session, expected none; tactometry rebuild moves them to {kept}"
        yield Defect(name, len(recording.lines) + 2, text)
    if not recording.complete:
        notes.append(f"{name}: the session is not finished ({tally(recording.trials)}); continue with --resume")
    if experiment is None:
        return
    if sha256(read_file(root / "study.toml", "the study that ran")) != head.study_sha256:
        yield Defect(name, 1, OTHER_STUDY)
    else:
        yield from trials_defects(root, journal, recording, experiment)
        yield from _events(journal, recording)
        yield from positions_defects(journal, recording.trials)
        yield from trace_defects(root, recording)


def _not_begun(root: Path, journal: Path, notes: list[str]) -> Iterator[Defect]:
    if has_rows(root, journal):
        yield Defect(f"journals/{journal.name}", None, "found no trials, expected those of the trials file")
    else:
        notes.append(f"journals/{journal.name}: the session has not begun; start it with --resume")


def _events(journal: Path, recording: Recording) -> Iterator[Defect]:
    """Yield defects for an events file that differs from its journal."""
    file = journal.with_name(f"{journal.stem}_events.tsv")
    name = f"journals/{file.name}"
    if os.path.lexists(file) or recording.event_rows:
        expected = events_tsv(recording.event_rows, columns_in(COLUMNS, recording.format))
        yield from derived_defects(file, name, "an events file", "events", expected)
    if os.path.lexists(file) and not file.with_suffix(".json").is_file():
        yield Defect(name, None, f"found no description of its columns next to it, expected a JSON file; {REBUILD}")
