"""Spatial summation of the Pacinian channel."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...composition.effect import Effect

if TYPE_CHECKING:
    from ...arrays import FloatArray


@dataclass(frozen=True)
class Summation(Effect):
    """Spatial summation: 3 dB per doubling of the contact area relative to `reference_m2`.

    Parameters
    ----------
    reference_m2 : float
        Reference area: that of the contactor of the published thresholds.
    """

    kind = "summation"
    positive = ("reference_m2",)
    requires = ("receptors",)
    reads, gives = ("channels_db", "area_m2"), "channels_db"

    reference_m2: float = 2.9e-4

    def __call__(self, channels_db: "FloatArray", area_m2: float) -> "FloatArray":
        import numpy as np

        from ...perception.channels import P, summation_db

        return np.asarray(channels_db + np.eye(3)[P] * summation_db(area_m2, self.reference_m2))
