"""Free-edge modes by Ritz: error beside time, over one dense product, and against scikit-fem.

    OMP_NUM_THREADS=1 python benchmarks/time_reversal_modes.py

The error is against the same basis with 20 more degrees; below 25 kHz both solvers are judged by that reference.
scikit-fem runs Bogner-Fox-Schmit elements and scipy's sparse solver, the fair independent peer; it takes minutes. Set
TACTOMETRY_BENCH_QUICK=1 to leave it out.
"""

import os
import statistics
import time

import numpy as np
from numpy.typing import NDArray
from scikit_fem_plate import bogner_fox_schmit_hz
from time_reversal_rounds import interleaved, machine, row

from tactometry.stimuli.time_reversal import Plate
from tactometry.stimuli.time_reversal.plate.plate import degrees, ritz_frequencies_hz
from tactometry.stimuli.time_reversal.plate.ritz import solve

PLATE = Plate(0.297, 0.210, 1.1e-3, 70e9, 0.23, 2500.0, "FFFF")
ELEMENTS = ((40, 28), (60, 42), (90, 63))
WANTED = 1e-3


def frequencies_hz(f_max_hz: float, degree: tuple[int, int] | None = None) -> NDArray[np.float64]:
    solve.cache_clear()
    return ritz_frequencies_hz(PLATE, f_max_hz, degree)


def reference_hz(f_max_hz: float) -> NDArray[np.float64]:
    p_x, p_y = degrees(PLATE, f_max_hz)
    return frequencies_hz(1.001 * f_max_hz, (p_x + 20, p_y + 20))


def error(found: NDArray[np.float64], reference: NDArray[np.float64]) -> float:
    """Largest relative error of the elastic frequencies."""
    n = min(len(found), len(reference))
    return float(np.max(np.abs(found[3:n] / reference[3:n] - 1)))


def against_dense_product() -> None:
    a = np.random.default_rng(0).normal(size=(1500, 1500))
    times = interleaved({"ritz": lambda: frequencies_hz(50e3), "product": lambda: a @ a}, 3)
    worst = error(frequencies_hz(50e3), reference_hz(50e3))
    row(
        "free modes 0-50 kHz: time over one 1500 product",
        times["ritz"] / times["product"],
        f"{times['ritz']:.3g} s",
        at_most=15,
    )
    row("free modes 0-50 kHz: error", worst, unit="", at_most=1e-8)


def to_100_khz() -> None:
    start = time.process_time()
    found = frequencies_hz(100e3)
    spent = time.process_time() - start
    row(
        f"{len(found)} free modes below 100 kHz: error",
        error(found, reference_hz(100e3)),
        f"{spent:.3g} s",
        unit="",
        at_most=1e-9,
    )


def against_scikit_fem() -> None:
    reference = reference_hz(25e3)
    inside = reference[reference <= 25e3]
    p_x, p_y = degrees(PLATE, 25e3)
    fewer = max(k for k in range(25) if error(frequencies_hz(25e3, (p_x - k, p_y - k)), reference) <= WANTED)
    ours = (p_x - fewer, p_y - fewer)
    ours_s = statistics.median(_timed(lambda: frequencies_hz(25e3, ours)) for _ in range(5))
    reached = error(frequencies_hz(25e3, ours), reference)
    print(f"  ours, {ours[0]} x {ours[1]} degrees: error {reached:.2g}, {ours_s:.3g} s")
    for n_x, n_y in ELEMENTS:
        start = time.process_time()
        found = bogner_fox_schmit_hz(PLATE, n_x, n_y, len(inside))
        spent = time.process_time() - start
        theirs = error(found, reference)
        detail, limit = f"theirs: error {theirs:.2g}, {spent:.3g} s", 300 if theirs <= WANTED else None
        row(f"free modes below 25 kHz, {n_x} x {n_y} BFS elements over ours", spent / ours_s, detail, at_least=limit)


def _timed(call: object) -> float:
    start = time.process_time()
    call()  # type: ignore[operator]
    return time.process_time() - start


if __name__ == "__main__":
    print(machine())
    against_dense_product()
    to_100_khz()
    if "TACTOMETRY_BENCH_QUICK" not in os.environ:
        against_scikit_fem()
