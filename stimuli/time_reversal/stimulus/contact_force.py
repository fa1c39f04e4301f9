"""Force of contacts on a driven plate, as long as they do not lift off."""

from collections.abc import Sequence
from functools import lru_cache
from typing import Final

import numpy as np

from tactometry.arguments.checked import checked
from tactometry.signal import Signal

from ...arrays import ComplexArray, FloatArray, fast_length
from ..focusing.focusing import emitted
from ..responses.load import Placed, Receptances, contact_transfer
from ..responses.responses import Point, values_at
from .setup import Setup

FINER: Final = 8
"""Samples of the force per sample of the drive; linear interpolation errs by 0.4 % of a 60 kHz peak at 250 kHz."""
RINGING_S: Final = 1e-3
"""Time for which a plate is computed after its drive."""
AT_ONCE: Final = 2048
"""Number of frequencies per chunk of receptances."""

Loads = tuple[Placed, ...]
Places = tuple[Point, ...]


@checked
def contact_force_n(setup: Setup, signal: Signal, loads: Sequence[Placed]) -> FloatArray:
    """Return the sum of the loads' forces, `FINER` values per sample.

    The result is exact for linear contacts, which pull as well as press. It is the sum of Z (1 + H Z)^-1 U until 1 ms
    after the drive, with the displacements U of the free plate under the contacts. U is computed until it has decayed
    by 60 dB, so that it fits into a period of the transform.
    """
    return np.asarray(_forces_n(setup, signal, tuple(loads), np.ones((1, len(loads))))[0])


@checked
def contact_forces_n(setup: Setup, signal: Signal, loads: Sequence[Placed]) -> FloatArray:
    """Return the force of each load, (n_loads, n_samples)."""
    return _forces_n(setup, signal, tuple(loads), np.eye(len(loads)))


def _forces_n(setup: Setup, signal: Signal, loads: Loads, of_loads: FloatArray) -> FloatArray:
    """Return sums of the loads' forces with weights (n, n_loads)."""
    played = np.flatnonzero(signal.samples.any(axis=0))
    if not played.size or not loads:
        return np.zeros((len(of_loads), 0))
    free, n_samples = _free(setup, signal, _places(loads))
    stiffness = _stiffness(setup, loads, n_samples, tuple(map(tuple, of_loads.tolist())))
    n_followed = int(played[-1]) + 1 + round(RINGING_S * setup.rate_hz)
    forces = np.fft.irfft(np.einsum("nkf,kf->nf", stiffness, free), n_samples * FINER)
    return np.asarray(FINER * forces[:, : n_followed * FINER])


def _places(loads: Sequence[Placed]) -> Places:
    return tuple((load.x_m, load.y_m) for load in loads)


@lru_cache(maxsize=4)
def _free(setup: Setup, signal: Signal, places: Places) -> tuple[ComplexArray, int]:
    """Return spectra of the free plate under the loads, and n_samples."""
    n_played = int(np.flatnonzero(signal.samples.any(axis=0))[-1]) + 1
    driven = Signal(signal.samples[:, :n_played], signal.rate_hz, signal.unit)
    free_m = emitted(driven, setup.responses_at_each(places))
    n_samples = fast_length(free_m.shape[1])
    return np.fft.rfft(free_m, n_samples), n_samples


@lru_cache(maxsize=64)
def _stiffness(setup: Setup, loads: Loads, n_samples: int, of_loads: tuple[tuple[float, ...], ...]) -> ComplexArray:
    """Return sums of load forces per free displacement under each load.

    It is W Z (1 + H Z)^-1 with the weights W of `of_loads`, in the shape (n, n_loads, n_frequencies).
    """
    s = _frequencies(setup, n_samples)
    stiffness = np.stack([load.dynamic_stiffness(s) for load in loads], axis=1)
    weights = np.repeat(np.array(of_loads, complex)[:, :, None], len(s), axis=2)
    spread = np.stack([load.spread(s, setup.plate) for load in loads])
    spots = tuple(load.points for load in loads)
    return contact_transfer(weights, _among(setup, spots, n_samples), stiffness) * spread


@lru_cache(maxsize=16)
def _among(setup: Setup, spots: tuple[Places, ...], n_samples: int) -> ComplexArray:
    """Return receptances (n_frequencies, k, k) among means over places."""
    shapes = [values_at(setup.screen, places, setup.modes_to_hz).mean(axis=1) for places in spots]
    at = np.stack(shapes, axis=1)
    starts = range(0, len(_frequencies(setup, n_samples)), AT_ONCE)
    return np.concatenate([_receptances(setup, n_samples, start).among(at) for start in starts])


@lru_cache(maxsize=2)
def _receptances(setup: Setup, n_samples: int, start: int) -> Receptances:
    s = _frequencies(setup, n_samples)[start : start + AT_ONCE]
    return Receptances.of(setup.screen.oscillators(setup.modes_to_hz), setup.screen.plate.mass_kg, s)


def _frequencies(setup: Setup, n_samples: int) -> ComplexArray:
    """Return the frequencies i w (rad/s) of a discrete transform."""
    return np.asarray(2j * np.pi * np.fft.rfftfreq(n_samples, 1 / setup.rate_hz), complex)
