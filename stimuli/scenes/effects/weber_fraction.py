"""Detection of a fixed fraction of the load (Weber's law)."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...composition.effect import Effect

if TYPE_CHECKING:
    from tactometry.contact import Contact

    from ...perception.detection import Components


@dataclass(frozen=True)
class WeberFraction(Effect):
    """A threshold proportional to the normal force (Weber's law).

    Without this effect the threshold is the same at any force. 1 N is an unverified default.

    Parameters
    ----------
    reference_n : float
        Normal force at which the threshold was measured.
    """

    kind = "weber_fraction"
    slot = "criterion"
    positive = ("reference_n",)
    requires = ("friction", "sliding contact")
    reads, gives = ("skin_components", "contact"), "skin_components"
    assumes = ("the threshold is a fixed fraction of the friction at any force",)

    reference_n: float = 1.0

    def __call__(self, skin_components: "Components", contact: "Contact") -> "Components":
        return skin_components.times(self.reference_n / contact.force_n)
