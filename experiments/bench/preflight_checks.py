"""Preflight checks of the computer, the display and sensors at rest."""

import os
import shutil
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from tactometry.devices.sensors.streamed import StreamedSensor
from tactometry.errors import TactometryError
from tactometry.gates import SpeedGate
from tactometry.protocols.tasks.touch import Sliding
from tactometry.rigs.frame_timing import timing_of
from tactometry.rigs.pages.layout import marker_page, message_page
from tactometry.rigs.pages.page import Display, KeyDown, Page
from tactometry.rigs.texts import texts_in
from tactometry.session.request import Facts
from tactometry.signal import FloatArray

from ..study.experiment import Experiment
from .bench_file import BenchFile, Devices
from .bench_parts import DisplayTable, PositionPart
from .stimuli import check_followed


@dataclass(frozen=True)
class Finding:
    """Result of one check. `fine` is None if the check has no criterion."""

    part: str
    what: str
    found: str
    expected: str = ""
    fine: bool | None = None
    device: bool = False


FREE_BYTES = 10**9
SYNC_AT_MOST_S = 0.1
"""Largest time to write a trial's record to disk, among ten writes (unverified default)."""
N_FRAMES = 60
DROPPED_AT_MOST = 0.01
"""Largest share of dropped frames (unverified default)."""
PERIOD: Final = "frame_period"
N_KEYS, KEYS_WITHIN_S = 3, 10.0
"""Number of requested key presses, and the longest wait (s) for them."""
KEY_TO_RECORD_AT_MOST_S = 0.05
"""About three frames: one until the key is read, the rest for the disk (unverified default)."""


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
    yield duration("disk", "time to write a record to disk", longest_s, SYNC_AT_MOST_S)


def _longest_sync_s(folder: Path, n_records: int = 10) -> float:
    longest_s = 0.0
    with recorder(folder) as record:
        for _ in range(n_records):
            begin_s = time.perf_counter()
            record()
            longest_s = max(longest_s, time.perf_counter() - begin_s)
    return longest_s


@contextmanager
def recorder(folder: Path) -> Iterator[Callable[[], None]]:
    """Yield a function that writes a record the size of a trial's to disk."""
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
    participant = f"; the participant uses screen {screen.screen}" if len(screens) > 1 else ""
    yield Finding("display", "connected", f"{'; '.join(map(str, screens))}{participant}", fine=True)
    yield from _screen_findings(screen, facts, timing)
    yield pressed


def key_to_record_s(
    screen: Display, page: Page, record: Callable[[], None], n_keys: int, within_s: float
) -> list[float]:
    """Measure the time (s) from key presses to their records on disk.

    The page is shown until `n_keys` keys were pressed or `within_s` seconds have passed. `record` returns when a record
    is on disk.
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
    yield Finding("display", "height", "not measured" if screen.height_m is None else f"{screen.height_m:g} m")
    yield _period(facts)
    interval_ms = [f"{1e3 * float(timing[f'frame_interval_{name}_s'] or 0):.1f}" for name in ("median", "p99", "max")]
    yield Finding("display", "frame interval", f"{interval_ms[0]} ms, p99 {interval_ms[1]}, longest {interval_ms[2]}")
    n_dropped, n_frames = int(timing["n_dropped_frames"] or 0), int(timing["n_frames"] or 0)
    result, n_due = f"{n_dropped} of {n_frames + n_dropped}", n_frames + n_dropped
    few = n_dropped <= DROPPED_AT_MOST * n_due
    yield Finding("display", "dropped frames", result, f"at most {DROPPED_AT_MOST:.0%}", few)
    yield Finding("display", "keyboard", str(facts["keyboard"]), fine=True)


def _period(facts: Facts) -> Finding:
    measured, expected = (f"{1e3 * float(facts[name] or 0):.2f} ms" for name in (f"{PERIOD}_measured_s", f"{PERIOD}_s"))
    if facts["frames_paced_in_software"]:
        return Finding("display", "frame period", f"{expected}, in software: there is no vertical blank")
    nominal = "steady" if facts[f"{PERIOD}_nominal_s"] is None else expected
    return Finding("display", "frame period", measured, nominal, bool(facts[f"{PERIOD}_trusted"]))


def duration(part: str, what: str, measured_s: float, longest_s: float) -> Finding:
    """Return a finding on whether a time is at most `longest_s`."""
    words = f"{1e3 * measured_s:.1f} ms", f"at most {1e3 * longest_s:g} ms"
    return Finding(part, what, *words, fine=measured_s <= longest_s)


def exit_status(findings: list[Finding]) -> int:
    """Return 3 if a device failed, 1 if another check failed, else 0.

    >>> exit_status([Finding("disk", "free", "1 GB", fine=True), Finding("display", "", "", fine=False, device=True)])
    3
    """
    if any(finding.fine is False and finding.device for finding in findings):
        return 3
    return int(any(finding.fine is False for finding in findings))


def findings_of(part: str, findings: Iterator[Finding]) -> Iterator[Finding]:
    """Yield the findings of a part, and a last one if its check raises."""
    try:
        yield from findings
    except TactometryError as error:
        yield Finding(part, "failed", str(error), fine=False, device=error.exit_status == 3)


HEARD_S = 1.0
FIRST_WITHIN_S = 3.0
FEW_BITS = (8, 10, 12, 14, 16)
"""Resolutions (bits) of position sensors whose full scale is checked."""


def force(sensor: StreamedSensor) -> Iterator[Finding]:
    """Check a force sensor at rest."""
    _, forces_n = _heard(sensor)
    yield from _known("force", forces_n, "samples in the calibrated range")
    known_n = forces_n[np.isfinite(forces_n)]
    if known_n.size:
        yield Finding("force", "mean, at rest", f"{known_n.mean():.4g} N")
        yield Finding("force", "noise, sd", f"{known_n.std():.3g} N")


def position(connected: Devices, bench: BenchFile, experiment: Experiment | None) -> Iterator[Finding]:
    """Check a position sensor at rest, and whether a study can use it."""
    if connected.position is not None and bench.position is not None:
        yield from _at_rest(connected.position, bench.position, _slides(experiment))
    elif _slides(experiment):
        yield Finding("position", "speed", "not measured: the bench file has no [position]")
    if experiment is not None:
        check_followed(experiment, bench, connected)


def _at_rest(sensor: StreamedSensor, part: PositionPart, slides: list[Sliding]) -> Iterator[Finding]:
    times_s, places_m = _heard(sensor)
    yield from _known("position", places_m, "samples with a position")
    is_known = np.isfinite(places_m).all(axis=1)
    if not is_known.any():
        return
    known_m = places_m[is_known]
    for axis in np.rint(known_m / part.metres_per_count + (part.zero_counts or 0.0)).T:
        bits = int(axis.max()).bit_length() if axis.max() > 0 else 0
        if bits in FEW_BITS and axis.max() == 2**bits - 1:
            n_full = int((axis == axis.max()).sum())
            result = f"{n_full} of {len(axis)} at {axis.max():g}, the largest of {bits} bits"
            expected = f"none; if this count means overload, write count_high = {axis.max() - 1:g}"
            yield Finding("position", "counts at full scale", result, expected, fine=False, device=True)
    yield Finding("position", "mean, at rest", f"{_in_mm(known_m.mean(axis=0))} mm")
    yield Finding("position", "noise, sd", f"{_in_mm(known_m.std(axis=0))} mm")
    yield _speed(fastest_m_per_s(times_s, places_m[:, 0]), slides)


def _speed(found_m_per_s: float | None, slides: list[Sliding]) -> Finding:
    least = [_band_m_per_s(slide) for slide in slides if slide.speed_tolerance is not None]
    if found_m_per_s is None:
        return Finding("position", "speed, at rest", "not known", "a sensor without gaps", fine=False, device=True)
    words = f"{1e3 * found_m_per_s:.3g} mm/s at most"
    if not least:
        return Finding("position", "speed, at rest", words)
    expected = f"at most {1e3 * min(least):.3g} mm/s, the speed tolerance of a slide"
    return Finding("position", "speed, at rest", words, expected, found_m_per_s <= min(least), device=True)


def _band_m_per_s(slide: Sliding) -> float:
    """Return the speed tolerance of a slide, or its lower margin if smaller."""
    tolerance = slide.speed_tolerance or 0.0
    return slide.speed_m_per_s * min(tolerance, max(1 - tolerance, 0.0))


def fastest_m_per_s(times_s: FloatArray, along_m: FloatArray) -> float | None:
    """Return the highest speed that a slide's gate measures, or None.

    >>> time_s = np.arange(200) / 1000
    >>> round(fastest_m_per_s(time_s, 0.05 * time_s), 9)
    0.05
    """
    gate, fastest = SpeedGate(target_m_per_s=1.0, tolerance=1.0), None
    for time_s, place_m in zip(times_s.tolist(), along_m.tolist(), strict=True):
        gate = gate.after(time_s, place_m)
        if (speed := gate.speed_m_per_s) is not None:
            fastest = speed if fastest is None else max(fastest, speed)
    return fastest


def _slides(experiment: Experiment | None) -> list[Sliding]:
    conditions = () if experiment is None else experiment.conditions
    return [condition.touch for condition in conditions if isinstance(condition.touch, Sliding)]


def _heard(sensor: StreamedSensor) -> tuple[FloatArray, FloatArray]:
    """Read a sensor for `HEARD_S`, starting at its first sample."""
    with closing(sensor):
        sensor.open()
        silent_s = time.perf_counter() + FIRST_WITHIN_S
        first = sensor.read()
        while not first[0].size and time.perf_counter() < silent_s:
            time.sleep(0.01)
            first = sensor.read()
        time.sleep(HEARD_S if first[0].size else 0.0)
        times_s, values = (np.concatenate(parts) for parts in zip(first, sensor.read(), strict=True))
        return times_s, values


def _known(part: str, values: FloatArray, what: str) -> Iterator[Finding]:
    """Check that a sensor sends samples, and that all are known."""
    if not values.size:
        yield Finding(part, "samples", f"0 in {FIRST_WITHIN_S:g} s", "a sensor that sends", fine=False, device=True)
        return
    n_known = int(np.isfinite(values.reshape(len(values), -1)).all(axis=1).sum())
    yield Finding(part, what, f"{n_known} of {len(values)}", "all of them", n_known == len(values), device=True)


def _in_mm(values_m: FloatArray) -> str:
    return ", ".join(f"{1e3 * value:.3g}" for value in values_m)
