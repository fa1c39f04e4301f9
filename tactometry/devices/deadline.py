"""Run a driver's call with a time limit."""

import threading
from collections.abc import Callable
from typing import Final

from ..errors import DeviceFailed

BEGIN_WITHIN_S: Final = 5.0
"""Time limit for an output to begin: a sound card waits 2 s each for the end of a signal and for its start (unverified
default)."""
CLOSE_WITHIN_S: Final = 2.0
"""Time limit for a driver to close (unverified default)."""


def within(longest_s: float, what: str, call: Callable[[], None], cure: str = "switch its amplifier off") -> None:
    """Run `call` in a thread, and wait for it no longer than this.

    Raises `DeviceFailed` if it takes longer; `what` opens the message. Other errors of `call` are raised too.

    >>> import time
    >>> within(1.0, "output 'x'", lambda: None)
    >>> within(0.01, "output 'x'", lambda: time.sleep(1))
    Traceback (most recent call last):
    tactometry.errors.DeviceFailed: output 'x': it hangs and did not end within 0.01 s: switch its amplifier off
    """
    raised: list[BaseException] = []

    def work() -> None:
        try:
            call()
        except BaseException as error:  # raised in the waiting thread
            raised.append(error)

    thread = threading.Thread(target=work, name=what, daemon=True)
    thread.start()
    thread.join(longest_s)
    if thread.is_alive():
        raise DeviceFailed(f"{what}: it hangs and did not end within {longest_s:g} s: {cure}")
    if raised:
        raise raised[0]
