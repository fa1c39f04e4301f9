"""Contacts as a low-rank update against a dense re-solve, and loaded against unloaded.

    OMP_NUM_THREADS=1 python benchmarks/time_reversal_finger.py

32 sources, one receiver, 2000 frequencies. The dense solve is timed at 20 frequencies and scaled.
"""

import time

import numpy as np
from numpy.typing import NDArray
from time_reversal_rounds import interleaved, machine, row

from tactometry.stimuli.time_reversal import Plate
from tactometry.stimuli.time_reversal.plate.modes import modes_of, values
from tactometry.stimuli.time_reversal.plate.oscillators import Oscillators
from tactometry.stimuli.time_reversal.responses.load import Receptances, loaded_receptance

PLATE = Plate(0.297, 0.210, 1.1e-3, 70e9, 0.23, 2500.0, "SSSS")
MODES = modes_of(PLATE, 31.25e3)
OSCILLATORS = Oscillators(MODES.angular_frequency_rad_per_s, np.full(len(MODES.frequency_hz), 100.0))
S = 2j * np.pi * np.linspace(100.0, 25e3, 2000)
N_DENSE = 20


def weights(n: int, seed: int) -> NDArray[np.float64]:
    x, y = np.random.default_rng(seed).uniform((0.01, 0.01), (0.287, 0.2), (n, 2)).T
    return values(MODES, x, y)


def dense(
    at: NDArray[np.float64], stiffness: NDArray[np.complex128], s: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    out = []
    for value, z in zip(s, stiffness, strict=True):
        diagonal = PLATE.mass_kg * (value * (value + 2 * OSCILLATORS.decay_per_s) + OSCILLATORS.omega_rad_per_s**2)
        out.append(TO.T @ np.linalg.solve(np.diag(diagonal) + (at * z) @ at.T, OF))
    return np.moveaxis(np.array(out), 0, 2)


TO, OF = weights(1, 1), weights(32, 2)


def unloaded() -> object:
    return Receptances.of(OSCILLATORS, PLATE.mass_kg, S).between(TO, OF)


def main() -> None:
    for k in (1, 5, 20):
        at = weights(k, 3)
        stiffness = np.repeat((10.0 * S)[:, None], k, axis=1)

        def loaded(at: NDArray[np.float64] = at, z: NDArray[np.complex128] = stiffness) -> NDArray[np.complex128]:
            return loaded_receptance(Receptances.of(OSCILLATORS, PLATE.mass_kg, S), TO, OF, at, z)

        times = interleaved({"loaded": loaded, "unloaded": unloaded}, 7)
        some = slice(None, None, len(S) // N_DENSE)
        start = time.process_time()
        expected = dense(at, stiffness[some], S[some])
        dense_s = (time.process_time() - start) * len(S) / len(S[some])
        agreement = float(np.abs(loaded()[:, :, some] - expected).max() / np.abs(expected).max())
        row(
            f"{k} contacts against a dense re-solve",
            dense_s / times["loaded"],
            f"{times['loaded'] * 1e3:.3g} ms",
            at_least=100,
        )
        row(f"{k} contacts: agreement", agreement, unit="of the largest", at_most=1e-12)
        row(f"{k} contacts: loaded over unloaded", times["loaded"] / times["unloaded"], at_most=2 if k <= 5 else None)


if __name__ == "__main__":
    print(machine())
    main()
