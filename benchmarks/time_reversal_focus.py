"""Time a focus on a plate, computed by modes and by finite differences.

The plate is simply supported. The finite-difference scheme is compiled.

    OMP_NUM_THREADS=1 python benchmarks/time_reversal_focus.py

The pulse has 10 kHz, with 32 transducers, T = 15 ms and tau = 10 ms. The times for 1 % and 0.1 % error of the focus are
interpolated between grids. TACTOMETRY_BENCH_QUICK=1 omits the finest grid, which takes minutes. The time for 0.1 % is
then extrapolated with error ~ h^2 and work ~ h^-4.
"""

import math
import os
from functools import partial
from statistics import median

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.signal import fftconvolve
from threadpoolctl import threadpool_limits

from tactometry.experiments.harness import interleaved, run_once, tell
from tactometry.stimuli.time_reversal import Plate
from tactometry.stimuli.time_reversal.responses.responses import impulse_responses
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.screen import Screen
from tactometry.stimuli.time_reversal.screen.transducer import PointForce

Array = NDArray[np.float64]
PLATE = Plate(0.297, 0.210, 1.1e-3, 70e9, 0.23, 2500.0, "SSSS")
TAU_S, T_S, PULSE_HZ, RATE_HZ = 10e-3, 15e-3, 10e3, 100e3
FOCUS = (0.120, 0.090)
STEPS_M = (3e-3, 1.5e-3, 1e-3) if os.environ.get("TACTOMETRY_BENCH_QUICK") == "1" else (3e-3, 1.5e-3, 1e-3, 0.5e-3)
MODES = ((18e3, 50e3), (21e3, 50e3), (31e3, 100e3))
"""Highest mode frequencies and sampling rates (Hz)."""


def places() -> list[tuple[float, float]]:
    """Return 32 points near the edges that are nodes of all grids (multiples of 3 mm)."""
    x = [0.003 * round(i) for i in np.linspace(6, 93, 10)]
    y = [0.003 * round(i) for i in np.linspace(10, 60, 6)]
    return [(a, b) for b in (0.012, 0.198) for a in x] + [(a, b) for a in (0.012, 0.285) for b in y]


def pulse(t: Array) -> Array:
    """Return a Ricker pulse centred at 0.15 ms."""
    s = (np.pi * PULSE_HZ * (t - 1.5 / PULSE_HZ)) ** 2
    return np.asarray((1 - 2 * s) * np.exp(-s))


def modal(f_max_hz: float, rate_hz: float) -> Array:
    """Return responses (32, n) to the pulse, computed by modes."""
    screen = Screen(PLATE, tuple(PointForce(*p) for p in places()), Attenuation(TAU_S))
    h = impulse_responses(screen, [FOCUS], rate_hz=rate_hz, duration_s=T_S, f_max_hz=f_max_hz)
    shape = pulse(np.arange(round(4 / PULSE_HZ * rate_hz)) / rate_hz)
    return np.asarray(fftconvolve(h.samples[0], shape[None], axes=1)[:, : h.n_samples])


def finite_differences(step_m: float) -> Array:
    """Return responses (32, n) at the focus, by explicit second-order differences.

    The time step is 0.99 of the stability limit. By reciprocity, one run with the pulse at the focus yields all 32
    responses, which favours this method.
    """
    n_x, n_y = round(PLATE.length_m / step_m), round(PLATE.width_m / step_m)
    limit_s = step_m**2 / (4 * PLATE.wave_constant_m2_per_s)
    per_sample = math.ceil(1 / (0.99 * limit_s * RATE_HZ))
    dt, n = 1 / (RATE_HZ * per_sample), round(T_S * RATE_HZ)
    source = pulse(np.arange(n * per_sample) * dt) * dt**2 / (PLATE.area_density_kg_per_m2 * step_m**2)
    at = np.array([[round(x / step_m), round(y / step_m)] for x, y in places()])
    focus = (round(FOCUS[0] / step_m), round(FOCUS[1] / step_m))
    courant = (PLATE.wave_constant_m2_per_s * dt / step_m**2) ** 2
    return _march(n_x, n_y, courant, dt / TAU_S, source, focus, at, n, per_sample)


@njit(cache=True)
def _march(n_x, n_y, courant, loss, source, focus, at, n, per_sample):  # type: ignore[no-untyped-def]
    old = np.zeros((n_x + 3, n_y + 3))
    now = np.zeros((n_x + 3, n_y + 3))
    new = np.zeros((n_x + 3, n_y + 3))
    out = np.zeros((len(at), n))
    for k in range(n):
        for i in range(len(at)):
            out[i, k] = now[at[i, 0] + 1, at[i, 1] + 1]
        for s in range(per_sample):
            now[0, :] = -now[2, :]
            now[n_x + 2, :] = -now[n_x, :]
            now[:, 0] = -now[:, 2]
            now[:, n_y + 2] = -now[:, n_y]
            for i in range(2, n_x + 1):
                for j in range(2, n_y + 1):
                    near = now[i + 1, j] + now[i - 1, j] + now[i, j + 1] + now[i, j - 1]
                    corner = now[i + 1, j + 1] + now[i - 1, j + 1] + now[i + 1, j - 1] + now[i - 1, j - 1]
                    far = now[i + 2, j] + now[i - 2, j] + now[i, j + 2] + now[i, j - 2]
                    bending = 20 * now[i, j] - 8 * near + 2 * corner + far
                    new[i, j] = (2 * now[i, j] - (1 - loss) * old[i, j] - courant * bending) / (1 + loss)
            new[focus[0] + 1, focus[1] + 1] += source[k * per_sample + s] / (1 + loss)
            old, now, new = now, new, old
    return out


def main() -> None:
    exact = modal(60e3, 2 * RATE_HZ)[:, ::2]
    energy = float(np.sum(exact**2))

    def error(found: Array) -> float:
        return abs(float(np.sum(found**2)) * (exact.shape[1] // found.shape[1]) / energy - 1)

    times = interleaved({str(pair): partial(modal, *pair) for pair in MODES}, 15, turn_s=5e-3)
    ours = [(median(times[str(pair)]), error(modal(*pair))) for pair in MODES]
    finite_differences(6e-3)
    theirs = []
    for step_m in STEPS_M:
        spent_s, found = run_once(partial(finite_differences, step_m))
        theirs.append((spent_s, error(found)))
        print(f"differences {step_m * 1e3:g} mm: {spent_s:.3g} s, error of the focus {theirs[-1][1]:.2e}")
    for largest, goal in ((1e-2, 200), (1e-3, 2000)):
        ours_s = min(spent_s for spent_s, reached in ours if reached <= largest)
        tell(
            f"focus at {largest:.1%} error, compiled differences over ours",
            time_at(theirs, largest) / ours_s,
            at_least=goal,
        )


def time_at(points: list[tuple[float, float]], wanted: float) -> float:
    """Return the time for an error, by log-log interpolation between grids.

    Beyond the grids, the error is assumed to be proportional to time^(-1/2).
    """
    spent, error = np.log([p[0] for p in points]), np.log([p[1] for p in points])
    if math.log(wanted) < error[-1]:
        return float(np.exp(spent[-1] + 2 * (error[-1] - math.log(wanted))))
    return float(np.exp(np.interp(-math.log(wanted), -error, spent)))


if __name__ == "__main__":
    with threadpool_limits(1):
        main()
