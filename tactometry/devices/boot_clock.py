"""A clock that no setting of the wall clock changes, and that also runs while the computer sleeps."""

import functools
import time
from pathlib import Path
from typing import Final

_BOOT_ID: Final = Path("/proc/sys/kernel/random/boot_id")


def boot_clock_s() -> float:
    """Seconds since the computer started, with its sleep where the system has such a clock."""
    return time.clock_gettime(time.CLOCK_BOOTTIME) if hasattr(time, "CLOCK_BOOTTIME") else time.perf_counter()


@functools.cache
def boot_id() -> str:
    """Name of this start of the computer; empty where the system has none."""
    return _BOOT_ID.read_text("ascii").strip() if _BOOT_ID.exists() else ""
