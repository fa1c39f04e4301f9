"""A data set on disk, after Psych-DS: one journal and one trials file per session.

The journal is the truth; the trials file, its description and the data set's description are derived from it and the
study, and can be rebuilt.
"""

import csv
import io
import os
import re
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from tactometry.columns import FIRST, Column
from tactometry.description import NAME, SIMULATED, Design, describe, is_marked, read_description, sidecar_json
from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.event import COLUMNS, Event, events_tsv
from tactometry.files import make_folder, read_file, replaced, write_atomically, write_first, write_whole
from tactometry.formats import FORMAT, as_kept, columns_in
from tactometry.journal import Head, Journal
from tactometry.request import Record, Request
from tactometry.rigs.replay import Replay
from tactometry.sittings import heads
from tactometry.trial import Trial, Value

PARTICIPANT = re.compile(r"[A-Za-z0-9]{1,32}")
STUDY = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")


@dataclass(frozen=True)
class Session:
    """One session of one participant.

    Raises
    ------
    InvalidParameter
        If the code is not 1 to 32 letters and digits, or the session number is below 1.

    >>> Session("P01", 1, "electrovibration-threshold").stem
    'participant-P01_session-1_study-electrovibrationthreshold'
    """

    participant: str
    session: int
    study: str

    def __post_init__(self) -> None:
        if not PARTICIPANT.fullmatch(self.participant):
            raise InvalidParameter(
                f"participant: found {self.participant!r}, expected a code of 1 to 32 letters and digits (A-Z, a-z, "
                "0-9), such as P01: no names, no paths"
            )
        if self.session < 1:
            raise InvalidParameter(f"session: found {self.session}, expected a number from 1")

    @property
    def stem(self) -> str:
        return f"participant-{self.participant}_session-{self.session}_study-{self.study.replace('-', '')}"

    def journal(self, root: Path) -> Path:
        return root / "journals" / f"{self.stem}.jsonl"

    def events(self, root: Path) -> Path:
        return root / "journals" / f"{self.stem}_events.tsv"

    def trials(self, root: Path) -> Path:
        return root / "data" / f"{self.stem}_data.csv"

    def sidecar(self, root: Path) -> Path:
        return root / "data" / f"{self.stem}_data.json"


def cell(value: Value) -> str:
    """A value as a cell: empty for None, 1/0 for a truth value, the shortest form that reads back for a number.

    >>> cell(True), cell(12.0), cell(0.1), cell(None)
    ('1', '12', '0.1', '')
    """
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return str(int(value))
    return repr(value) if isinstance(value, float) else str(value)


def row(trial: Trial, session: Session, rig: str, columns: Sequence[Column]) -> list[str]:
    """The cells of a trial."""
    known: dict[str, Value] = {
        **asdict(session),
        "rig": rig,
        **{name: value for name, value in vars(trial).items() if name not in ("factors", "extra")},
        **trial.factors,
        **trial.extra,
    }
    return [cell(known[column.name]) for column in columns]


def csv_bytes(rows: Sequence[Sequence[str]]) -> bytes:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue().encode()


def trials_csv(trials: Sequence[Trial], session: Session, rig: str, columns: Sequence[Column]) -> bytes:
    """The trials file of a session."""
    header = [column.name for column in columns]
    return csv_bytes([header, *(row(trial, session, rig, columns) for trial in trials)])


def events_json() -> bytes:
    """The description of every column of an events file."""
    return sidecar_json(COLUMNS)


def prepare(root: Path, design: Design) -> None:
    """Make the folders and the files that all sessions share.

    Raises
    ------
    InvalidFile
        If the folder holds another study, or other numbers of this one, or something else.
    """
    for folder in (root, root / "data", root / "journals"):
        make_folder(folder)
    path = root / "study.toml"
    if (root / NAME).exists() and not path.exists():
        raise InvalidFile(
            f"{root / NAME}: found the description of a data set without its study.toml, expected both or none; give "
            "another --out folder"
        )
    write_first(path, design.study_toml)
    if read_file(path, "the study that ran") != design.study_toml:
        raise InvalidFile(
            f"{path}: found another study or other numbers than those that are to run, expected the same bytes; give "
            "another --out folder, or run the study.toml of this one"
        )


def refuse_mixing(root: Path, rig: str) -> None:
    """Refuse simulated participants beside people, and people beside simulated participants.

    Raises
    ------
    InvalidFile
        If the folder holds the other kind.
    """
    path = root / NAME
    if path.exists() and is_marked(read_description(path)):
        held = {SIMULATED}
    else:
        held = {head.rig for journal in sessions(root) for head in heads(journal)[:1]}
    for other in sorted(held):
        if (other == SIMULATED) != (rig == SIMULATED):
            whom = "simulated participants" if other == SIMULATED else "people"
            raise InvalidFile(
                f"{root}: found sessions of {whom}, expected none beside those of the rig {rig!r}, as real and "
                "simulated data never share a folder; give another --out"
            )


class OpenSession:
    """A session that is being recorded: what `tactometry.run.run` writes to.

    Each trial is flushed and fsynced in the journal, and flushed in the trials file, before `append` returns.
    With `resume` an interrupted session goes on; what the crash cut off is kept beside the journal, and said in
    `repaired`.
    """

    def __init__(self, root: Path, design: Design, session: Session, rig: str, *, resume: bool) -> None:
        own = session.journal(root)
        if not own.is_file() or own.stat().st_size == 0:  # one that has begun is held against its own head
            refuse_mixing(root, rig)
        prepare(root, design)
        self._root, self._session = root, session
        self._file = self._events_file = -1
        self.recorded_s: float | None = None
        """When the last trial was on the disk, on `time.perf_counter`."""
        self.journal = Journal(session.journal(root), resume=resume)
        try:
            self._rig = rig if self.head is None else self.head.rig
            self.format = FORMAT if self.head is None else self.head.format
            self._columns = columns_in(design.columns, self.format)
            told = replace(design, columns=self._columns)
            describe(root, told, is_simulated=self._rig == SIMULATED and self.format > 1)
            self.n_trials = len(self.journal.recording.trials)
            self.repaired = self._repaired()
            self._rebuild()
        except BaseException:
            self.journal.close()
            raise

    @property
    def head(self) -> Head | None:
        return self.journal.head

    @property
    def sittings(self) -> tuple[Head, ...]:
        """The heads of the sittings before."""
        return self.journal.recording.sittings

    @property
    def replay(self) -> Replay:
        return self.journal.replay

    @property
    def trials(self) -> Path:
        """The trials file."""
        return self._trials

    @property
    def complete(self) -> bool:
        return self.journal.recording.complete

    def begin(self, head: Head) -> None:
        self.journal.begin(head)

    def note(self, event: Event) -> None:
        """Keep what happened unasked, in the journal and in the events file."""
        self.journal.note(event)
        if self._events_file < 0:
            self._events_file = self._new_events(())
        line = events_tsv([event]).partition(b"\n")[2]
        write_whole(self._events_file, line, self._session.events(self._root), durable=False)

    def append(self, request: Request, answer: object) -> None:
        request = as_kept(request, self.format)
        self.journal.append(request, answer)
        if isinstance(request, Record):
            self.recorded_s = time.perf_counter()
            line = csv_bytes([row(request.trial, self._session, self._rig, self._columns)])
            write_whole(self._file, line, self._trials, durable=False)
            self.n_trials += 1

    def finish(self) -> None:
        self.journal.finish()

    def close(self) -> None:
        self.journal.close()
        for file in (self._file, self._events_file):
            if file >= 0:
                os.fsync(file)
                os.close(file)
        self._file = self._events_file = -1

    def _rebuild(self) -> None:
        self._trials, recording = self._session.trials(self._root), self.journal.recording
        write_atomically(self._session.sidecar(self._root), sidecar_json(self._columns))
        table = trials_csv(recording.trials, self._session, self._rig, self._columns)
        self._file = replaced(self._trials, table)
        if recording.events:
            self._events_file = self._new_events(recording.events)

    def _new_events(self, events: Sequence[Event]) -> int:
        path = self._session.events(self._root)
        write_atomically(path.with_suffix(".json"), events_json())
        return replaced(path, events_tsv(events))

    def _repaired(self) -> str | None:
        cut = self.journal.cut
        if not cut:
            return None
        return (
            f"the last sitting was cut off after trial {self.n_trials}; {len(cut)} bytes of the trial that was under "
            f"way are kept in {self.journal.interruptions.name}, and that trial is asked again"
        )


def sessions(root: Path) -> list[Path]:
    """The journals of a data set, sorted."""
    found = (path for path in (root / "journals").glob("*.jsonl") if path.is_file())
    return sorted(path for path in found if not path.name.endswith("_interruptions.jsonl"))


def factor_names(columns: Sequence[str]) -> list[str]:
    """The factors of a table: the columns between `trial` and `procedure`."""
    return list(columns[len(FIRST) : list(columns).index("procedure")])
