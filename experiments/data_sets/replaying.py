"""Replay recorded sessions, and rebuild files from their journals."""

from dataclasses import dataclass, replace
from pathlib import Path

from tactometry.errors import Diverged, InvalidFile
from tactometry.files.durable import read_file
from tactometry.provenance import sha256
from tactometry.records.data_set import sessions
from tactometry.records.head import Head, changes
from tactometry.records.journal import read
from tactometry.records.open_session import OpenSession
from tactometry.session.run import replay

from ..study.experiment import Experiment, wire
from ..study.study_file import parse
from .session_files import OTHER_STUDY, has_rows, name_defect, session_of, trials_defects, trials_file


@dataclass(frozen=True)
class Replayed:
    """Replayed session that agrees with its journal."""

    journal: str
    n_trials: int
    complete: bool
    changes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Rebuilt:
    """Session whose files were rebuilt, and whether its trials file changed."""

    trials: str
    n_trials: int
    changed: bool


def replay_data_set(path: Path) -> list[Replayed]:
    """Replay every session of a data set, or the session of one journal file.

    Raises `Diverged` at the first request, or row of a trials file, that differs from the journal. Raises `InvalidFile`
    if there is no journal, or one is damaged.
    """
    root, journals, experiment, content = _recordings(path)
    return [_replay(root, journal, experiment, content) for journal in journals]


def rebuild_data_set(path: Path) -> list[Rebuilt]:
    """Rebuild all files that are derived from the journals of a data set.

    Raises `InvalidFile` if there is no journal, one is damaged, or a trials file contains rows that its journal lacks.
    Raises `SessionInUse` if a session is being recorded.
    """
    root, journals, experiment, content = _recordings(path)
    return [rebuilt for journal in journals if (rebuilt := _rebuild(root, journal, experiment, content)) is not None]


def _recordings(path: Path) -> tuple[Path, list[Path], Experiment, bytes]:
    """Return root, journals, experiment, and the content of its study.toml."""
    root = path.parent.parent if path.is_file() else path
    journals = [path] if path.is_file() else sessions(path)
    if not journals:
        raise InvalidFile(f"{path}: found no journal, expected a data set with journals/*.jsonl, or a journal")
    study = root / "study.toml"
    content = read_file(study, "the study that ran")
    return root, journals, wire(parse(content, str(study)), str(study), plays=False), content


def _replay(root: Path, journal: Path, experiment: Experiment, study_toml: bytes) -> Replayed:
    recording = read(journal)
    head = recording.head
    trials = trials_file(root, journal)
    if head is None:
        if has_rows(root, journal):
            raise Diverged(
                f"{trials}, row 2: found a trial, expected none as the journal is empty; restore {journal.name}"
            )
        return Replayed(journal.name, 0, complete=False)
    _check_name(journal, head)
    if head.study_sha256 != sha256(study_toml):
        raise Diverged(f"{journal}, line 1: {OTHER_STUDY}")
    course = experiment.course(head.participant, head.session, head.number, head.seed)
    replay(course, recording.replay(str(journal)), complete=recording.complete)
    for defect in trials_defects(root, journal, recording, experiment):
        raise Diverged(str(replace(defect, file=str(trials))))
    return Replayed(journal.name, len(recording.trials), recording.complete, tuple(changes(recording.sittings)))


def _rebuild(root: Path, journal: Path, experiment: Experiment, study_toml: bytes) -> Rebuilt | None:
    """Rebuild a session's files. Returns None if it has not begun."""
    head, trials = read(journal).head, trials_file(root, journal)
    if head is None:
        return None
    _check_name(journal, head)
    before = read_file(trials, "a trials file") if trials.exists() else None
    # Opening a recorded session rewrites its files from the journal, as after a crash.
    opened = OpenSession(root, experiment.design(study_toml), session_of(head), head.rig, resume=True)
    opened.close()
    changed = read_file(trials, "a trials file") != before
    return Rebuilt(trials.name, opened.tally.n_trials, changed)


def _check_name(journal: Path, head: Head) -> None:
    wrong_name = name_defect(journal, head)
    if wrong_name is not None:
        raise InvalidFile(f"{journal}, line 1: {wrong_name}")
