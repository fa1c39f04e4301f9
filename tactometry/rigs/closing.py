"""How a process ends that a signal asked to."""

SIGNALLED = 128
"""Exit status of a process that a signal ended: this and the signal's number."""


def ended_by_signal(error: BaseException) -> bool:
    """Whether it ends the process because a signal asked for that.

    >>> ended_by_signal(SystemExit(143)), ended_by_signal(SystemExit(0))
    (True, False)
    """
    return isinstance(error, SystemExit) and isinstance(error.code, int) and error.code > SIGNALLED
