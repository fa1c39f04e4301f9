"""Whatever goes wrong on a bench, it is closed first, and its output before anything else."""

import functools
from collections.abc import Callable
from typing import Concatenate, ParamSpec, Protocol, TypeVar

from ..errors import DeviceFailed

P = ParamSpec("P")
R = TypeVar("R")

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

    def turn(self) -> None:
        """What is due before anything else is asked."""


B = TypeVar("B", bound=Closing)


def safely(method: Callable[Concatenate[B, P], R]) -> Callable[Concatenate[B, P], R]:
    """Close the bench, output first, when the method ends by any exception."""

    @functools.wraps(method)
    def guarded(bench: B, /, *args: P.args, **kwargs: P.kwargs) -> R:
        if bench.closed:
            raise DeviceFailed("bench: it is closed, nothing can be asked of it; open it again")
        try:
            bench.turn()
            return method(bench, *args, **kwargs)
        except SystemExit as end:
            bench.close()
            if ended_by_signal(end):
                raise
            raise DeviceFailed(
                f"window: PsychoPy ended the program by itself (exit status {end.code}); go on with --resume"
            ) from end
        except BaseException:  # Ctrl-C too: whatever ends a request, nothing plays on behind it
            bench.close()
            raise

    return guarded
