"""Preflight of what tells of the finger, which rests meanwhile, or is away: its force, its place and its speed."""

import time
from collections.abc import Iterator
from contextlib import closing

import numpy as np

from tactometry.devices.sensors.streamed import StreamedSensor
from tactometry.gates import SpeedGate
from tactometry.protocols.tasks.touch import Sliding
from tactometry.signal import FloatArray

from ..study.experiment import Experiment
from .bench_file import BenchFile, Devices
from .bench_parts import PositionPart
from .finding import Finding
from .stimuli import check_followed

HEARD_S = 1.0
FIRST_WITHIN_S = 3.0
FEW_BITS = (8, 10, 12, 14, 16)
"""Resolutions of position sensors."""


def force(sensor: StreamedSensor) -> Iterator[Finding]:
    """What a force sensor says at rest."""
    _, forces_n = _heard(sensor)
    yield from _known("force", forces_n, "samples in the calibrated range")
    known_n = forces_n[np.isfinite(forces_n)]
    if known_n.size:
        yield Finding("force", "mean, at rest", f"{known_n.mean():.4g} N")
        yield Finding("force", "noise, sd", f"{known_n.std():.3g} N")


def position(connected: Devices, bench: BenchFile, experiment: Experiment | None) -> Iterator[Finding]:
    """What a position sensor says at rest, and whether a study can rely on it."""
    if connected.position is not None and bench.position is not None:
        yield from _at_rest(connected.position, bench.position, _slides(experiment))
    elif _slides(experiment):
        yield Finding("position", "speed", "not measured: the bench file has no [position]")
    if experiment is not None:
        check_followed(experiment, bench, connected)


def _at_rest(sensor: StreamedSensor, part: PositionPart, slides: list[Sliding]) -> Iterator[Finding]:
    times_s, places_m = _heard(sensor)
    yield from _known("position", places_m, "samples that tell a place")
    is_known = np.isfinite(places_m).all(axis=1)
    if not is_known.any():
        return
    known_m = places_m[is_known]
    yield from _at_full_scale(known_m / part.metres_per_count + (part.zero_counts or 0.0))
    yield Finding("position", "mean, at rest", f"{_in_mm(known_m.mean(axis=0))} mm")
    yield Finding("position", "noise, sd", f"{_in_mm(known_m.std(axis=0))} mm")
    yield _speed(fastest_m_per_s(times_s, places_m[:, 0]), slides)


def _at_full_scale(counts: FloatArray) -> Iterator[Finding]:
    """Find samples at the largest count of a sensor of few bits, which it sends at overload or without a finger."""
    for axis in np.rint(counts).T:
        bits = int(axis.max()).bit_length() if axis.max() > 0 else 0
        if bits in FEW_BITS and axis.max() == 2**bits - 1:
            n_full = int((axis == axis.max()).sum())
            found = f"{n_full} of {len(axis)} at {axis.max():g}, the largest of {bits} bits"
            expected = f"none; if this count means overload, write count_high = {axis.max() - 1:g}"
            yield Finding("position", "counts at full scale", found, expected, fine=False, device=True)


def _speed(found_m_per_s: float | None, slides: list[Sliding]) -> Finding:
    """Of a finger at rest, as the gate of a slide hears it: it must be far from the band in which a finger moves."""
    least = [_band_m_per_s(slide) for slide in slides if slide.speed_tolerance is not None]
    if found_m_per_s is None:
        return Finding("position", "speed, at rest", "not known", "a sensor without gaps", fine=False, device=True)
    words = f"{1e3 * found_m_per_s:.3g} mm/s at most"
    if not least:
        return Finding("position", "speed, at rest", words)
    expected = f"at most {1e3 * min(least):.3g} mm/s, what a slide's speed may be off"
    return Finding("position", "speed, at rest", words, expected, found_m_per_s <= min(least), device=True)


def _band_m_per_s(slide: Sliding) -> float:
    """Half of the width of the band of a slide's speed, or what is left below it."""
    tolerance = slide.speed_tolerance or 0.0
    return slide.speed_m_per_s * min(tolerance, max(1 - tolerance, 0.0))


def fastest_m_per_s(times_s: FloatArray, along_m: FloatArray) -> float | None:
    """The highest speed at which the gate of a slide hears a finger move along its path; None where it hears none.

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
    """The touches of a study that slide."""
    conditions = () if experiment is None else experiment.conditions
    return [condition.touch for condition in conditions if isinstance(condition.touch, Sliding)]


def _heard(sensor: StreamedSensor) -> tuple[FloatArray, FloatArray]:
    """What a sensor says for a while from its first sample on: a board may begin a while after its line was opened."""
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
    """Whether a sensor sends, and how much of it is known."""
    if not values.size:
        yield Finding(part, "samples", f"0 in {FIRST_WITHIN_S:g} s", "a sensor that sends", fine=False, device=True)
        return
    n_known = int(np.isfinite(values.reshape(len(values), -1)).all(axis=1).sum())
    yield Finding(part, what, f"{n_known} of {len(values)}", "all of them", n_known == len(values), device=True)


def _in_mm(values_m: FloatArray) -> str:
    return ", ".join(f"{1e3 * value:.3g}" for value in values_m)
