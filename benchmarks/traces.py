"""Measure the size of traces on disk.

There are 720 touches per hour. In each, the finger presses with 1 N and slides at 50 mm/s for two seconds. Sensors have
1 kHz and resolutions of 0.2 mN and 1 um. A texture of one second has 48 kHz and 16 bits. Tremor, drift and noise are
unverified defaults.
"""

import tempfile
from pathlib import Path

import numpy as np

from tactometry.experiments.harness import tell
from tactometry.records.data_set import Session
from tactometry.records.traces import TraceFiles

N_TOUCHES, TOUCHES_PER_HOUR = 100, 720
RATE_HZ, LASTS_S, CARD_HZ, FULL_SCALE_V = 1000.0, 2.0, 48e3, 100.0
DRIFT_N, TREMOR_N, NOISE_N, COUNT_N = 0.05, 0.01, 0.002, 2e-4
WOBBLE_M, COUNT_M = 5e-6, 1e-6


def stamps(rng: np.random.Generator, begin_s: float) -> np.ndarray:
    n = round(RATE_HZ * LASTS_S)
    return begin_s + np.arange(n) / RATE_HZ + rng.normal(0.0, 2e-5, n)


def force(rng: np.random.Generator, begin_s: float) -> np.ndarray:
    times_s = stamps(rng, begin_s)
    drift = np.cumsum(rng.normal(0.0, DRIFT_N / np.sqrt(len(times_s)), len(times_s)))
    tremor = TREMOR_N * np.sin(2 * np.pi * (10.0 * times_s + rng.uniform()))
    forces_n = 1.0 + drift + tremor + rng.normal(0.0, NOISE_N, len(times_s))
    return np.column_stack([times_s, np.rint(forces_n / COUNT_N) * COUNT_N])


def position(rng: np.random.Generator, begin_s: float) -> np.ndarray:
    times_s = stamps(rng, begin_s)
    along_m = 0.05 * np.abs((times_s - begin_s) % 2.0 - 1.0)
    places_m = np.column_stack([along_m, np.full_like(along_m, 0.02)]) + rng.normal(0.0, WOBBLE_M, (len(times_s), 2))
    return np.column_stack([times_s, np.rint(places_m / COUNT_M) * COUNT_M])


def emitted(rng: np.random.Generator, begin_s: float) -> np.ndarray:
    del begin_s
    times_s = np.arange(round(CARD_HZ)) / CARD_HZ
    share = 0.5 * (1 + np.tanh(20 * np.sin(2 * np.pi * (25 * times_s + rng.uniform()))))
    numbers = np.trunc(32767 * 0.5 * share * np.sin(2 * np.pi * 1000.0 * times_s))
    return (numbers / 32767 * FULL_SCALE_V)[:, None]


KINDS = {"force": (force, RATE_HZ), "position": (position, RATE_HZ), "emitted": (emitted, CARD_HZ)}


def main() -> None:
    rng = np.random.default_rng(1)
    for kind, (make, rate_hz) in KINDS.items():
        with tempfile.TemporaryDirectory() as folder:
            files = TraceFiles(Path(folder), Session("P01", 1, "tutorial"))
            sizes = [files.keep(kind, make(rng, 5.0 * n), rate_hz).n_bytes for n in range(N_TOUCHES)]
            files.close()
        tell(f"{kind}: an hour", float(np.mean(sizes)) * TOUCHES_PER_HOUR / 1e6, "MB")


if __name__ == "__main__":
    main()
