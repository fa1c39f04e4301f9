"""Fingers and contactors on the screen: amplitude loss and lift-off."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from tactometry.arguments.checked import NotNegative, Positive, checked
from tactometry.arguments.require import one_of, some

from ..defaults import RESISTANCE_N_S_PER_M
from .fingertip import Fingertip
from .focusing.focusing import Emission, focus_amplitude
from .plate.plate import Plate
from .responses.load import Attached, PlateLoad, SprungMass
from .responses.responses import Point
from .screen.screen import Screen

PULP_MASS_KG: Final = 1e-4


@checked
def amplitude_loss(
    screen: Screen, focus: Point, loads: Sequence[Attached], emission: Emission, *, relearn: bool = False
) -> float:
    """Return the share of the focus amplitude that loads take.

    Parameters
    ----------
    relearn : bool
        Learn again with the loads present; by default the drive was learnt without.
    """
    free, loaded = (emission.responses(screen, [focus], present) for present in ((), loads))
    signal = emission.drive(loaded if relearn else free)
    return 1 - focus_amplitude(signal, loaded) / focus_amplitude(emission.drive(free), free)


@checked
def ejection_force_n(amplitude_m: float, frequency_hz: float, pulp_mass_kg: Positive = PULP_MASS_KG) -> float:
    """M w^2 A: the force that a focus of this amplitude can lift."""
    return float(pulp_mass_kg * np.abs(amplitude_m) * (2 * math.pi * frequency_hz) ** 2)


FINGER_DIAMETER_M: Final = 10e-3
"""Diameter of a fingertip's contact at 2 N."""

RIGID_MODULUS_PA: Final = 3e9
"""Modulus of a plastic tip."""

RIGID_MASS_KG: Final = 2e-3
N_POINTS: Final = 7
"""Of a disc: the centre and six on 2/3 of the radius share its resistance."""

KINDS: Final = ("finger", "soft", "rigid")


@checked
@dataclass(frozen=True)
class Contactor:
    """A contactor that presses on the plate instead of a finger.

    The thesis's contactors are not known: `contactor` in `stimuli/sources.toml` states the range of each constant.

    Parameters
    ----------
    kind : str
        ``finger``: the lumped default of `Fingertip`; ``soft``: a finger's resistance per area over its own
        area; ``rigid``: that, and at its centre the mass of a tip behind a Hertz contact, in series.
    diameter_m : float
        Above 0; not used for a finger.
    """

    kind: str
    diameter_m: Positive = FINGER_DIAMETER_M

    def __post_init__(self) -> None:
        one_of("Contactor.kind", self.kind, KINDS)

    @property
    def words(self) -> str:
        """Description for use in a sentence.

        >>> Contactor("finger").words, Contactor("soft", 5e-3).words
        ('finger', 'soft 5 mm tip')
        """
        return self.kind if self.kind == "finger" else f"{self.kind} {self.diameter_m * 1e3:g} mm tip"

    def loads(self, plate: Plate, at_m: Point, force_n: NotNegative) -> list[PlateLoad | SprungMass]:
        """Return the loads on the plate under a force (N); none at 0 N.

        They are centred at `at_m`, without the parts beyond an edge. The force stiffens a Hertz contact; the mass of a
        tip does not grow with it.
        """
        plate.check_holds("at_m", at_m)
        if force_n == 0:
            return []
        if self.kind == "finger":
            return [Fingertip().load(at_m, force_n)]
        area = (self.diameter_m / FINGER_DIAMETER_M) ** 2
        part = Fingertip(RESISTANCE_N_S_PER_M * area / N_POINTS)
        points = [point for point in _disc(at_m, self.diameter_m / 2) if plate.contains(*point)]
        skin = [part.load(point, force_n) for point in points]
        if self.kind != "rigid":
            return list(skin)
        # a Hertz contact of millimetres of radius under newtons is 0.1 mm wide: one point
        return [*skin, SprungMass(*at_m, RIGID_MASS_KG, hertz_stiffness_n_per_m(force_n, self.diameter_m / 2))]


@checked
def hertz_stiffness_n_per_m(force_n: NotNegative, radius_m: Positive, modulus_pa: Positive = RIGID_MODULUS_PA) -> float:
    """Slope of Hertz's law of a sphere, (6 E^2 R F)^(1/3).

    >>> round(hertz_stiffness_n_per_m(1.0, 1e-3, 1e9))
    181712
    """
    return float((6 * modulus_pa**2 * radius_m * force_n) ** (1 / 3))


def _disc(centre_m: Point, radius_m: float) -> list[Point]:
    x_m, y_m = centre_m
    ring = [(math.cos(i * math.pi / 3), math.sin(i * math.pi / 3)) for i in range(6)]
    return [centre_m, *((x_m + radius_m * 2 / 3 * c, y_m + radius_m * 2 / 3 * s) for c, s in ring)]


@checked
@dataclass(frozen=True)
class LossRow:
    """One condition: `loss` is 1 - A' / A of a drive that was learnt without the contact."""

    contactor: str
    diameter_m: float
    place: str
    force_n: float
    loss: float


@checked
def force_loss(
    screen: Screen,
    focus: Point,
    places: Mapping[str, Point],
    contactors: Sequence[Contactor],
    forces_n: Sequence[float],
    emission: Emission,
) -> list[LossRow]:
    """Every contactor at every place with every force.

    Parameters
    ----------
    places : mapping of name to (x_m, y_m)
        Such as F, the focus, and P1.
    """
    some("force_loss.forces_n", forces_n)
    some("force_loss.contactors", contactors)
    free = emission.responses(screen, [focus])
    signal = emission.drive(free)
    alone = focus_amplitude(signal, free)
    rows = []
    for contactor, (place, at_m), force_n in product(contactors, places.items(), forces_n):
        loaded = emission.responses(screen, [focus], contactor.loads(screen.plate, at_m, force_n))
        loss = 1 - focus_amplitude(signal, loaded) / alone
        rows.append(LossRow(contactor.kind, contactor.diameter_m, place, force_n, loss))
    return rows
