"""Where the tests write: in memory where there is room, as a recorded trial waits for the disk and the tests record
many thousands. The syncs are called all the same."""

import os
from pathlib import Path

IN_MEMORY = Path("/dev/shm")
ROOM_BYTES = 4 * 2**30


def has_room(folder=IN_MEMORY):
    """Whether the tests' folders fit, and programs that are installed in them run."""
    if not os.access(folder, os.W_OK):
        return False
    disk = os.statvfs(folder)
    return disk.f_bavail * disk.f_frsize >= ROOM_BYTES and not disk.f_flag & os.ST_NOEXEC


def write_in_memory():
    if has_room():
        os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", str(IN_MEMORY))
