"""An asymmetry of the skin between positive and negative voltages."""

from dataclasses import dataclass

import numpy as np

from tactometry.arguments.checked import checked

from ...arrays import FloatArray
from ...composition.effect import Effect, note

NO_FLOW = "the exact motion has no term for polarity; remove one of the two"


@dataclass(frozen=True)
class Polarity(Effect):
    """Scale the force by `positive_share` while the voltage across the layer is positive.

    The force of all laws is even in the voltage. Yet positive pulses are reported to be felt less than negative or
    biphasic ones (Kaczmarek 2006), which is ascribed to an asymmetric skin. We found no published strength of the
    asymmetry, and scaling the force is an unverified choice. The effect is off by default, and its strength has no
    default.

    Raises `InvalidParameter` if the share is negative or not finite.

    Parameters
    ----------
    positive_share : float
        Factor of the force, at least 0; below 1 positive voltages are less effective.

    >>> Polarity(0.5).weighted(np.array([4.0, 4.0]), layer_v=np.array([2.0, -2.0])).tolist()
    [2.0, 4.0]
    """

    kind = "polarity"
    not_negative = ("positive_share",)
    excludes = note(NO_FLOW, "friction_lag", "finger_dynamics")
    felt_excludes = note(NO_FLOW, "finger_dynamics")
    reads, gives = ("electrostatic_force_n", "layer_voltage_v"), "electrostatic_force_n"

    positive_share: float

    @checked
    def weighted(self, force_n: FloatArray, layer_v: FloatArray) -> FloatArray:
        """Scale the forces (N) under negative layer voltages of the same shape."""
        return np.where(layer_v > 0, self.positive_share * force_n, force_n)

    __call__ = weighted
