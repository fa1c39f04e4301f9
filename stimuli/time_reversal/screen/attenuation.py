"""How fast free vibration decays: every mode as exp(-t / tau)."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.annotations import Unbounded
from tactometry.arguments.checked import checked
from tactometry.arguments.require import not_negative, not_negative_array, positive
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray


@checked
@dataclass(frozen=True)
class Attenuation:
    """tau(f) = tau (f / f_ref)^-exponent.

    Parameters
    ----------
    tau_s : float
        Time constant of the amplitude (s) at `reference_hz`, above 0; ``math.inf`` for no loss.
    exponent : float
        At least 0; 0 is a constant tau. The power law is an unverified option.
    reference_hz : float
        Above 0.

    Examples
    --------
    >>> round(Attenuation(3.5e-3).t60_s, 4)
    0.0242
    """

    tau_s: Unbounded
    exponent: float = 0.0
    reference_hz: float = 10e3

    def __post_init__(self) -> None:
        if not self.tau_s > 0:
            raise InvalidParameter(f"Attenuation.tau_s: found {self.tau_s}, expected a time above 0, or inf")
        not_negative("Attenuation", exponent=self.exponent)
        positive("Attenuation", reference_hz=self.reference_hz)

    @property
    def t60_s(self) -> float:
        """Time to fall by 60 dB, ln(1000) tau."""
        return math.log(1000) * self.tau_s

    def rate_per_s(self, frequency_hz: ArrayLike) -> FloatArray:
        """1 / tau at frequencies (the decay rate of the amplitude)."""
        not_negative_array("Attenuation.rate_per_s.frequency_hz", frequency_hz)
        relative = np.asarray(frequency_hz, float) / self.reference_hz
        return np.asarray(relative**self.exponent / self.tau_s)
