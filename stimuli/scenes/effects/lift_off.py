"""Resting fingers that the plate can throw off: they press, never pull."""

from dataclasses import dataclass
from itertools import count
from math import pi
from typing import Any

from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter

from ...composition.effect import Demand, Effect, Size, Stage, Surroundings, note
from ...defaults import LUMPED
from ..stages.truncation import at_rest, cut_of, n_frequencies, n_modes, places_m

OPEN_CONTACT = "tactometry.stimuli.scenes.stages.contact"
OF_MOTION, OF_FORCE = 0.013, 0.1
"""Errors of motion and force for a step of one radian at the top of the band. They fall with the power 4/3 and 2 of the
step, and are at least 1.7 times those measured on a small screen under a finger of 2 N."""
FEWEST = 2


@dataclass(frozen=True)
class LiftOff(Effect):
    """Lift-off of the fingers of `finger_load`: contacts open where they would pull and close where skin meets plate.

    The finger has no mass. Each run is solved in time at its voltage, as in `one_sided_contact`. All outputs of the
    plate include these fingers and are no longer proportional to the voltage.
    """

    kind = "lift_off"
    requires = ("load",)
    cures = note("add the effects finger_load and lift_off", "contact_lost_s")
    assumes = ("a finger that is thrown off has no mass, relaxes back by itself and meets the plate without a rebound",)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        n = len(at_rest(scene))
        opened = Stage("lift_off", ("motion", "voltage_v"), "motion", f"{OPEN_CONTACT}:opened_motion", size=self._size)
        answers = f"{OPEN_CONTACT}:contact_answers"
        return (
            opened,
            Stage("contact_forces", ("motion", "oversampling"), "per_volt_forces", answers, {"n": n}),
            Stage("lost_contact", ("motion",), "contact_lost_s", f"{OPEN_CONTACT}:lost_s"),
        )

    def felt_stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        """Raise an error, as lift-off would take minutes for one level."""
        raise InvalidParameter(
            "effects: found 'lift_off' where signals are felt, expected the linear contact of 'finger_load'; remove "
            "'lift_off': a dry run reports the level from which contact is lost, `tactometry scene` the effect of that"
        )

    def _size(self, demand: Demand) -> Size:
        load: Any = demand.find("load")
        mass_kg = load.mass_kg
        expected = "'lumped' with lift_off: the impedance of tissue depends on frequency"
        expect(load.impedance == LUMPED, "FingerLoad.impedance", repr(load.impedance), expected)
        expect(mass_kg == 0, "FingerLoad.mass_kg", mass_kg, "0 with lift_off, as no law of impact is available")
        x_m, y_m = zip(*places_m(demand), strict=True)
        forces_n = tuple(touch.force_n for touch in at_rest(demand))
        finer = next(n for n in count(FEWEST) if self._error(demand, n) <= demand.error)
        settings = {"x_m": x_m, "y_m": y_m, "force_n": forces_n, **vars(load), "finer": finer}
        return Size(settings, self._error(demand, finer), self._n_operations(demand, len(x_m), finer))

    def _error(self, demand: Demand, finer: int) -> float:
        turned_rad = 2 * pi * demand.surface.f_max_hz / demand.surface.rate_hz / finer
        of_force = OF_FORCE * turned_rad**2 if "contact_force_n" in demand.outputs else 0.0
        return float(OF_MOTION * turned_rad ** (4 / 3) + of_force)

    def _n_operations(self, demand: Demand, n_contacts: int, finer: int) -> float:
        ends = demand.once(cut_of)
        n_times = n_frequencies(demand, ends)
        n_steps = n_contacts * n_times * demand.surface.rate_hz / (2 * ends.heard_to_hz) * finer
        return float(
            0.5 * n_steps**2 + 2e4 * n_steps + 120.0 * n_contacts * n_modes(demand, ends.modes_to_hz) * n_times
        )
