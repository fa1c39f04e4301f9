"""The `force-loss` study in simulation: loss of focus amplitude over contact force, place and contactor."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from tactometry.arguments.checked import checked
from tactometry.arguments.require import some

from ..focusing.emission import Emission
from ..focusing.focusing import drive, focus_amplitude
from ..responses.responses import Point
from ..screen.screen import Screen
from .contactor import Contactor


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
    signal = drive(free, emission.voltage_v, emission.quantiser)
    alone = focus_amplitude(signal, free)
    rows = []
    for contactor, place, at, force in _conditions(places, contactors, forces_n):
        loaded = emission.responses(screen, [focus], contactor.loads(screen.plate, at, force))
        loss = 1 - focus_amplitude(signal, loaded) / alone
        rows.append(LossRow(contactor.kind, contactor.diameter_m, place, force, loss))
    return rows


def _conditions(
    places: Mapping[str, Point], contactors: Sequence[Contactor], forces_n: Sequence[float]
) -> Iterator[tuple[Contactor, str, Point, float]]:
    for contactor in contactors:
        for place, at in places.items():
            for force in forces_n:
                yield contactor, place, at, force
