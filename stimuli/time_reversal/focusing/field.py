"""The plate at the focus instant and around it: modal amplitudes, then fields by matrix products."""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from tactometry.arguments.annotations import Vector
from tactometry.arguments.checked import checked
from tactometry.arguments.require import one_of, whole
from tactometry.errors import InvalidParameter
from tactometry.signal import Signal

from ...arrays import FloatArray
from ..plate.oscillators import QUANTITIES
from ..responses.responses import chunks
from ..screen.screen import Screen

MAX_GRID: Final = 100_000
Grid = tuple[Vector, Vector]


@checked
def modal_amplitudes(
    screen: Screen, signal: Signal, sample: int, f_max_hz: float, quantity: str = "displacement"
) -> FloatArray:
    """(n_modes,): every mode at one sample of a drive, by one matrix product over the past.

    Parameters
    ----------
    sample : int
        At least 0; ``n_samples - 1`` is the focus instant.
    """
    one_of("modal_amplitudes.quantity", quantity, QUANTITIES)
    forces = screen.modal_forces(f_max_hz)
    if signal.samples.shape[0] != forces.shape[1]:
        raise InvalidParameter(
            f"signal: found {signal.samples.shape[0]} channels, expected {forces.shape[1]} as the screen has"
        )
    whole("modal_amplitudes", lowest=0, sample=sample)
    # by age: what was played last comes first, and `first` samples ago if the drive is over
    first = max(sample + 1 - signal.samples.shape[1], 0)
    past = signal.samples[:, : sample + 1][:, ::-1]
    oscillators = screen.oscillators(f_max_hz)
    total = np.zeros(oscillators.n)
    for start, stop in chunks(past.shape[1]):
        basis = oscillators.impulse(signal.rate_hz, first + start, first + stop, quantity)
        total += np.einsum("nq,nq->n", basis @ past[:, start:stop].T, forces)
    return total / (screen.plate.mass_kg * signal.rate_hz)


@checked
def grid(screen: Screen, n_x: int, n_y: int) -> Grid:
    """Equally spaced coordinates from edge to edge."""
    whole("grid", lowest=1, highest=MAX_GRID, n_x=n_x, n_y=n_y)
    return np.linspace(0, screen.plate.length_m, n_x), np.linspace(0, screen.plate.width_m, n_y)


@checked
def field(screen: Screen, signal: Signal, sample: int, at_m: Grid, f_max_hz: float) -> FloatArray:
    """(n_x, n_y): displacement of the plate (m) at one sample of a drive, on the grid `at_m` = (x_m, y_m)."""
    return screen.modes(f_max_hz).field(modal_amplitudes(screen, signal, sample, f_max_hz), *at_m)


@checked
def movie(screen: Screen, signal: Signal, samples: Sequence[int], at_m: Grid, f_max_hz: float) -> Iterator[FloatArray]:
    """The fields at ascending samples, one at a time, from one exact run through the drive."""
    draw = screen.modes(f_max_hz).frame(*at_m)
    for amplitudes in modal_history(screen, signal, samples, f_max_hz).T:
        yield draw(np.ascontiguousarray(amplitudes))


@checked
def modal_history(screen: Screen, signal: Signal, samples: Sequence[int], f_max_hz: float) -> FloatArray:
    """(n_modes, n_kept): modal displacements at ascending samples, by the exact one-step recurrence."""
    from ..plate.modal_sum import run_impulses

    if len(samples) == 0 or min(samples) < 0 or any(np.diff(samples) <= 0):
        raise InvalidParameter(f"samples: found {list(samples)[:4]}.., expected ascending numbers, at least 0")
    forces = screen.modal_forces(f_max_hz) / (screen.plate.mass_kg * signal.rate_hz)
    padded = np.zeros((signal.samples.shape[0], samples[-1] + 1))
    n = min(signal.samples.shape[1], padded.shape[1])
    padded[:, :n] = signal.samples[:, :n]
    oscillators = screen.oscillators(f_max_hz)
    return run_impulses(oscillators, forces @ padded, signal.rate_hz, np.asarray(samples, np.int64))
