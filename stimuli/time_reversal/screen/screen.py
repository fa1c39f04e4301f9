"""A haptic screen: a plate, its transducers and its losses."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Final

from tactometry.arguments.checked import checked
from tactometry.arguments.require import some, within

from ...arrays import FloatArray
from ..plate.glass import A4_SCREEN, FREQUENCY_SHIFT_PER_K, MOST_SHIFT
from ..plate.modes import Modes, modes_of
from ..plate.oscillators import Oscillators
from ..plate.plate import Plate
from .attenuation import Attenuation
from .transducer import ForceSource, border, modal_forces


@checked
@dataclass(frozen=True)
class Screen:
    """Plate, sources and attenuation.

    Parameters
    ----------
    plate : Plate
    sources : sequence of ForceSource
        Transducers, at least one, with one channel each; stored as a tuple.
    attenuation : Attenuation
    shear_factor : float, optional
        Mindlin's shear factor (5/6). Default: None, Kirchhoff's thin plate.
    """

    plate: Plate
    sources: Sequence[ForceSource]
    attenuation: Attenuation
    shear_factor: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "sources", tuple(self.sources))
        some("Screen.sources", self.sources)
        for i, source in enumerate(self.sources):
            source.check(self.plate, f"Screen.sources[{i}]")

    @property
    def n_channels(self) -> int:
        return len(self.sources)

    def modes(self, f_max_hz: float) -> Modes:
        """Return the modes below a frequency."""
        return modes_of(self.plate, f_max_hz, shear_factor=self.shear_factor)

    def oscillators(self, f_max_hz: float) -> Oscillators:
        """Return the modes below a frequency as oscillators of unit mass."""
        modes = self.modes(f_max_hz)
        return Oscillators(modes.angular_frequency_rad_per_s, self.attenuation.rate_per_s(modes.frequency_hz))

    def modal_forces(self, f_max_hz: float) -> FloatArray:
        """Return generalised forces per unit of channel, (n_modes, n_channels)."""
        return _modal_forces(self, f_max_hz)


@lru_cache(maxsize=8)
def _modal_forces(screen: Screen, f_max_hz: float) -> FloatArray:
    forces = modal_forces(screen.modes(f_max_hz), screen.sources)
    forces.setflags(write=False)
    return forces


A4_PROTOTYPE: Final = Screen(A4_SCREEN, tuple(border(A4_SCREEN, 32)), Attenuation())
"""The thesis's prototype: 32 patches on A4 glass of 1.1 mm. Edges, layout, patch and tau are unverified
defaults.
"""


@checked
def warmed(screen: Screen, kelvin: float, shift_per_k: float = FREQUENCY_SHIFT_PER_K) -> Screen:
    """Return the screen at a higher temperature, with lower Young's modulus.

    Raises `InvalidParameter` if the frequencies shift by more than a tenth, where the law is not valid.

    >>> from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE
    >>> warm = warmed(A4_PROTOTYPE, 20.0)
    >>> round(warm.plate.wave_constant_m2_per_s / A4_PROTOTYPE.plate.wave_constant_m2_per_s, 6)
    0.999
    """
    within("warmed", -MOST_SHIFT, MOST_SHIFT, shift_of_frequencies=shift_per_k * kelvin)
    factor = (1 + shift_per_k * kelvin) ** 2
    return replace(screen, plate=replace(screen.plate, youngs_modulus_pa=screen.plate.youngs_modulus_pa * factor))
