"""What a driver may take its time for, and what goes on without it."""

import threading
from collections.abc import Callable
from typing import Final

from ..errors import DeviceFailed

BEGIN_WITHIN_S: Final = 5.0
"""An output that has not begun to play by then hangs: a sound card waits for the end of what it plays, and for its own
beginning, 2 s each (unverified default)."""
CLOSE_WITHIN_S: Final = 2.0
"""A driver that has not let go by then hangs (unverified default)."""


def within(longest_s: float, what: str, call: Callable[[], None], cure: str = "switch its amplifier off") -> None:
    """Wait for `call`, in a thread of its own, no longer than this; what hangs there keeps no process from its end.

    Raises `DeviceFailed` if it takes longer; the sentence opens with `what`. Whatever it raises.

    >>> import time
    >>> within(1.0, "output 'x'", lambda: None)
    >>> within(0.01, "output 'x'", lambda: time.sleep(1))
    Traceback (most recent call last):
    tactometry.errors.DeviceFailed: output 'x': it hangs, and did not end within 0.01 s: switch its amplifier off
    """
    raised: list[BaseException] = []

    def work() -> None:
        try:
            call()
        except BaseException as error:  # to be raised where it is waited for
            raised.append(error)

    thread = threading.Thread(target=work, name=what, daemon=True)
    thread.start()
    thread.join(longest_s)
    if thread.is_alive():
        raise DeviceFailed(f"{what}: it hangs, and did not end within {longest_s:g} s: {cure}")
    if raised:
        raise raised[0]
