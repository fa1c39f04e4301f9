"""Time fields and responses computed as matrix products.

They are compared with a loop over modes and with the peak rate of BLAS.

OMP_NUM_THREADS=1 python benchmarks/time_reversal_products.py
"""

from statistics import median

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from tactometry.experiments.harness import interleaved, tell
from tactometry.stimuli.time_reversal import Plate
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.plate.modes import modes_of, values
from tactometry.stimuli.time_reversal.responses.responses import band_limited, impulse_responses
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.screen import Screen
from tactometry.stimuli.time_reversal.screen.transducer import PointForce, border

Array = NDArray[np.float64]
PLATE = Plate(0.297, 0.210, 1.1e-3, 70e9, 0.23, 2500.0, "SSSS")
F_MAX_HZ, RATE_HZ, T_S = 31.25e3, 200e3, 15e-3
N_X, N_Y = 300, 210
TURN_S = 5e-3


def peak_flops() -> float:
    """Return the rate (flop/s) of a dense 1500 x 1500 matrix product."""
    a = np.random.default_rng(0).normal(size=(1500, 1500))
    return 2 * 1500**3 / median(interleaved({"product": lambda: a @ a}, 5)["product"])


def field_frame(peak: float) -> None:
    modes = modes_of(PLATE, F_MAX_HZ)
    x, y = np.linspace(0, 0.297, N_X), np.linspace(0, 0.210, N_Y)
    draw = modes.frame(x, y)
    amplitude = np.random.default_rng(0).normal(size=len(modes.frequency_hz))
    along, across = modes.on_x.value(x)[modes.m - 1], modes.on_y.value(y)[modes.n - 1]

    def loop() -> Array:
        total = np.zeros((N_X, N_Y))
        for a, u, v in zip(amplitude, along, across, strict=True):
            total += a * np.outer(u, v)
        return total

    assert np.allclose(draw(amplitude), loop(), atol=1e-9)
    times = interleaved({"ours": lambda: draw(amplitude), "loop": loop}, 15, turn_s=TURN_S)
    ours_s, n_m, n_n = median(times["ours"]), int(modes.m.max()), int(modes.n.max())
    flops = 2 * min(n_m * n_n * N_Y + N_X * n_m * N_Y, N_X * n_m * n_n + N_X * n_n * N_Y)
    tell("field frame 300 x 210 against a loop over modes", median(times["loop"]) / ours_s, at_least=300)
    tell("field frame: share of the peak of BLAS", flops / ours_s / peak, "", at_least=0.5)


def responses(peak: float) -> None:
    rng, n = np.random.default_rng(0), round(T_S * RATE_HZ)
    places = [(float(a), float(b)) for a, b in rng.uniform((0.01, 0.01), (0.287, 0.2), (64, 2))]
    screen = Screen(PLATE, tuple(PointForce(*p) for p in places[:32]), Attenuation(10e-3))
    basis = screen.oscillators(F_MAX_HZ).impulse(RATE_HZ, 0, n)
    push, at = screen.modal_forces(F_MAX_HZ), values(screen.modes(F_MAX_HZ), *np.array(places[32:]).T)

    def ours() -> Array:
        return impulse_responses(screen, places[32:], rate_hz=RATE_HZ, duration_s=T_S, f_max_hz=F_MAX_HZ).samples

    def loop() -> Array:
        out = np.empty((32, 32, n))
        for p in range(32):
            for q in range(32):
                out[p, q] = ((at[:, p] * push[:, q])[:, None] * basis).sum(axis=0)
        return out / (PLATE.mass_kg * RATE_HZ)

    assert np.allclose(ours(), loop(), atol=1e-9 * np.abs(ours()).max())
    times = interleaved({"ours": ours, "loop": loop}, 5, turn_s=TURN_S)
    share = 2 * 32 * 32 * len(basis) * n / median(times["ours"]) / peak
    tell("32 x 32 impulse responses: the plain product at the peak of BLAS, over ours", share, "", at_least=0.7)
    ratio = median(times["loop"]) / median(times["ours"])
    tell("32 x 32 impulse responses against a loop over pairs", ratio, at_least=30)


def static_residual() -> None:
    """Compare the numbers of modes, with and without the residual, for the same error below 10 kHz."""
    patches = Screen(PLATE, tuple(border(PLATE, 4)), Attenuation(3.5e-3))
    points, timing = [(0.1, 0.08), (0.2, 0.15)], {"rate_hz": 400e3, "duration_s": 25e-3}

    def found(f_max_hz: float, static_to_hz: float | None = None) -> Array:
        h = impulse_responses(patches, points, f_max_hz=f_max_hz, static_to_hz=static_to_hz, **timing)
        return band_limited(h, Band(0.0, 10e3)).samples

    whole = found(190e3)

    def error(responses: Array) -> float:
        return float(np.linalg.norm(responses - whole) / np.linalg.norm(whole))

    with_it = error(found(20e3, 190e3))
    enough = next(f for f in np.arange(20e3, 190e3, 10e3) if error(found(float(f))) <= with_it)
    n_few, n_many = (len(PLATE.frequencies_hz(float(f))) for f in (20e3, enough))
    tell("static residual: modes saved at the same error", n_many / n_few, at_least=1)


if __name__ == "__main__":
    with threadpool_limits(1):
        rate = peak_flops()
        field_frame(rate)
        responses(rate)
        static_residual()
