"""A voltage as it is played, sample by sample."""

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray


@dataclass(frozen=True, eq=False)
class VoltageRecord:
    """Samples (n_samples,) of a voltage, and their rate."""

    voltage_v: FloatArray
    rate_hz: float

    @property
    def t_s(self) -> FloatArray:
        return np.arange(self.voltage_v.size) / self.rate_hz
