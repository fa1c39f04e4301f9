"""Measure error and time of the output guard's peaks between samples.

The results are:

- the error by number of points per sample, compared with a dense interpolation,
- the error by reach of the filter for white noise, compared with an FFT of all samples with zeros around them, and
- the processor time of a guard's checks over the duration of the signal.
"""

import math
from collections.abc import Callable

import numpy as np

from tactometry.experiments.harness import interleaved, tell
from tactometry.safety import reconstruction
from tactometry.safety.limits import Limits
from tactometry.safety.load import Load
from tactometry.safety.reconstruction import course_peak
from tactometry.signal import FloatArray, Signal

LIMIT_V, N_RUNS, N_NOISES = 100.0, 5, 20
LOAD = Load("electrode", 1e-9, 1e7)
FORMATS = {"1 channel at 48 kHz": (1, 48e3), "8 channels at 192 kHz": (8, 192e3)}


def exact(samples: FloatArray, n_points: int) -> float:
    """Return the peak of the ideal interpolation, from an FFT with more points and zeros around the samples."""
    n = 1 << (64 * len(samples) - 1).bit_length()
    spectrum = np.zeros(n * n_points // 2 + 1, complex)
    spectrum[: n // 2 + 1] = np.fft.rfft(samples, n)
    spectrum[n // 2] /= 2
    return float(np.max(np.abs(np.fft.irfft(spectrum, n * n_points)))) * n_points


def largest_error(n_samples: int, n_points: int) -> Callable[[], float]:
    """Return a function that computes the largest error (%) of peaks of noise with the current constants."""
    noises = [np.random.default_rng(seed).uniform(-1.0, 1.0, n_samples) for seed in range(N_NOISES)]
    peaks = [exact(noise, n_points) for noise in noises]

    def error() -> float:
        reconstruction._kernels.cache_clear()
        return 100 * max(abs(1 - course_peak(noise, 0.0) / peak) for noise, peak in zip(noises, peaks, strict=True))

    return error


def points() -> None:
    error, kept = largest_error(250, 64), reconstruction.N_PHASES
    for n_phases in (2, 4, 8, 16, 32, 64):
        reconstruction.N_PHASES = n_phases  # type: ignore[misc]
        limit = 100 * (1 / math.cos(math.pi / 2 / kept) - 1) if n_phases == kept else None
        tell(f"{n_phases} points per sample: largest error of 20 peaks", error(), "%", at_most=limit)
    reconstruction.N_PHASES = kept  # type: ignore[misc]


def reaches() -> None:
    error, kept = largest_error(8000, 32), reconstruction.REACH
    for reach in (16, 32, 64, 128, 256, 512, 1024):
        set_reach(reach)
        limit = 1.5 if reach == kept else None
        name = f"filter of {reach} samples to either side: largest error of 20 peaks"
        tell(name, error(), "%", at_most=limit)
    set_reach(kept)


def set_reach(reach: int) -> None:
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


def times() -> None:
    """Time the checks. The current limit is 1.5 times the current for straight lines between samples."""
    for format_name, (n_channels, rate_hz) in FORMATS.items():
        at_s = np.arange(round(rate_hz)) / rate_hz
        for name, course in SIGNALS.items():
            signal = Signal(LIMIT_V * np.tile(course(at_s), (n_channels, 1)), rate_hz, "V")
            most_a = (4.0 if "bits" in name else 1.5) * LOAD.current_peak_a(signal)
            limits = Limits(LIMIT_V, 60.0, current_peak_a=most_a, duty=1.0, session_s=1e9)
            checks = {
                "samples": lambda: (limits.check(signal), limits.check_load(signal, LOAD)),  # noqa: B023
                "peaks": lambda: limits.check_filtered(signal, LOAD),  # noqa: B023
            }
            samples_s, peaks_s = (min(each) for each in interleaved(checks, N_RUNS).values())
            what = f"{format_name}, {name}: time of the checks over the signal's"
            tell(f"{what}, peaks between samples alone", 100 * peaks_s, "%", at_most=5.0)
            tell(what, 100 * (samples_s + peaks_s), "%")


if __name__ == "__main__":
    points()
    reaches()
    times()
