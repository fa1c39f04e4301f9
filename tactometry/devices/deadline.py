"""Time limit for calls of a driver."""

import threading
from collections.abc import Callable
from typing import Final

from ..errors import DeviceFailed

BEGIN_WITHIN_S: Final = 5.0
"""Time limit for an output to begin. A sound card waits 2 s for the end of a signal and 2 s for its start
(unverified default)."""
CLOSE_WITHIN_S: Final = 2.0
"""Time limit for a driver to close (unverified default)."""


def within(longest_s: float, what: str, call: Callable[[], None], cure: str = "switch its amplifier off") -> None:
    """Run `call` in a thread, and wait for it at most `longest_s`.

    Raises `DeviceFailed` if the call takes longer, with a message that begins with `what`. Other errors of `call` are
    raised too.

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
