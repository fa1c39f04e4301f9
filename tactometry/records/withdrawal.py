"""Removal of the files of a session that failed before it began."""

from contextlib import suppress
from pathlib import Path

from .data_set import Session
from .description import NAME


class Withdrawal:
    """The files and folders of a session, and of its data set, that do not exist before it.

    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     root = Path(folder) / "data"
    ...     withdrawal = Withdrawal(root, Session("P01", 1, "tutorial"))
    ...     (root / "journals").mkdir(parents=True)
    ...     withdrawal.undo()
    ...     root.exists()
    False
    """

    def __init__(self, root: Path, session: Session) -> None:
        events = session.events(root)
        files = (session.trials(root), session.sidecar(root), events, events.with_suffix(".json"))
        self._journal = session.journal(root)
        folders = (self._journal.parent, root / "data")
        # A folder that another session has begun in is not empty: then what follows stays.
        ordered = (*files, self._journal, *folders, root / "study.toml", root / NAME, root)
        self._created = tuple(path for path in ordered if not path.exists())

    def undo(self) -> None:
        """Remove what was created since, unless the journal has a line."""
        if self._journal.exists() and self._journal.stat().st_size:
            return
        with suppress(OSError):  # what is in use stays, and so does what contains it
            for path in self._created:
                if path.is_dir():
                    path.rmdir()
                else:
                    path.unlink(missing_ok=True)
