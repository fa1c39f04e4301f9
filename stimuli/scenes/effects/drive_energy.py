"""Energy: what the plate holds at the focus instant, and what the transducers draw."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from tactometry.errors import InvalidParameter

from ...composition.effect import Demand, Effect, Size, Stage, Surroundings
from ..stages.truncation import MOST_MODES, n_modes, remainder

if TYPE_CHECKING:
    from ..stages.emission import EmittedSignal
    from ..stages.motion import PlateMotion


@dataclass(frozen=True)
class DriveEnergy(Effect):
    """Strain energy in the band, and the power that switching `capacitance_f` per channel takes.

    5.31 nF, a plate of PZ27 of 1 cm^2 and 0.3 mm, is an unverified default.

    >>> DriveEnergy().slot
    'energy'
    """

    kind = "drive_energy"
    slot = "energy"
    positive = ("capacitance_f",)
    cures: ClassVar[Mapping[str, str]] = dict.fromkeys(("energy_j", "power_w"), "add the effect drive_energy")

    capacitance_f: float = 5.31e-9

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        del scene
        return (
            Stage("strain_energy", ("motion",), "energy_at_1v_j", f"{__name__}:strained", size=_strain_size),
            _squared("energy", "energy_at_1v_j", "energy_j"),
            Stage("switching", ("emission",), "power_at_1v_w", f"{__name__}:drawn", dict(vars(self))),
            _squared("power", "power_at_1v_w", "power_w"),
        )


def _strain_size(demand: Demand) -> Size:
    surface = demand.surface
    lost = 4 * remainder(demand) ** 2
    ratio = max(4.0, 1.01 * lost / demand.error)
    static_to_hz = ratio * surface.band_max_hz
    n = n_modes(demand, static_to_hz)
    if n > MOST_MODES:
        raise InvalidParameter(
            f"energy_j: found an error of {demand.error:.2g} left, which takes {n:.2g} modes, expected at most "
            f"{MOST_MODES:.2g}; loosen the accuracy"
        )
    return Size({"static_to_hz": static_to_hz}, lost / ratio, 4.0 * n * surface.n_transducers)


def _squared(name: str, at_1v: str, gives: str) -> Stage:
    return Stage(name, (at_1v, "voltage_v"), gives, f"{__name__}:grown")


def strained(static_to_hz: float) -> "Callable[[PlateMotion], float]":
    """Half the sum of M w^2 q^2 over all modes at the focus instant (J at 1 V)."""
    return lambda motion: motion.strain_energy_j(static_to_hz)


def drawn(capacitance_f: float) -> "Callable[[EmittedSignal], float]":
    """The mean power during an emission of 1 V."""
    from ...time_reversal.field.merit import switched_power_w

    return lambda emission: switched_power_w(emission.at_1_v, capacitance_f)


def grown() -> Callable[[float, float], float]:
    """Energy and power grow with the square."""
    return lambda at_1v, voltage_v: at_1v * voltage_v**2
