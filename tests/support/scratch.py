"""Folder that tests write to: in memory if there is room.

A recorded trial waits for the disk, and the tests record many thousands. Syncs are still called.
"""

import os
from pathlib import Path

IN_MEMORY = Path("/dev/shm")
ROOM_BYTES = 4 * 2**30


def has_room(folder=IN_MEMORY):
    """Return True if the folder fits the tests' files and is executable."""
    if not os.access(folder, os.W_OK):
        return False
    disk = os.statvfs(folder)
    return disk.f_bavail * disk.f_frsize >= ROOM_BYTES and not disk.f_flag & os.ST_NOEXEC


def write_in_memory():
    if has_room():
        os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", str(IN_MEMORY))
