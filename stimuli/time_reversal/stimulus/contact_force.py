"""The force between a plate that a drive moves and what presses on it, as long as the contact holds."""

from functools import lru_cache
from typing import Final

import numpy as np

from tactometry.arguments.checked import checked
from tactometry.signal import Signal

from ...arrays import ComplexArray, FloatArray
from ..focusing.focusing import emitted
from ..responses.load import PlateLoad, Receptances
from ..responses.responses import values_at
from .setup import Setup

FINER: Final = 8
"""Samples of the force for one of the drive: straight lines between them miss 0.4 % of a peak at 60 kHz and 250 kHz."""
RINGING_S: Final = 1e-3
"""For how long a plate is followed behind its drive."""
AT_ONCE: Final = 2048
"""Frequencies for which receptances are held at a time."""


@checked
def contact_force_n(setup: Setup, signal: Signal, load: PlateLoad) -> FloatArray:
    """(n_samples,): what a load answers a drive with, on top of what presses it, `FINER` to a sample.

    Exact for a linear contact, which pulls as well as it presses: U Z / (1 + H Z) with the displacement U of the free
    plate under it, until 1 ms behind the drive. U is known until it has fallen by 60 dB, so that a period of the
    transform holds it.
    """
    played = np.flatnonzero(signal.samples.any(axis=0))
    if not played.size:
        return np.zeros(0)
    n_played = int(played[-1]) + 1
    driven = Signal(signal.samples[:, :n_played], signal.rate_hz, signal.unit)
    free_m = emitted(driven, setup.responses_at(load.x_m, load.y_m))[0]
    force = np.fft.rfft(free_m) * _stiffness_under_load(setup, load, len(free_m))
    n_followed = n_played + round(RINGING_S * setup.rate_hz)
    return np.asarray(FINER * np.fft.irfft(force, len(free_m) * FINER)[: n_followed * FINER])


@lru_cache(maxsize=8)
def _stiffness_under_load(setup: Setup, load: PlateLoad, n_samples: int) -> ComplexArray:
    """(n_frequencies,): Z / (1 + H Z), force per displacement of the free plate."""
    s = np.asarray(2j * np.pi * np.fft.rfftfreq(n_samples, 1 / setup.rate_hz), complex)
    at = values_at(setup.screen, [(load.x_m, load.y_m)], setup.modes_to_hz)
    oscillators, receptance = setup.screen.oscillators(setup.modes_to_hz), np.empty(len(s), complex)
    for start in range(0, len(s), AT_ONCE):
        part = slice(start, start + AT_ONCE)
        receptance[part] = Receptances.of(oscillators, setup.screen.plate.mass_kg, s[part]).between(at, at)[0, 0]
    stiffness = load.dynamic_stiffness(s)
    return np.asarray(stiffness / (1 + receptance * stiffness))
