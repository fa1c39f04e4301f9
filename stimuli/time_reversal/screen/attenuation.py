"""How fast free vibration decays: every mode as exp(-t / tau)."""

import math
from dataclasses import dataclass

import numpy as np

from tactometry.arguments.annotations import NotNegative, NotNegativeArray, Positive, Unbounded
from tactometry.arguments.checked import checked
from tactometry.arguments.require import expect

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
    exponent: NotNegative = 0.0
    reference_hz: Positive = 10e3

    def __post_init__(self) -> None:
        expect(self.tau_s > 0, "Attenuation.tau_s", self.tau_s, "a time above 0, or inf")

    @property
    def t60_s(self) -> float:
        """Time to fall by 60 dB, ln(1000) tau."""
        return math.log(1000) * self.tau_s

    def rate_per_s(self, frequency_hz: NotNegativeArray) -> FloatArray:
        """1 / tau at frequencies (the decay rate of the amplitude)."""
        relative = np.asarray(frequency_hz, float) / self.reference_hz
        return np.asarray(relative**self.exponent / self.tau_s)
