"""Preflight of the computer and its disk."""

import os
import shutil
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from .finding import Finding, duration

FREE_BYTES = 10**9
SYNC_AT_MOST_S = 0.1
"""A trial's record on disk, longest of ten (unverified default)."""


def computer() -> Iterator[Finding]:
    import scipy.linalg  # noqa: F401  # loads its own BLAS
    from threadpoolctl import threadpool_info

    yield Finding("computer", "Python", sys.version.split()[0])
    yield Finding("computer", "cores", f"{os.cpu_count()}")
    for pool in threadpool_info():
        kind = f"{pool['internal_api']} {pool.get('version') or ''} {pool.get('architecture', '')}".split()
        yield Finding("computer", f"{pool['user_api']} threads", f"{pool['num_threads']} ({' '.join(kind)})")


def existing(folder: Path) -> Path:
    return next(parent for parent in (folder, *folder.absolute().parents) if parent.is_dir())


def disk(folder: Path) -> Iterator[Finding]:
    free = shutil.disk_usage(folder).free
    yield Finding("disk", "free", f"{free / 1e9:.1f} GB", f"at least {FREE_BYTES / 1e9:g} GB", free >= FREE_BYTES)
    try:
        longest_s = _longest_sync_s(folder)
    except OSError as error:
        yield Finding("disk", "writing", f"{folder}: {error.strerror}", "a folder that can be written", fine=False)
        return
    yield duration("disk", "a record, to disk", longest_s, SYNC_AT_MOST_S)


def _longest_sync_s(folder: Path, n_records: int = 10) -> float:
    took_s = []
    with recorder(folder) as record:
        for _ in range(n_records):
            begin_s = time.perf_counter()
            record()
            took_s.append(time.perf_counter() - begin_s)
    return max(took_s)


@contextmanager
def recorder(folder: Path) -> Iterator[Callable[[], None]]:
    """What puts a record of a trial's length on the disk."""
    import tempfile

    with tempfile.TemporaryFile(dir=folder) as file:

        def record() -> None:
            file.write(b"x" * 500)
            file.flush()
            os.fsync(file.fileno())

        yield record
