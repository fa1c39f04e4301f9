"""Whatever goes wrong on a rig with devices, it is closed first, and its output before anything else."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

from ..errors import DeviceFailed

SIGNALLED = 128
"""Exit status of a process that a signal ended: this and the signal's number."""


def ended_by_signal(error: BaseException) -> bool:
    """Whether it ends the process because a signal asked for that.

    >>> ended_by_signal(SystemExit(143)), ended_by_signal(SystemExit(0))
    (True, False)
    """
    return isinstance(error, SystemExit) and isinstance(error.code, int) and error.code > SIGNALLED


class Closing(Protocol):
    """What can be closed, and knows whether it is."""

    closed: bool

    def close(self) -> None: ...


@contextmanager
def closed_on_failure(rig: Closing) -> Iterator[None]:
    """Close the rig, output first, when the body ends by any exception.

    Raises
    ------
    DeviceFailed
        If it is closed already, or PsychoPy ends the program.
    """
    if rig.closed:
        raise DeviceFailed("bench: it is closed, nothing can be asked of it; open it again")
    try:
        yield
    except SystemExit as end:
        rig.close()
        if ended_by_signal(end):
            raise
        raise DeviceFailed(
            f"window: PsychoPy ended the program by itself (exit status {end.code}); go on with --resume"
        ) from end
    except BaseException:  # Ctrl-C too: whatever ends a request, nothing plays on behind it
        rig.close()
        raise
