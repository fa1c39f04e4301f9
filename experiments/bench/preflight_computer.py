"""Preflight of the computer: its disk, its display and the keyboard."""

import os
import shutil
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Final

import numpy as np

from tactometry.rigs.frame_timing import timing_of
from tactometry.rigs.keyboard import ConnectedScreen
from tactometry.rigs.pages.layout import marker_page, message_page
from tactometry.rigs.pages.page import Display, KeyDown, Page
from tactometry.rigs.texts import texts_in
from tactometry.session.request import Facts

from .bench_parts import DisplayTable
from .finding import Finding, duration

FREE_BYTES = 10**9
SYNC_AT_MOST_S = 0.1
"""A trial's record on disk, longest of ten (unverified default)."""
N_FRAMES = 60
DROPPED_AT_MOST = 0.01
"""Part of the frames that may be dropped (unverified default)."""
PERIOD: Final = "frame_period"
N_KEYS, KEYS_WITHIN_S = 3, 10.0
"""So many keys are asked for, and waited for no longer."""
KEY_TO_RECORD_AT_MOST_S = 0.05
"""Three frames: one until the key is seen, and the disk (unverified default)."""


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


def display(screen: DisplayTable, folder: Path) -> Iterator[Finding]:
    with closing(screen.window()) as window:
        page = marker_page(None, playing=False)
        window.present(page)
        for _ in range(N_FRAMES):
            window.refresh(page)
        facts, screens = window.facts(), window.screens()
        timing = timing_of(window.frame_intervals_s(), window.period_s)
        pressed = _try_keys(window, screen.language, folder)
    yield from _screens(screen, screens)
    yield from _screen_findings(screen, facts, timing)
    yield pressed


def _screens(screen: DisplayTable, there: Sequence[ConnectedScreen]) -> Iterator[Finding]:
    """Which screens there are, and which of them is the participant's."""
    words = "; ".join(map(str, there))
    taken = f", the participant's is screen {screen.screen}" if len(there) > 1 else ""
    yield Finding("display", "connected", f"{words}{taken}", fine=True)


def key_to_record_s(
    screen: Display, page: Page, record: Callable[[], None], n_keys: int, within_s: float
) -> list[float]:
    """From each press of a key to its record's being on the disk, s, read and drawn as in a session.

    Parameters
    ----------
    screen, page
        What is shown until `n_keys` were pressed or `within_s` are over.
    record : callable
        Returns when a record is on the disk.
    """
    delays_s: list[float] = []
    onset_s = screen.present(page)
    while len(delays_s) < n_keys and time.perf_counter() < onset_s + within_s:
        for event in screen.events():
            if isinstance(event, KeyDown) and event.at_s >= screen.offered_s:
                record()
                delays_s.append(time.perf_counter() - event.at_s)
        screen.refresh(page)
    return delays_s


def _try_keys(screen: Display, language: str, folder: Path) -> Finding:
    words = texts_in(language, {}).message("key_test", {"n_keys": N_KEYS, "within_s": KEYS_WITHIN_S})
    try:
        with recorder(folder) as record:
            delays_s = key_to_record_s(screen, message_page(words, "", screen.aspect), record, N_KEYS, KEYS_WITHIN_S)
    except OSError as error:
        place = f"{folder}: {error.strerror}"
        return Finding("display", "key to record", place, "a folder that can be written", fine=False)
    if not delays_s:
        return Finding("display", "key to record", f"no key was pressed in {KEYS_WITHIN_S:g} s")
    median_s = float(np.median(delays_s))
    words = f"{1e3 * median_s:.1f} ms, longest {1e3 * max(delays_s):.1f}, of {len(delays_s)} keys"
    limit = f"median at most {1e3 * KEY_TO_RECORD_AT_MOST_S:g} ms"
    return Finding("display", "key to record", words, limit, median_s <= KEY_TO_RECORD_AT_MOST_S)


def _screen_findings(screen: DisplayTable, facts: Facts, timing: Mapping[str, int | float | None]) -> Iterator[Finding]:
    size = f"{facts['display_width_px']} x {facts['display_height_px']} px"
    yield Finding("display", "size", size, fine=True)
    height = "not measured" if screen.height_m is None else f"{screen.height_m:g} m"
    yield Finding("display", "height", height)
    yield _period(facts)
    interval_ms = [f"{1e3 * float(timing[f'frame_interval_{name}_s'] or 0):.1f}" for name in ("median", "p99", "max")]
    yield Finding("display", "frame interval", f"{interval_ms[0]} ms, p99 {interval_ms[1]}, longest {interval_ms[2]}")
    n_dropped, n_frames = int(timing["n_dropped_frames"] or 0), int(timing["n_frames"] or 0)
    n_due = n_frames + n_dropped
    fine = n_dropped <= DROPPED_AT_MOST * n_due
    yield Finding("display", "dropped frames", f"{n_dropped} of {n_due}", f"at most {DROPPED_AT_MOST:.0%}", fine)
    yield Finding("display", "keyboard", str(facts["keyboard"]), fine=True)


def _period(facts: Facts) -> Finding:
    """The frame period: measured, and what it should be by the mode of the screen."""
    measured, expected = (f"{1e3 * float(facts[name] or 0):.2f} ms" for name in (f"{PERIOD}_measured_s", f"{PERIOD}_s"))
    if facts["frames_paced_in_software"]:
        return Finding("display", "frame period", f"{expected}, in software: there is no vertical blank")
    nominal = "steady" if facts[f"{PERIOD}_nominal_s"] is None else expected
    return Finding("display", "frame period", measured, nominal, bool(facts[f"{PERIOD}_trusted"]))
