"""Bonded patches instead of point forces."""

from dataclasses import dataclass

from tactometry.arguments.require import expect

from ...composition.content import PlateContent
from ...composition.effect import Demand, Effect, Size, Stage, Surroundings
from ...time_reversal.screen.transducer import MOMENT_N_PER_V, SIDE_M

PATCHES = "tactometry.stimuli.scenes.stages.emission:patches"


@dataclass(frozen=True)
class Patches(Effect):
    """Square patches that bend the plate along their outline; both defaults are unverified.

    Parameters
    ----------
    side_m : float
        Side of a square patch.
    moment_n_per_v : float
        Bending moment per length of the outline and volt.
    """

    kind = "patches"
    in_signal = True
    positive = ("side_m", "moment_n_per_v")
    assumes = ("patches have neither mass nor stiffness",)
    rests_on = "the moment per volt of a patch (calibrated: the default gives 10 um on A4 of 1.1 mm by one bit of 30 V)"

    side_m: float = SIDE_M
    moment_n_per_v: float = MOMENT_N_PER_V

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        return (Stage("patches", ("plate",), "sources", PATCHES, size=self._size),)

    def _size(self, demand: Demand) -> Size:
        surface = demand.surface
        found = f"a side of {self.side_m} m with TimeReversal.inset_m = {surface.inset_m}"
        expected = f"patches within the plate; raise inset_m to {self.side_m / 2} or lower side_m"
        expect(self.side_m <= 2 * surface.inset_m, "patches", found, expected)
        return Size({"n_transducers": surface.n_transducers, "inset_m": surface.inset_m, **vars(self)})

    def in_setup(self) -> dict[str, float]:
        return vars(self)

    def in_plate(self, scene: Surroundings) -> PlateContent:
        return PlateContent(reach_m=self.side_m / 2)
