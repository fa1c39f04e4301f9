"""Recorded answers fed back into the protocol that asked for them."""

from dataclasses import dataclass
from pathlib import Path

from tactometry.dataset import sessions
from tactometry.errors import Diverged, InvalidFile
from tactometry.experiments.study import parse
from tactometry.experiments.validation import derived_csv, first_difference, n_rows, trials_file
from tactometry.experiments.wiring import Experiment, wire
from tactometry.journal import read
from tactometry.provenance import sha256
from tactometry.run import replay
from tactometry.sittings import changes


@dataclass(frozen=True)
class Replayed:
    """A session that was fed back, and agreed."""

    journal: str
    n_trials: int
    complete: bool
    changes: tuple[str, ...] = ()


def replay_data_set(path: Path) -> list[Replayed]:
    """Replay every session of a data set, or the one of a journal file.

    Raises
    ------
    Diverged
        At the first request, or the first row of a trials file, that is not as recorded.
    InvalidFile
        If there is nothing to replay, or a journal is damaged.
    """
    root = path.parent.parent if path.is_file() else path
    journals = [path] if path.is_file() else sessions(path)
    if not journals:
        raise InvalidFile(f"{path}: found no journal, expected a data set with journals/*.jsonl, or a journal")
    if not (root / "study.toml").is_file():
        raise InvalidFile(f"{root / 'study.toml'}: found no such file, expected the study that ran")
    content = (root / "study.toml").read_bytes()
    experiment = wire(parse(content, str(root / "study.toml")), str(root / "study.toml"))
    return [_replay(root, journal, experiment, content) for journal in journals]


def _replay(root: Path, journal: Path, experiment: Experiment, study_toml: bytes) -> Replayed:
    recording = read(journal)
    head = recording.head
    trials = trials_file(root, journal)
    if head is None:
        if n_rows(trials):
            raise Diverged(f"{trials}, row 2: found a trial, but the journal holds none; restore {journal.name}")
        return Replayed(journal.name, 0, complete=False)
    if head.study_sha256 != sha256(study_toml):
        raise Diverged(f"{journal}, line 1: found the digest of another study.toml, expected that of this data set")
    course = experiment.course(head.participant, head.session, head.number, head.seed)
    replay(course, recording.replay(str(journal)), complete=recording.complete)
    found = trials.read_bytes() if trials.is_file() else b""
    row = first_difference(found, derived_csv(recording, experiment))
    if row is not None:
        raise Diverged(f"{trials}, row {row}: found another row than the replayed session gives, expected the same")
    return Replayed(journal.name, len(recording.trials), recording.complete, tuple(changes(recording.sittings)))
