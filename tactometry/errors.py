"""What can go wrong, by the guilty party. A message says where, what was found, what was expected, how to mend it."""

import difflib
from collections.abc import Iterable


class TactometryError(Exception):
    """An error that a person can mend; `exit_status` is what the command line ends with."""

    exit_status = 2


class InvalidParameter(TactometryError, ValueError):  # noqa: N818
    """An argument, a key of a file or a cell of a table that cannot be used."""


class InvalidFile(TactometryError):  # noqa: N818
    """A study file, data set or journal that cannot be read as what it claims to be."""


class LimitExceeded(TactometryError):  # noqa: N818
    """A signal that must not reach a finger."""

    exit_status = 3


class DeviceFailed(TactometryError):  # noqa: N818
    """A display, output, sensor or disk that did not do what was asked of it."""

    exit_status = 3


class SessionInUse(TactometryError):  # noqa: N818
    """Another process writes this session."""


class Diverged(TactometryError):  # noqa: N818
    """A replayed session asked for something else than the recording holds."""

    exit_status = 1


class Stopped(TactometryError):  # noqa: N818
    """The participant or the experimenter ended the session; what was recorded is safe."""

    exit_status = 1


def nearest(found: str, names: Iterable[str]) -> str:
    """A hint for a mistyped name.

    >>> nearest("procedur", ["procedure", "task"])
    "; did you mean 'procedure'?"
    >>> nearest("zzz", ["procedure", "task"])
    ''
    """
    close = difflib.get_close_matches(found, list(names), n=1)
    return f"; did you mean {close[0]!r}?" if close else ""


def counted(n: int, noun: str) -> str:
    """A number with its noun.

    >>> counted(1, "trial"), counted(2, "trial")
    ('1 trial', '2 trials')
    """
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"
