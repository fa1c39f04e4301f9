"""A focus on the simply supported plate: modes against a compiled finite-difference scheme, error beside time.

    OMP_NUM_THREADS=1 python benchmarks/time_reversal_focus.py

A pulse of 10 kHz, 32 transducers, T = 15 ms, tau = 10 ms. Finite differences focus well in their own wrong medium, so
two more columns judge them: the error of the drive waveforms, and what their drives reach on the exact plate.
The time at 1 % and 0.1 % focus error is interpolated between grids. The finest takes minutes; TACTOMETRY_BENCH_QUICK=1
leaves it out, and 0.1 % is then extrapolated by error ~ h^2 and work ~ h^-4, which its row says.
"""

import math
import os
import time

import numpy as np
from numba import njit
from numpy.typing import NDArray
from time_reversal_rounds import interleaved, machine, row

from tactometry.stimuli.time_reversal import Plate
from tactometry.stimuli.time_reversal.responses.responses import Responses, impulse_responses
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.screen import Screen
from tactometry.stimuli.time_reversal.screen.transducer import PointForce

Array = NDArray[np.float64]
PLATE = Plate(0.297, 0.210, 1.1e-3, 70e9, 0.23, 2500.0, "SSSS")
TAU_S, T_S, PULSE_HZ = 10e-3, 15e-3, 10e3
FOCUS = (0.120, 0.090)
QUICK = os.environ.get("TACTOMETRY_BENCH_QUICK") == "1"
STEPS_M = (3e-3, 1.5e-3, 1e-3) if QUICK else (3e-3, 1.5e-3, 1e-3, 0.5e-3)
RATE_HZ = 100e3


def places() -> list[tuple[float, float]]:
    """32 points on nodes of every grid, multiples of 3 mm, near the edges."""
    x = [0.003 * round(i) for i in np.linspace(6, 93, 10)]
    y = [0.003 * round(i) for i in np.linspace(10, 60, 6)]
    return [(a, b) for b in (0.012, 0.198) for a in x] + [(a, b) for a in (0.012, 0.285) for b in y]


def pulse(t: Array) -> Array:
    """Ricker's pulse, its middle at 0.15 ms."""
    s = (np.pi * PULSE_HZ * (t - 1.5 / PULSE_HZ)) ** 2
    return np.asarray((1 - 2 * s) * np.exp(-s))


def modal(f_max_hz: float, rate_hz: float) -> Array:
    """(32, n): responses to the pulse, by modes and one fast convolution."""
    screen = Screen(PLATE, tuple(PointForce(*p) for p in places()), Attenuation(TAU_S))
    h = impulse_responses(screen, [FOCUS], rate_hz=rate_hz, duration_s=T_S, f_max_hz=f_max_hz)
    return convolved(h, rate_hz)


def convolved(h: Responses, rate_hz: float) -> Array:
    from scipy.fft import irfft, next_fast_len, rfft

    n = h.n_samples
    shape = pulse(np.arange(round(4 / PULSE_HZ * rate_hz)) / rate_hz)
    n_fft = next_fast_len(n + len(shape), real=True)
    return np.asarray(irfft(rfft(h.samples[0], n_fft) * rfft(shape, n_fft), n_fft)[:, :n])


def finite_differences(step_m: float) -> tuple[Array, float]:
    """(32, n) responses at the focus and their rate: explicit, second order, at 0.99 of the limit of stability.

    By reciprocity one run with the pulse at the focus gives all 32 responses: kind to this contender.
    """
    n_x, n_y = round(PLATE.length_m / step_m), round(PLATE.width_m / step_m)
    limit_s = step_m**2 / (4 * PLATE.wave_constant_m2_per_s)
    per_sample = math.ceil(1 / (0.99 * limit_s * RATE_HZ))
    dt = 1 / (RATE_HZ * per_sample)
    n = round(T_S * RATE_HZ)
    source = pulse(np.arange(n * per_sample) * dt) * dt**2 / (PLATE.area_density_kg_per_m2 * step_m**2)
    at = np.array([[round(x / step_m), round(y / step_m)] for x, y in places()])
    focus = (round(FOCUS[0] / step_m), round(FOCUS[1] / step_m))
    courant = (PLATE.wave_constant_m2_per_s * dt / step_m**2) ** 2
    return _march(n_x, n_y, courant, dt / TAU_S, source, focus, at, n, per_sample), RATE_HZ


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

    def judged(found: Array) -> tuple[float, float, float]:
        same = exact[:, :: exact.shape[1] // found.shape[1]]
        sparse = float(np.sum(same**2))
        focus = abs(float(np.sum(found**2)) * (exact.shape[1] // found.shape[1]) / energy - 1)
        waveform = float(np.sqrt(np.sum((found - same) ** 2) / sparse))
        played = float(np.sum(found * same) / np.sqrt(np.sum(found**2) * sparse))
        return focus, waveform, played

    settings = {f"modes to {f / 1e3:g} kHz": (f, r) for f, r in ((18e3, 50e3), (21e3, 50e3), (31e3, 100e3))}
    times = interleaved({name: (lambda f=f, r=r: modal(f, r)) for name, (f, r) in settings.items()}, 15)
    print(f"{'':<24}{'time (ms)':>10}{'focus error':>13}{'waveform':>10}{'cross-played':>14}")
    modal_at = {}
    for name, (f, r) in settings.items():
        focus, waveform, played = judged(modal(f, r))
        modal_at[name] = (times[name], focus)
        print(f"{name:<24}{times[name] * 1e3:>10.2f}{focus:>13.2e}{waveform:>10.2g}{played:>14.4f}")
    points = []
    for step in STEPS_M:
        finite_differences(6e-3 if step == STEPS_M[0] else step)
        start = time.process_time()
        found, _ = finite_differences(step)
        spent = time.process_time() - start
        focus, waveform, played = judged(found)
        points.append((spent, focus))
        print(
            f"{f'differences {step * 1e3:g} mm':<24}{spent * 1e3:>10.1f}{focus:>13.2e}{waveform:>10.2g}{played:>14.4f}"
        )
    for wanted, goal in ((1e-2, 200), (1e-3, 2000)):
        ours = min(t for t, e in modal_at.values() if e <= wanted)
        beyond = " EXTRAPOLATED beyond the finest grid" if wanted < points[-1][1] else ""
        detail = f"ours {ours * 1e3:.2f} ms; differences {time_at(points, wanted):.3g} s{beyond}"
        row(
            f"focus at {wanted:.1%} error, compiled differences over ours",
            time_at(points, wanted) / ours,
            detail,
            at_least=goal,
        )


def time_at(points: list[tuple[float, float]], wanted: float) -> float:
    """Time for an error: log-log between grids, beyond them error ~ time^(-1/2) (work h^-4, error h^2)."""
    spent, error = np.log([p[0] for p in points]), np.log([p[1] for p in points])
    if math.log(wanted) < error[-1]:
        return float(np.exp(spent[-1] + 2 * (error[-1] - math.log(wanted))))
    return float(np.exp(np.interp(-math.log(wanted), -error, spent)))


if __name__ == "__main__":
    print(machine())
    main()
