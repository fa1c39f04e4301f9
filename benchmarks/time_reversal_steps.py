"""Exact steps against Newmark's method, and compiled sigma-delta against numpy loops.

    OMP_NUM_THREADS=1 python benchmarks/time_reversal_steps.py

Newmark (average acceleration, compiled too) subdivides each step until its error falls to 1e-5 of the largest modal
displacement; each contender gets its forces in the order of memory it likes. Errors are against the exact
steps, which `tests/stimuli/time_reversal/test_propagator.py` checks to 40 digits.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray
from time_reversal_rounds import interleaved, machine, row

from tactometry.stimuli.time_reversal import Plate
from tactometry.stimuli.time_reversal.focusing.modulator import modulate
from tactometry.stimuli.time_reversal.focusing.quantiser import normalised
from tactometry.stimuli.time_reversal.plate.modes import modes_of
from tactometry.stimuli.time_reversal.plate.oscillators import Oscillators
from tactometry.stimuli.time_reversal.plate.propagator import run_linear

Array = NDArray[np.float64]
RATE_HZ, N = 100e3, 1500


def stepping() -> None:
    plate = Plate(0.297, 0.210, 1.1e-3, 70e9, 0.23, 2500.0, "SSSS")
    omega = modes_of(plate, 31.25e3).angular_frequency_rad_per_s
    oscillators = Oscillators(omega, np.full(len(omega), 100.0))
    noise = np.random.default_rng(0).normal(size=(len(omega), N + 40))
    smooth = np.stack([np.convolve(one, np.hanning(41), "valid") for one in noise])
    by_time = np.ascontiguousarray(smooth.T)
    exact = run_linear(oscillators, smooth, RATE_HZ)

    def error(n_sub: int) -> float:
        found = newmark(omega, 100.0, smooth, 1 / RATE_HZ, n_sub)
        return float(np.max(np.abs(found - exact)) / np.abs(exact).max())

    n_sub = 1
    while error(n_sub) > 1e-5:
        n_sub *= 2
    times = interleaved(
        {
            "exact": lambda: run_linear(oscillators, by_time.T, RATE_HZ),
            "newmark": lambda: newmark(omega, 100.0, smooth, 1 / RATE_HZ, n_sub),
        },
        5,
    )
    detail = f"{n_sub} substeps, error {error(n_sub):.2g}; ours {times['exact'] * 1e3:.3g} ms"
    row("exact step against Newmark at 1e-5", times["newmark"] / times["exact"], detail, at_least=100)


@njit(cache=True)
def newmark(omega, a, forces, step, n_sub):  # type: ignore[no-untyped-def]
    """Average acceleration for q'' + 2 a q' + w^2 q = f, f linear between samples."""
    n, n_samples = forces.shape
    h = step / n_sub
    out = np.zeros((n, n_samples))
    for i in range(n):
        q, v = 0.0, 0.0
        acc = forces[i, 0]
        w2 = omega[i] ** 2
        for k in range(1, n_samples):
            for s in range(1, n_sub + 1):
                f = forces[i, k - 1] + (forces[i, k] - forces[i, k - 1]) * s / n_sub
                q_guess = q + h * v + h * h / 4 * acc
                v_guess = v + h / 2 * acc
                acc = (f - 2 * a * v_guess - w2 * q_guess) / (1 + a * h + w2 * h * h / 4)
                q = q_guess + h * h / 4 * acc
                v = v_guess + h / 2 * acc
            out[i, k] = q
    return out


def sigma_delta() -> None:
    by_time = 0.7 * normalised(np.random.default_rng(0).normal(size=(20_000, 32)))
    signal = by_time.T

    def over_time(order: int) -> Array:
        bits = np.empty_like(by_time)
        e1, e2 = np.zeros(32), np.zeros(32)
        for t in range(len(by_time)):
            y = by_time[t] - e1 if order == 1 else by_time[t] - 2 * e1 + e2
            bits[t] = np.where(y >= 0, 1.0, -1.0)
            e2, e1 = e1, bits[t] - y
        return bits.T

    for order in (1, 2):
        assert np.array_equal(modulate(signal, order).bits, over_time(order))
        times = interleaved({"ours": lambda k=order: modulate(signal, k), "numpy": lambda k=order: over_time(k)}, 7)
        detail = f"{times['ours'] * 1e3:.3g} ms"
        row(
            f"sigma-delta order {order}, 32 x 20 000, against numpy",
            times["numpy"] / times["ours"],
            detail,
            at_least=200 if order == 2 else None,
        )


if __name__ == "__main__":
    print(machine())
    stepping()
    sigma_delta()
