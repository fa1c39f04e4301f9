"""Temperature drift of a plate since its responses were learnt."""

from dataclasses import dataclass
from math import isfinite, pi

from tactometry.arguments.require import expect, within

from ...composition.content import PlateContent
from ...composition.effect import Effect, Stage, Surroundings
from ...time_reversal.plate.glass import FREQUENCY_SHIFT_PER_K, MOST_SHIFT

LEARNING = "tactometry.stimuli.scenes.stages.emission:learning_colder"


@dataclass(frozen=True)
class TemperatureDrift(Effect):
    """Temperature drift of a plate since its responses were learnt.

    `kelvin` is not 0. The shift of -5e-5/K is unverified.

    Parameters
    ----------
    kelvin : float
        Temperature of the plate minus that at learning.
    shift_per_k : float
        Relative shift of the modal frequencies.
    """

    kind = "temperature_drift"
    slot = "drift"
    in_signal = True
    assumes = ("a warmer plate only becomes softer",)

    kelvin: float
    shift_per_k: float = FREQUENCY_SHIFT_PER_K

    def __post_init__(self) -> None:
        for name in ("kelvin", "shift_per_k"):
            value = getattr(self, name)
            expected = "a finite number other than 0; omit the effect if there is no drift"
            expect(isfinite(value) and value != 0, f"TemperatureDrift.{name}", value, expected)

        within("TemperatureDrift", -MOST_SHIFT, MOST_SHIFT, shift_of_frequencies=self.kelvin * self.shift_per_k)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        learning = {name: getattr(scene.surface, name) for name in ("rate_hz", "reversal_s", "f_max_hz", "flank_hz")}
        settings = {**vars(self), **learning}
        return (Stage("drift", ("screen", "foci_m"), "learnt", LEARNING, settings),)

    def in_plate(self, scene: Surroundings) -> PlateContent:
        """Return the weakening by the detuned modes."""
        surface = scene.surface
        turned = 2 * pi * surface.f_max_hz * self.kelvin * self.shift_per_k * surface.reversal_s / 2
        return PlateContent(weakening=float(1 + turned**2))
