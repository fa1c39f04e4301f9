"""Attenuation of free vibration: every mode decays as exp(-t / tau)."""

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from tactometry.arguments.checked import NotNegative, NotNegativeArray, Positive, Unbounded, checked
from tactometry.arguments.require import expect

from ...arrays import FloatArray
from ...composition.content import PlateContent
from ...composition.effect import Effect

if TYPE_CHECKING:
    from ...composition.effect import Surroundings

TAU_S: Final = 3.5e-3
"""Attenuation constant that matches the finger of `tactometry.stimuli.defaults`; range: `setup` in
`stimuli/sources.toml`."""

MOST_DECADES: Final = 12.0
"""Largest change of the time constant up to the end of the band, far above that of any glass."""


@checked
@dataclass(frozen=True)
class Attenuation(Effect):
    """Losses of a plate, tau(f) = tau (f / f_ref)^-exponent; without this effect a plate has none.

    Parameters
    ----------
    tau_s : float
        Time constant of the amplitude at `reference_hz`, above 0; ``math.inf`` for no loss.
    exponent : float
        Exponent of the power law (an unverified option), at least 0; 0 for a constant tau.
    reference_hz : float
        Frequency at which the attenuation is stated, above 0.

    >>> round(Attenuation().t60_s, 4)
    0.0242
    >>> float(1 / Attenuation(exponent=0.5).rate_per_s(40e3))
    0.00175
    """

    kind = "attenuation"
    in_signal = True
    reads, gives = ("screen",), "screen"

    tau_s: Unbounded = TAU_S
    exponent: NotNegative = 0.0
    reference_hz: Positive = 10e3

    def __post_init__(self) -> None:
        expect(self.tau_s > 0, "Attenuation.tau_s", self.tau_s, "a time above 0, or inf")

    @property
    def t60_s(self) -> float:
        """Time to fall by 60 dB, ln(1000) tau."""
        return math.log(1000) * self.tau_s

    def rate_per_s(self, frequency_hz: NotNegativeArray) -> FloatArray:
        """Return 1 / tau, the decay rate of the amplitude, at frequencies."""
        relative = np.asarray(frequency_hz, float) / self.reference_hz
        return np.asarray(relative**self.exponent / self.tau_s)

    def __call__(self, screen: Any) -> Any:
        return replace(screen, attenuation=self)

    def in_plate(self, scene: "Surroundings") -> PlateContent:
        """Return tau at the end of the band and the ringing time of three tau."""
        f_max_hz: float = scene.surface.f_max_hz
        decades = abs(self.exponent * math.log10(f_max_hz / self.reference_hz))
        found = f"{self.exponent:g}, by which tau changes {decades:.3g} decades up to f_max_hz"
        expect(decades <= MOST_DECADES, "attenuation.exponent", found, f"at most {MOST_DECADES:g}; lower it")
        lossless = "a finite time; omit the effect if there are no losses"
        expect(math.isfinite(self.tau_s), "attenuation.tau_s", self.tau_s, lossless)
        return PlateContent(tau_s=float(1 / self.rate_per_s(f_max_hz)), ringing_s=3 * self.tau_s)

    def in_setup(self) -> dict[str, float]:
        """Return the one time constant of a stimulus's plate."""
        found = f"{self.exponent:g} for a played signal"
        expect(self.exponent == 0, "attenuation.exponent", found, "0: the plate of a stimulus has one tau_s")
        return {"tau_s": self.tau_s}
