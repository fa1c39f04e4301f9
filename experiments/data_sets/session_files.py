"""The files of a session beside its journal: where they are, what they hold, and whose they must be."""

import os
from pathlib import Path

from tactometry.files.durable import read_file
from tactometry.records.data_set import Session, trials_csv
from tactometry.records.head import Head, columns_in
from tactometry.records.journal import Recording

from ..study.experiment import Experiment

OTHER_STUDY = "found the digest of another study.toml, expected that of this data set"


def session_of(head: Head) -> Session:
    return Session(head.participant, head.session, head.study)


def name_defect(journal: Path, head: Head) -> str | None:
    """What is wrong with a journal that is not named after its session: a copy under another name is no other session;
    None of one that is."""
    if session_of(head).stem == journal.stem:
        return None
    whose = f"session {head.session} of {head.participant} ({head.study})"
    return f"found {whose}, expected that of the file's name; remove the copy"


def header_of(content: bytes) -> list[str]:
    """The names of the columns in the bytes of a trials file.

    >>> header_of(b"a,b\\n1,2\\n")
    ['a', 'b']
    """
    return content.split(b"\n", 1)[0].decode("utf-8-sig", "replace").strip().split(",")


def trials_file(root: Path, journal: Path) -> Path:
    """The trials file of a journal."""
    return root / "data" / f"{journal.stem}_data.csv"


def n_rows(content: bytes) -> int:
    """Rows of a trials file below its header.

    >>> n_rows(b"a,b\\n1,2\\n3,4"), n_rows(b"")
    (2, 0)
    """
    return max(sum(bool(line.strip()) for line in content.split(b"\n")) - 1, 0)


def has_rows(path: Path) -> bool:
    """Whether there is a trials file that holds rows."""
    return os.path.lexists(path) and n_rows(read_file(path, "a trials file")) > 0


def derived_csv(recording: Recording, experiment: Experiment) -> bytes:
    """The trials file that a journal stands for."""
    assert recording.head is not None
    columns = columns_in(experiment.design(b"").columns, recording.head.format)
    return trials_csv(recording.trials, session_of(recording.head), recording.head.rig, columns)
