"""Peaks between samples: the error against an exact reference, and the time of the guard over the signal's duration.

Two ladders and a table:

- error over the number of points per sample, each doubling by itself, against a dense interpolation;
- error over the reach of the filter, for white noise, against the FFT of all samples with zeros around them;
- processor time of the checks of a guard over the duration of the signal, for signals at and below the limit.

Run: python benchmarks/filtered_peaks.py
"""

import math
import time
from collections.abc import Callable, Iterator

import numpy as np
from measured import tell

from tactometry.safety import reconstruction
from tactometry.safety.limits import Limits
from tactometry.safety.load import Load
from tactometry.safety.reconstruction import course_peak
from tactometry.signal import FloatArray, Signal

LIMIT_V, N_RUNS, N_NOISES = 100.0, 5, 20
LOAD = Load("electrode", 1e-9, 1e7)
FORMATS = {"1 channel at 48 kHz": (1, 48e3), "8 channels at 192 kHz": (8, 192e3)}


def exact(samples: FloatArray, n_points: int = 64) -> float:
    """Peak of the ideal course: zeros around the samples so far that the periods of an FFT do not matter, then more
    points."""
    n = 1 << (64 * len(samples) - 1).bit_length()
    spectrum = np.zeros(n * n_points // 2 + 1, complex)
    spectrum[: n // 2 + 1] = np.fft.rfft(samples, n)
    spectrum[n // 2] /= 2
    return float(np.max(np.abs(np.fft.irfft(spectrum, n * n_points)))) * n_points


def noises(n: int) -> Iterator[FloatArray]:
    for seed in range(N_NOISES):
        yield np.random.default_rng(seed).uniform(-1.0, 1.0, n)


def points_ladder() -> None:
    """Largest error of the peak of noise for each number of points per sample."""
    peaks = [exact(noise) for noise in noises(250)]
    kept = reconstruction.N_PHASES
    for n_phases in (2, 4, 8, 16, 32, 64):
        reconstruction.N_PHASES = n_phases  # type: ignore[misc]
        reconstruction._kernels.cache_clear()
        errors = [1 - course_peak(noise, 0.0) / peak for noise, peak in zip(noises(250), peaks, strict=True)]
        at_most = 1 / math.cos(math.pi / 2 / kept) - 1 if n_phases == kept else None
        tell(
            f"{n_phases} points per sample: largest error of 20 peaks",
            100 * max(errors),
            "%",
            at_most=_percent(at_most),
        )
    reconstruction.N_PHASES = kept  # type: ignore[misc]
    reconstruction._kernels.cache_clear()


def _percent(part: float | None) -> float | None:
    return None if part is None else 100 * part


def reach_ladder() -> None:
    """Largest error of the peak of white noise, longer than the filter, for each reach."""
    peaks = [exact(noise, 32) for noise in noises(8000)]
    kept = reconstruction.REACH, reconstruction._INNER, reconstruction._HOP
    for reach in (16, 32, 64, 128, 256, 512, 1024):
        _set_reach(reach)
        errors = [abs(1 - course_peak(noise, 0.0) / peak) for noise, peak in zip(noises(8000), peaks, strict=True)]
        at_most = 1.5 if reach == kept[0] else None
        tell(
            f"filter of {reach} samples to either side: largest error of 20 peaks",
            100 * max(errors),
            "%",
            at_most=at_most,
        )
    _set_reach(kept[0])


def _set_reach(reach: int) -> None:
    reconstruction.REACH = reach  # type: ignore[misc]
    reconstruction._INNER = slice(reach, reconstruction.BLOCK - reach)  # type: ignore[misc]
    reconstruction._HOP = reconstruction.BLOCK - 2 * reach - 1  # type: ignore[misc]
    reconstruction._kernels.cache_clear()


def tone(at_s: FloatArray, frequency_hz: float) -> FloatArray:
    ramp = np.clip(np.minimum(at_s, at_s[::-1]) / 0.02, 0.0, 1.0)
    return np.asarray(np.sin(2 * np.pi * frequency_hz * at_s) * ramp)


SIGNALS: dict[str, Callable[[FloatArray], FloatArray]] = {
    "tone of 250 Hz at the limit": lambda at_s: tone(at_s, 250.0),
    "tone of 250 Hz at half the limit": lambda at_s: 0.5 * tone(at_s, 250.0),
    "carrier of 5 kHz at the limit, modulated": lambda at_s: tone(at_s, 5e3) * np.sin(2 * np.pi * 30.0 * at_s) ** 2,
    "carrier of 5 kHz at the limit": lambda at_s: tone(at_s, 5e3),
    "square wave at 0.7 of the limit": lambda at_s: 0.7 * np.sign(np.sin(2 * np.pi * 120.0 * at_s + 1e-3)),
    "white noise at 0.8 of the limit": lambda at_s: 0.8 * np.random.default_rng(0).standard_normal(len(at_s)) / 5.0,
    "random bits at 0.3 of the limit": lambda at_s: 0.3 * np.random.default_rng(0).choice([-1.0, 1.0], len(at_s)),
}


def took_s(limits: Limits, signal: Signal, *, filtered: bool) -> float:
    """Processor time of all checks of a signal, the least of some."""
    least_s = math.inf
    for _ in range(N_RUNS):
        begin_s = time.process_time()
        limits.check(signal)
        limits.check_load(signal, LOAD)
        if filtered:
            limits.check_filtered(signal, LOAD)
        least_s = min(least_s, time.process_time() - begin_s)
    return least_s


def times() -> None:
    """A limit of current is 1.5 times what straight lines between the samples draw."""
    for format_name, (n_channels, rate_hz) in FORMATS.items():
        at_s = np.arange(round(rate_hz)) / rate_hz
        for name, course in SIGNALS.items():
            signal = Signal(LIMIT_V * np.tile(course(at_s), (n_channels, 1)), rate_hz, "V")
            most_a = (4.0 if "bits" in name else 1.5) * LOAD.current_peak_a(signal)
            limits = Limits(LIMIT_V, 60.0, current_peak_a=most_a, duty=1.0, session_s=1e9)
            before, after = (100 * took_s(limits, signal, filtered=on) for on in (False, True))
            what = f"{format_name}, {name}: time of the checks over the signal's"
            tell(f"{what}, peaks between samples alone", after - before, "%", at_most=5.0)
            tell(what, after, "%")


def main() -> None:
    points_ladder()
    reach_ladder()
    times()


if __name__ == "__main__":
    main()
