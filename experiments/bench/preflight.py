"""Preflight: what a session needs, tried before a participant comes."""

import os
import shutil
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import date
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np

from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.outputs.output import with_ramps
from tactometry.devices.sensors.reader import Reader, SampleBlock
from tactometry.devices.sensors.streamed import StreamedSensor
from tactometry.errors import TactometryError
from tactometry.gates.force import ForceGate
from tactometry.rigs.bench import Facts
from tactometry.rigs.frame_timing import timing_of
from tactometry.rigs.pages.layout import marker_page, message_page
from tactometry.rigs.pages.page import Display, KeyDown, Page
from tactometry.rigs.texts import texts_in
from tactometry.safety.limits import Limits
from tactometry.signal import Signal

from ..study.experiment import Experiment, wire
from ..study.study_file import load
from .bench_file import BenchFile, DisplayTable
from .learnt_stimuli import bank_of

LISTEN_S = 2.0
N_FRAMES = 60
DROPPED_AT_MOST = 0.01
"""Part of the frames that may be dropped (unverified default)."""
PERIOD: Final = "frame_period"
RATE_TOLERANCE = 0.02
"""Of a sensor's nominal rate (unverified default)."""
MAX_GAP_S: Final = ForceGate(target_n=1.0, tolerance=0.1, hold_s=0.0).max_gap_s
N_KEYS, KEYS_WITHIN_S = 3, 10.0
"""So many keys are asked for, and waited for no longer."""
KEY_TO_RECORD_AT_MOST_S = 0.05
"""Three frames: one until the key is seen, and the disk (unverified default)."""
LATENCY_AT_MOST_S = 0.02
"""Age of the newest sample when it is read (unverified default)."""
FREE_BYTES = 10**9
SYNC_AT_MOST_S = 0.1
"""A trial's record on disk, longest of ten (unverified default)."""
TONE_PART = 0.1
"""The test tone's part of the voltage limit (unverified default)."""
TONE_HZ, TONE_S, TONE_RAMP_S = 100.0, 0.5, 0.1


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at; `fine` is None where there is nothing to judge."""

    part: str
    what: str
    found: str
    expected: str = ""
    fine: bool | None = None
    device: bool = False


def check(study: str | None, bench: BenchFile, folder: Path, *, hands_off: bool) -> list[Finding]:
    """Everything in turn; what fails is a finding, and the rest is looked at all the same.

    Parameters
    ----------
    study : str, optional
        Name or path; its limits hold beside those of the bench.
    bench : BenchFile
    folder : Path
        Where data would be written.
    hands_off : bool
        Whether somebody said that nobody touches the surface: a connected output plays nothing without it.
    """
    findings, experiment = _study(study) if study is not None else ([], None)
    limits = experiment.study.limits if experiment is not None else bench.limits
    parts: dict[str, Callable[[], Iterator[Finding]]] = {
        "computer": _computer,
        "disk": lambda: _disk(_existing(folder)),
        "display": lambda: _display(bench.screen, _existing(folder)),
        "devices": lambda: _devices(bench, limits, experiment, hands_off=hands_off),
    }
    for part, look in parts.items():
        findings += _guarded(part, look)
    return findings


def exit_status(findings: list[Finding]) -> int:
    """3 if a device failed, 1 if something else is not fine, else 0.

    >>> exit_status([Finding("disk", "free", "1 GB", fine=True), Finding("display", "", "", fine=False, device=True)])
    3
    """
    if any(finding.fine is False and finding.device for finding in findings):
        return 3
    return int(any(finding.fine is False for finding in findings))


def _guarded(part: str, look: Callable[[], Iterator[Finding]]) -> list[Finding]:
    found: list[Finding] = []
    try:
        for finding in look():
            found.append(finding)  # noqa: PERF402  # what was found before a failure stays
    except TactometryError as error:
        found.append(Finding(part, "failed", str(error), fine=False, device=error.exit_status == 3))
    return found


def _study(study: str) -> tuple[list[Finding], Experiment | None]:
    try:
        experiment = wire(load(study)[0], study)
    except TactometryError as error:
        return [Finding("study", study, str(error), "a study that can run", fine=False)], None
    n = len(experiment.bank)
    words = f"{n} {'stimulus' if n == 1 else 'stimuli'}; the strongest levels are within the study's limits"
    return [Finding("study", study, words, fine=True)], experiment


def _computer() -> Iterator[Finding]:
    import scipy.linalg  # noqa: F401  # loads its own BLAS
    from threadpoolctl import threadpool_info

    yield Finding("computer", "Python", sys.version.split()[0])
    yield Finding("computer", "cores", f"{os.cpu_count()}")
    for pool in threadpool_info():
        kind = f"{pool['internal_api']} {pool.get('version') or ''} {pool.get('architecture', '')}".split()
        yield Finding("computer", f"{pool['user_api']} threads", f"{pool['num_threads']} ({' '.join(kind)})")


def _existing(folder: Path) -> Path:
    return next(parent for parent in (folder, *folder.absolute().parents) if parent.is_dir())


def _disk(folder: Path) -> Iterator[Finding]:
    free = shutil.disk_usage(folder).free
    yield Finding("disk", "free", f"{free / 1e9:.1f} GB", f"at least {FREE_BYTES / 1e9:g} GB", free >= FREE_BYTES)
    try:
        longest_s = _longest_sync_s(folder)
    except OSError as error:
        yield Finding("disk", "writing", f"{folder}: {error.strerror}", "a folder that can be written", fine=False)
        return
    fine = longest_s <= SYNC_AT_MOST_S
    yield Finding(
        "disk", "a record, to disk", f"{1e3 * longest_s:.1f} ms", f"at most {1e3 * SYNC_AT_MOST_S:g} ms", fine
    )


def _longest_sync_s(folder: Path, n_records: int = 10) -> float:
    took_s = []
    with _recorder(folder) as record:
        for _ in range(n_records):
            begin_s = time.perf_counter()
            record()
            took_s.append(time.perf_counter() - begin_s)
    return max(took_s)


@contextmanager
def _recorder(folder: Path) -> Iterator[Callable[[], None]]:
    """What puts a record of a trial's length on the disk."""
    import tempfile

    with tempfile.TemporaryFile(dir=folder) as file:

        def record() -> None:
            file.write(b"x" * 500)
            file.flush()
            os.fsync(file.fileno())

        yield record


def _display(screen: DisplayTable, folder: Path) -> Iterator[Finding]:
    from tactometry.rigs.window import Window

    window = Window(fullscreen=screen.fullscreen, size=(screen.width_px, screen.height_px))
    try:
        page = marker_page(None, playing=False)
        window.present(page)
        for _ in range(N_FRAMES):
            window.refresh(page)
        facts, timing = window.facts(), timing_of(window.frame_intervals_s(), window.period_s)
        pressed = _pressed(window, screen.language, folder)
    finally:
        window.close()
    yield from _shown(screen, facts, timing)
    yield pressed


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
            if isinstance(event, KeyDown) and event.at_s >= onset_s:
                record()
                delays_s.append(time.perf_counter() - event.at_s)
        screen.refresh(page)
    return delays_s


def _pressed(screen: Display, language: str, folder: Path) -> Finding:
    words = texts_in(language, {}).message("key_test", {"n_keys": N_KEYS, "within_s": KEYS_WITHIN_S})
    try:
        with _recorder(folder) as record:
            delays_s = key_to_record_s(screen, message_page(words, "", screen.aspect), record, N_KEYS, KEYS_WITHIN_S)
    except OSError as error:
        return Finding(
            "display", "key to record", f"{folder}: {error.strerror}", "a folder that can be written", fine=False
        )
    if not delays_s:
        return Finding("display", "key to record", f"no key was pressed in {KEYS_WITHIN_S:g} s")
    median_s = float(np.median(delays_s))
    words = f"{1e3 * median_s:.1f} ms, longest {1e3 * max(delays_s):.1f}, of {len(delays_s)} keys"
    limit = f"median at most {1e3 * KEY_TO_RECORD_AT_MOST_S:g} ms"
    return Finding("display", "key to record", words, limit, median_s <= KEY_TO_RECORD_AT_MOST_S)


def _shown(screen: DisplayTable, facts: Facts, timing: Mapping[str, int | float | None]) -> Iterator[Finding]:
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
    known = facts[f"{PERIOD}_nominal_s"] is not None
    return Finding(
        "display", "frame period", measured, expected if known else "steady", bool(facts[f"{PERIOD}_trusted"])
    )


def _devices(
    bench: BenchFile, limits: Limits | None, experiment: Experiment | None, *, hands_off: bool
) -> Iterator[Finding]:
    devices = bench.devices(limits or Limits(voltage_peak_v=1.0), date.today(), touched=False)
    for name, reader in devices.readers.items():
        yield from _guarded(f"sensor {name}", partial(_sensor, name, reader))
    if devices.force is not None:
        yield from _guarded("force", partial(_force, devices.force))
    yield from _guarded("output", partial(_gate, bench))
    yield from _guarded("output", partial(_tried, devices.output, bench, limits, experiment, hands_off=hands_off))


def _sensor(name: str, reader: Reader) -> Iterator[Finding]:
    part, listener = f"sensor {name}", reader.listen()
    reader.open()
    try:
        yield Finding(part, "opened", reader.source.name, fine=True)
        ages_s, end_s = [], time.perf_counter() + LISTEN_S
        blocks = []
        while time.perf_counter() < end_s:
            time.sleep(0.002)
            block = listener.read(reader.source.n_channels)
            if block.times_s.size:
                ages_s.append(time.perf_counter() - block.times_s[-1])
                blocks.append(block)
    finally:
        reader.close()
    yield from _stream(part, reader, blocks, ages_s)


def _stream(part: str, reader: Reader, blocks: list[SampleBlock], ages_s: list[float]) -> Iterator[Finding]:
    times_s = np.concatenate([block.times_s for block in blocks]) if blocks else np.empty(0)
    if times_s.size < 2:
        yield Finding(part, "samples", f"{times_s.size} in {LISTEN_S:g} s", "a sensor that sends", False, device=True)
        return
    rate_hz, nominal_hz = (times_s.size - 1) / (times_s[-1] - times_s[0]), reader.source.rate_hz
    fine = bool(abs(rate_hz / nominal_hz - 1) <= RATE_TOLERANCE)
    yield Finding(part, "rate", f"{rate_hz:.1f} Hz", f"{nominal_hz:g} Hz", fine, device=True)
    gap_s = float(np.diff(times_s).max())
    yield Finding(part, "largest gap", f"{1e3 * gap_s:.1f} ms", f"at most {1e3 * MAX_GAP_S:g} ms", gap_s <= MAX_GAP_S)
    age_s = float(np.median(ages_s))
    limit = f"at most {1e3 * LATENCY_AT_MOST_S:g} ms"
    yield Finding(part, "latency, median", f"{1e3 * age_s:.1f} ms", limit, age_s <= LATENCY_AT_MOST_S)
    counted = {key: value for key, value in reader.facts().items() if value not in {None, 0}}
    yield Finding(part, "counts", ", ".join(f"{key} {_short(value)}" for key, value in counted.items()))


def _short(value: str | float | None) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _force(force: StreamedSensor) -> Iterator[Finding]:
    force.open()
    try:
        time.sleep(LISTEN_S / 2)
        _, forces_n = force.read()
    finally:
        force.close()
    if not forces_n.size:
        yield Finding("force", "samples", f"0 in {LISTEN_S / 2:g} s", "a sensor that sends", False, device=True)
        return
    known_n = forces_n[np.isfinite(forces_n)]
    fine = known_n.size == forces_n.size
    words = f"{known_n.size} of {forces_n.size}"
    yield Finding("force", "samples in the calibrated range", words, "all of them", fine, device=True)
    if known_n.size:
        yield Finding("force", "mean, at rest", f"{known_n.mean():.4g} N")
        yield Finding("force", "noise, sd", f"{known_n.std():.3g} N")


def _gate(bench: BenchFile) -> Iterator[Finding]:
    """What stops the output when the finger leaves; a bench that has no such thing and does not say so is not fine."""
    bench.check_gate()
    for words in bench.cautions:
        yield Finding("output", "caution", words)


def _tried(
    output: Guarded, bench: BenchFile, limits: Limits | None, experiment: Experiment | None, *, hands_off: bool
) -> Iterator[Finding]:
    """The tone and the strongest stimuli; limits that the load needs and nobody stated stop all of them, said once."""
    if output.limits is not None and output.load is not None:
        output.limits.check_stated(output.load)
    yield from _guarded("output", partial(_output, output, limits, hands_off=hands_off))
    if experiment is not None:
        yield from _guarded("output", partial(_strongest, output, experiment, bench))


def _output(output: Guarded, limits: Limits | None, *, hands_off: bool) -> Iterator[Finding]:
    if limits is None and not output.driver.connected:
        yield Finding("output", "limits", "none stated; give a study or a bench file with limits")
        return
    if output.driver.connected and not hands_off:
        yield Finding("output", "test tone", "not played: nobody said that hands are off", "--hands-off", fine=False)
        return
    try:
        output.open()
        yield Finding("output", "opened", output.name, fine=True)
        tone = tone_of(output)
        begin_s = time.perf_counter()
        onset_s = output.play(tone)
        time.sleep(tone.duration_s)
        output.stop()
    finally:
        output.close()
    yield Finding("output", "test tone", f"{tone.peak:.3g} V, {tone.duration_s:.3g} s", "within limits", fine=True)
    yield Finding("output", "onset after the call", f"{1e3 * (onset_s - begin_s):.1f} ms")
    n_underruns = output.facts().get("n_underruns")
    if n_underruns is not None:
        yield Finding("output", "underruns", f"{n_underruns}", "0", n_underruns == 0, device=True)


def tone_of(output: Guarded) -> Signal:
    """A tone with ramps at a part of the voltage limit; for one bit, a thousand samples at the supply's voltage."""
    n_channels, rate_hz = output.n_channels or 1, output.rate_hz or 48_000.0
    if output.driver.one_bit:
        bits = np.where(np.arange(1000) // 10 % 2, -1.0, 1.0)
        return Signal(np.tile(bits, (n_channels, 1)) * output.full_scale_v, rate_hz, "V")
    times_s = np.arange(round(TONE_S * rate_hz)) / rate_hz
    ramp = np.sin(np.pi / 2 * np.clip(np.minimum(times_s, TONE_S - times_s) / TONE_RAMP_S, 0, 1)) ** 2
    limit_v = output.limits.voltage_peak_v if output.limits is not None else 0.0
    voltage_v = TONE_PART * min(limit_v, output.full_scale_v)
    return Signal(np.tile(voltage_v * ramp * np.sin(2 * np.pi * TONE_HZ * times_s), (n_channels, 1)), rate_hz, "V")


def _strongest(output: Guarded, experiment: Experiment, bench: BenchFile) -> Iterator[Finding]:
    """Each stimulus at its highest level against the output; none is played."""
    for strongest in experiment.strongest(bank_of(experiment, bench.time_reversal)):
        words, fine, device = f"level {strongest.level:g}", True, False
        try:
            output.check(with_ramps(strongest.signal, bench.output.ramp_s))
        except TactometryError as error:
            words, fine, device = f"{words} of {strongest.name}: {error}", False, error.exit_status == 3
        yield Finding("output", f"strongest {strongest.name}", words, "within limits", fine, device)
