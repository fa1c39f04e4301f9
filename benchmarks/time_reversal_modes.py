"""Time free-edge plate modes by the Ritz method, compared with scikit-fem.

    OMP_NUM_THREADS=1 python benchmarks/time_reversal_modes.py

The reference of the error is the same basis with 20 more degrees. scikit-fem uses Bogner-Fox-Schmit elements and
scipy's sparse solver, and takes minutes. TACTOMETRY_BENCH_QUICK=1 omits it.
"""

import os
from functools import partial
from statistics import median

import numpy as np
from numpy.typing import NDArray
from peers_of_plates import bogner_fox_schmit_hz
from threadpoolctl import threadpool_limits

from tactometry.experiments.harness import interleaved, run_once, tell
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
    """Return the largest relative error of the elastic modes' frequencies."""
    n = min(len(found), len(reference))
    return float(np.max(np.abs(found[3:n] / reference[3:n] - 1)))


def against_dense_product() -> None:
    a = np.random.default_rng(0).normal(size=(1500, 1500))
    times = interleaved({"ritz": partial(frequencies_hz, 50e3), "product": lambda: a @ a}, 3, turn_s=5e-3)
    ratio = median(times["ritz"]) / median(times["product"])
    tell("free modes 0-50 kHz: time over one 1500 product", ratio, at_most=15)
    tell("free modes 0-50 kHz: error", error(frequencies_hz(50e3), reference_hz(50e3)), "", at_most=1e-8)


def to_100_khz() -> None:
    result = frequencies_hz(100e3)
    tell(f"{len(result)} free modes below 100 kHz: error", error(result, reference_hz(100e3)), "", at_most=1e-9)


def against_scikit_fem() -> None:
    reference = reference_hz(25e3)
    n_modes = int(np.count_nonzero(reference <= 25e3))
    p_x, p_y = degrees(PLATE, 25e3)
    fewer = max(k for k in range(25) if error(frequencies_hz(25e3, (p_x - k, p_y - k)), reference) <= WANTED)
    ours = partial(frequencies_hz, 25e3, (p_x - fewer, p_y - fewer))
    ours_s = median(interleaved({"ours": ours}, 5)["ours"])
    for n_x, n_y in ELEMENTS:
        theirs_s, result = run_once(partial(bogner_fox_schmit_hz, PLATE, n_x, n_y, n_modes))
        limit = 300 if error(result, reference) <= WANTED else None
        tell(f"free modes below 25 kHz, {n_x} x {n_y} BFS elements over ours", theirs_s / ours_s, at_least=limit)


if __name__ == "__main__":
    with threadpool_limits(1):
        against_dense_product()
        to_100_khz()
        if "TACTOMETRY_BENCH_QUICK" not in os.environ:
            against_scikit_fem()
