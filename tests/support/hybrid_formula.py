"""The level of foci and friction at once, by the formula of each."""

from functools import lru_cache

import electrovibration_formula
import numpy as np
import time_reversal_formula

from tactometry.signal import Signal
from tactometry.stimuli.time_reversal.stimulus.sensation import TimeReversalSensation


def level_db(model, signal, contact):
    """Sensation level (dB) by a `HybridSensation`."""
    foci, friction = _parts(signal)
    of_foci = time_reversal_formula.level_db(TimeReversalSensation(model.setup, model.reference_m), foci, contact)
    if not friction.peak:
        return of_foci
    return max(of_foci, electrovibration_formula.level_db(model.friction, friction, contact))


@lru_cache(maxsize=32)
def _parts(signal):
    """Split a signal into transducers, until silent, and electrode."""
    n_driven = int(np.flatnonzero(np.any(signal.samples[:-1], axis=0)).max(initial=0)) + 1
    foci, friction = signal.samples[:-1, :n_driven], signal.samples[-1:]
    return Signal(foci, signal.rate_hz, signal.unit), Signal(friction, signal.rate_hz, signal.unit)
