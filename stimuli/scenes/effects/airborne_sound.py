"""Airborne sound of an emission."""

from dataclasses import dataclass
from math import inf, log10
from typing import TYPE_CHECKING

from ...composition.effect import Demand, Effect, Size, Stage, Surroundings, note
from ...defaults import AUDIBLE_MAX_HZ, DISTANCE_M
from ..stages.truncation import n_frequencies_of_sound, n_modes, remainder

if TYPE_CHECKING:
    from ...time_reversal.screen.screen import Screen
    from ..stages.emission import EmittedSignal

FEWEST_MORE = 1.1


@dataclass(frozen=True)
class AirborneSound(Effect):
    """A-weighted sound level at `distance_m` (unverified default), for ranking drives, not for absolute levels.

    Parameters
    ----------
    distance_m : float
        Distance of the ear from the plate, at which the level is computed.
    """

    kind = "airborne_sound"
    slot = "sound"
    positive = ("distance_m",)
    cures = note("add the effect airborne_sound", "sound_level_dba")
    requires = ("attenuation",)
    assumes = ("sound is radiated by a baffled plate with simply supported edges, averaged over many modes",)

    distance_m: float = DISTANCE_M

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        made, at_voltage = ("screen", "emission"), ("level_at_1v_dba", "voltage_v")
        return (
            Stage("airborne_sound", made, "level_at_1v_dba", f"{__name__}:sound_level_dba", size=self._size),
            Stage("sound_level", at_voltage, "sound_level_dba", f"{__name__}:level_at_voltage_dba"),
        )

    def _size(self, demand: Demand) -> Size:
        surface = demand.surface
        lost = remainder(demand) ** 2 * surface.f_max_hz / AUDIBLE_MAX_HZ
        ratio = max(FEWEST_MORE, (1.01 * lost / demand.error) ** (1 / 3))
        modes_to_hz = ratio * AUDIBLE_MAX_HZ
        n = n_modes(demand, modes_to_hz) * n_frequencies_of_sound(demand)
        settings = {"modes_to_hz": modes_to_hz, "distance_m": self.distance_m}
        return Size(settings, lost / ratio**3, n * (0.2 * surface.n_transducers + 30))


def sound_level_dba(screen: "Screen", emission: "EmittedSignal", modes_to_hz: float, distance_m: float) -> float:
    """Return the A-weighted level of an emission of 1 V."""
    from ...time_reversal.focusing.sound import noise

    return noise(screen, emission.at_1_v, modes_to_hz, distance_m=distance_m).a_weighted_db


def level_at_voltage_dba(level_at_1v_dba: float, voltage_v: float) -> float:
    """Return the level at a voltage; ``-inf`` for silence."""
    return level_at_1v_dba + (20 * log10(abs(voltage_v)) if voltage_v else -inf)
