"""What transducers and electrode play at once, each by itself."""

import numpy as np

from tactometry.signal import Signal

from ...arrays import FloatArray


def resting(signal: Signal) -> Signal:
    """What the transducers play, until they are silent."""
    foci = signal.samples[:-1]
    n_driven = int(np.flatnonzero(np.any(foci, axis=0)).max(initial=0)) + 1
    return Signal(foci[:, :n_driven], signal.rate_hz, signal.unit)


def sliding(signal: Signal) -> Signal:
    """What the electrode plays."""
    return Signal(signal.samples[-1:], signal.rate_hz, signal.unit)


def stronger(foci_db: FloatArray, friction_db: float) -> float:
    """The level of what is felt most, of the foci or of the friction."""
    return max(float(np.max(foci_db)), friction_db)
