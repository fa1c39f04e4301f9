"""Session being recorded: its journal and the derived files."""

import os
import threading
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import msgspec

from ..arguments.require import expect
from ..errors import InvalidFile, count_of
from ..files.durable import NO_LINK, drafts, open_private, read_file, replace_file, whole_lines, write_whole
from ..files.rows import delimited_text
from ..provenance import sha256
from ..safety.limits import Exposure
from ..session.answer import Intervention, Marked, TracePart
from ..session.event import COLUMNS, Event, OnEvent, OnRequest, TraceKind, decode_event, events_tsv
from ..session.replay import Replay
from ..session.request import Intervene, Record, Request
from ..signal import FloatArray
from ..trials.trial import tally
from .data_set import Session, is_beginning, participants, prepare, row, sessions, trials_csv
from .description import NAME, SIMULATED, StudyDescription, describe, describe_columns, read_description, says_simulated
from .head import FORMAT, as_kept, columns_in, heads
from .journal import Entry, consequence, read
from .open_journal import Journal
from .traces import TraceFiles

POSITIONS_HEADER: Final = b"positions_digest\ttime_s\tposition_m\n"
"""Header of the positions file. Times count from the position that the first sample of the stimulus followed."""
_STIMULUS: Final = b'{"event":"stimulus'
_KINDS: Final = (_STIMULUS + b'"', _STIMULUS + b'_end"')


def refuse_mixing(root: Path, rig: str) -> None:
    """Refuse to store simulated and real sessions in one folder."""
    path = root / NAME
    if path.exists() and says_simulated(read_description(path)):
        held = {SIMULATED}
    else:
        held = {head.rig for journal in sessions(root) for head in heads(journal)[:1]}
    for other in sorted(held):
        whom = "simulated participants" if other == SIMULATED else "real participants"
        none = f"none in the folder of rig {rig!r}, because real and simulated data are kept apart"
        is_alike = (other == SIMULATED) == (rig == SIMULATED)
        expect(is_alike, root, f"sessions of {whom}", f"{none}; choose another --out", InvalidFile)


def stimuli(journal: Path) -> Iterator[Event]:
    """Yield begin and end of the stimuli of a journal, skipping damaged lines."""
    for line in whole_lines(read_file(journal, "a journal"), _STIMULUS):
        if line.startswith(_KINDS):
            try:
                yield decode_event(msgspec.json.decode(line))
            except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
                continue


def charge_passed_c(events: Iterable[Event]) -> float:
    """Sum the charges of stimuli.

    If the end of a stimulus was not recorded, its largest possible charge counts.
    """
    charges_c: list[float] = []
    for event in events:
        charge_c = event.facts.get("charge_c")
        if not isinstance(charge_c, float):
            continue
        if event.kind == "stimulus_end" and charges_c:
            charges_c.pop()
        charges_c.append(charge_c)
    return sum(charges_c)


class OpenSession:
    """Store to which `tactometry.session.run.run` writes.

    Each trial is flushed and fsynced in the journal, and flushed in the trials file, before `append` returns. For
    simulated participants it is only flushed. With `resume` an interrupted session continues. `repaired` describes what
    was removed and where it is stored.

    Raises `InvalidFile` if the folder contains another study, or the journal another session. Raises
    `InvalidParameter` if a participant's code differs only in case from another code.
    """

    def __init__(self, root: Path, design: StudyDescription, session: Session, rig: str, *, resume: bool) -> None:
        path = session.journal(root)
        goes_on = resume and path.is_file() and path.stat().st_size > 0
        if not goes_on:  # a resumed session is compared with its own head
            refuse_mixing(root, rig)
        prepare(root, design)
        self._root, self._session, self._traces = root, session, TraceFiles(root, session)
        self._file = self._events_file = -1
        self._repaired: list[str] = []
        self._writing = threading.Lock()
        self._followers: list[tuple[OnRequest, OnEvent]] = []
        self.recorded_s: float | None = None
        """Time at which the last trial was on the disk, on `time.perf_counter`."""
        _refuse_alike(root, session)
        self.journal = Journal(path, resume=resume, syncs_trials=rig != SIMULATED)
        try:
            _refuse_other(self.journal, session, design)
            head = self.journal.head
            self._rig = rig if head is None else head.rig
            self.format = FORMAT if head is None else head.format
            self._columns = columns_in(design.columns, self.format)
            self._events_columns = columns_in(COLUMNS, self.format)
            of_format = replace(design, columns=self._columns)
            describe(root, of_format, is_simulated=self._rig == SIMULATED and self.format > 1)
            self.tally = tally(self.journal.recording.trials)
            self._say_cut()
            self._rebuild()
        except BaseException:
            self.close()
            raise

    @property
    def replay(self) -> Replay:
        return self.journal.replay

    @property
    def wanted(self) -> tuple[Intervention, ...]:
        """Interventions of an earlier sitting that were not carried out."""
        return self.journal.recording.wanted

    def exposure(self) -> Exposure:
        """Return the duration of this session and the charge that it passed."""
        return Exposure(
            time.perf_counter() - self.replay.elapsed_s, charge_c=charge_passed_c(stimuli(self.journal.path))
        )

    def note(self, event: Event) -> None:
        """Store an event in the journal and the events file, from any thread."""
        with self._writing:
            self.journal.note(event)
            self._tell(event)
            for _, on_event in self._followers:
                on_event(event)

    def follow(self, on_request: OnRequest, on_event: OnEvent) -> None:
        """Report recorded requests and events, and then each new one."""
        for line in self.journal.recording.lines:
            if isinstance(line, Entry):
                on_request(*line)
            elif isinstance(line, Event):
                on_event(line)
        self._followers.append((on_request, on_event))

    def keep_path(self, digest: str, lines: bytes) -> None:
        """Store the path of a finger in the positions file, before its touch."""
        path = self._session.positions(self._root)
        header = b"" if path.exists() else POSITIONS_HEADER
        body = b"".join(digest.encode() + b"\t" + line + b"\n" for line in lines.splitlines())
        file = open_private(path, os.O_WRONLY | os.O_APPEND | NO_LINK)
        try:
            write_whole(file, header + body, path, durable=False)
        finally:
            os.close(file)

    def keep_trace(self, kind: TraceKind, table: FloatArray, rate_hz: float) -> TracePart:
        """Store samples of a touch on the disk, before the journal refers to them."""
        return self._traces.keep(kind, table, rate_hz)

    def keep_marks(self, marked: Marked) -> None:
        """Store marks on a page of a questionnaire in the journal."""
        with self._writing:
            self.journal.keep_marks(marked)

    def _tell(self, event: Event) -> None:
        if self._events_file < 0:
            self._events_file = self._new_events(())
        line = events_tsv([event], self._events_columns).partition(b"\n")[2]
        write_whole(self._events_file, line, self._session.events(self._root), durable=False)

    def append(self, request: Request[Any], answer: object) -> None:
        request = as_kept(request, self.format)
        if isinstance(request, Record):
            self._traces.sync()
        with self._writing:
            self.journal.append(request, answer)  # the journal first: after a crash the table can be rebuilt
            if isinstance(request, Record):
                self.recorded_s = time.perf_counter()
                line = delimited_text([row(request.trial, self._session, self._rig, self._columns)])
                write_whole(self._file, line, self.trials, durable=False)
                self.tally = self.tally.after(request.trial)
            elif isinstance(request, Intervene) and request.retracted:
                trials = read(self.journal.path).trials
                before, content = self._file, trials_csv(trials, self._session, self._rig, self._columns)
                self._file = replace_file(self.trials, content)
                os.close(before)
                self.tally = tally(trials)
            if (event := consequence(Entry(request, answer))) is not None:
                self._tell(event)
            for on_request, _ in self._followers:
                on_request(request, answer)

    def finish(self) -> None:
        self.journal.finish()

    def close(self) -> None:
        self._traces.close()
        self.journal.close()
        for file in (self._file, self._events_file):
            if file >= 0:
                os.fsync(file)
                os.close(file)
        self._file = self._events_file = -1

    @property
    def repaired(self) -> str | None:
        """Description of incomplete or surplus data that were repaired, or None."""
        return "; ".join(self._repaired) or None

    def _rebuild(self) -> None:
        self.trials, recording = self._session.trials(self._root), self.journal.recording
        content = trials_csv(recording.trials, self._session, self._rig, self._columns)
        at_first = trials_csv(recording.rows_at_first, self._session, self._rig, self._columns)
        for path in (self.trials, *drafts(self.trials.parent, self.trials.name)):
            self._keep_surplus(path, content, at_first)
        self._keep_surplus(self._session.events(self._root), events_tsv(recording.event_rows, self._events_columns))
        describe_columns(self._session.sidecar(self._root), self._columns)
        self._file = replace_file(self.trials, content)
        if recording.event_rows:
            self._events_file = self._new_events(recording.event_rows)
        for folder in (self.trials.parent, self.journal.path.parent):
            for draft in drafts(folder, f"{self._session.stem}*"):
                draft.unlink()

    def _say_cut(self) -> None:
        if not self.journal.cut:
            return
        n_cut, kept = count_of(len(self.journal.cut), "byte"), f"are kept in {self.journal.interruptions.name}"
        if self.journal.recording.complete:
            self._repaired.append(f"{n_cut} after the end of the session {kept}")
            return
        trials = count_of(self.tally.n_trials, "trial")
        what = f"{n_cut} of the unfinished trial {kept}; the trial is repeated"
        self._repaired.append(f"the last sitting ended after {trials}; {what}")

    def _keep_surplus(self, path: Path, content: bytes, at_first: bytes = b"") -> None:
        """Store rows of a derived file that are missing from the journal."""
        existing = read_file(path, "a file of a data set") if path.exists() else b""
        if is_beginning(existing, content):
            return
        known = {*content.split(b"\n"), *at_first.split(b"\n")}
        header, *rows = existing.split(b"\n")
        lost = [line.decode("utf-8", "backslashreplace") for line in rows if line not in known]
        if lost:
            self.journal.keep(
                after_trials=self.tally.n_presented, file=path.name, header=header.decode("utf-8", "replace"), rows=lost
            )
            it_is = "it is" if len(lost) == 1 else "they are"
            self._repaired.append(
                f"{path.name} had {count_of(len(lost), 'row')} missing from the journal of "
                f"{count_of(self.tally.n_trials, 'trial')}: {it_is} kept in "
                f"{self.journal.interruptions.name}; if the journal is an older copy, stop and restore the newer copy"
            )

    def _new_events(self, events: Sequence[Event]) -> int:
        path = self._session.events(self._root)
        describe_columns(path.with_suffix(".json"), self._events_columns)
        return replace_file(path, events_tsv(events, self._events_columns))


def _refuse_alike(root: Path, session: Session) -> None:
    for code in participants(root):
        is_other = code.casefold() != session.participant.casefold()
        both = f"{session.participant!r} next to {code!r}"
        apart = f"codes that differ in more than case, because some disks ignore case; use {code!r}"
        expect(is_other or code == session.participant, "participant", both, f"{apart}, or another code")


def _refuse_other(journal: Journal, session: Session, design: StudyDescription) -> None:
    head = journal.head
    if head is None:
        return
    where, of_head = f"{journal.path}, line 1", Session(head.participant, head.session, head.study)
    whose = f"session {head.session} of {head.participant} ({head.study})"
    right = "the session in the file name; restore the right file, or remove the copy"
    expect(of_head == session, where, whose, right, InvalidFile)
    is_same, other = head.study_sha256 == sha256(design.study_toml), "the digest of another study.toml"
    expect(is_same, where, other, "the digest of this data set's study.toml; restore the right file", InvalidFile)
