"""Mass and stiffness of bonded patches, as loads on the plate: optional, since a model without them is often enough.

A patch of thickness t on a plate of thickness h adds the mass rho t A and, bent with the plate about the plate's
middle, the rigidity dD = E / (1 - nu^2) ((h/2 + t)^3 - (h/2)^3) / 3: a little too much, because a patch on one side
moves the neutral plane towards itself. Both act on the displacement and the curvature at the centre of the patch, which
holds while the patch is short against the wave, or of each of its `n_parts` x `n_parts` parts.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from tactometry.arguments.annotations import NotNegative, Positive
from tactometry.arguments.checked import checked
from tactometry.arguments.require import whole, within

from ...arrays import ComplexArray, FloatArray
from ..plate.modes import laplacians
from ..plate.plate import Plate
from ..screen.screen import Screen
from ..screen.transducer import PATCH_THICKNESS_M, DiscPatch, Patch
from .load import Attached, PlateLoad

CERAMIC_DENSITY_KG_PER_M3: Final = 7700.0
CERAMIC_MODULUS_PA: Final = 59e9
CERAMIC_POISSON_RATIO: Final = 0.3

GOLDEN_RAD: Final = math.pi * (3 - math.sqrt(5))
"""From point to point of a spiral that covers a disc evenly."""


@checked
@dataclass(frozen=True)
class Stiffener:
    """A patch that resists the curvature at a point with `rigidity_n_m3` (rigidity times area, at least 0)."""

    x_m: float
    y_m: float
    rigidity_n_m3: NotNegative

    def weights(self, screen: Screen, f_max_hz: float) -> FloatArray:
        return laplacians(screen.modes(f_max_hz), self.x_m, self.y_m)[:, 0]

    def dynamic_stiffness(self, s: ComplexArray) -> ComplexArray:
        return np.full(s.shape, self.rigidity_n_m3, complex)


@checked
@dataclass(frozen=True)
class Ceramic:
    """A patch's material and thickness; PZ27, 0.3 mm (unverified defaults)."""

    thickness_m: Positive = PATCH_THICKNESS_M
    density_kg_per_m3: Positive = CERAMIC_DENSITY_KG_PER_M3
    youngs_modulus_pa: Positive = CERAMIC_MODULUS_PA
    poisson_ratio: float = CERAMIC_POISSON_RATIO

    def __post_init__(self) -> None:
        within("Ceramic", 0.0, 0.5, poisson_ratio=self.poisson_ratio)

    def added_rigidity_n_m(self, plate: Plate) -> float:
        """dD of a patch on a plate.

        >>> from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
        >>> round(Ceramic().added_rigidity_n_m(A4_SCREEN), 2)
        9.68
        """
        inner, outer = plate.thickness_m / 2, plate.thickness_m / 2 + self.thickness_m
        return self.youngs_modulus_pa / (1 - self.poisson_ratio**2) * (outer**3 - inner**3) / 3


@checked
def bonded_loads(
    plate: Plate,
    patches: Sequence[Patch | DiscPatch],
    ceramic: Ceramic | None = None,
    *,
    mass: bool = True,
    stiffness: bool = True,
    n_parts: int = 1,
) -> list[Attached]:
    """The loads of patches, to be passed to `loaded_responses` with those of fingers.

    Parameters
    ----------
    n_parts : int
        Parts of a patch along each side, so that a part stays short against the wave: a side of at most a quarter of
        the shortest wave. Of a disc, `n_parts`^2 points with equal areas.

    >>> from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
    >>> from tactometry.stimuli.time_reversal.screen.transducer import border
    >>> loads = bonded_loads(A4_SCREEN, border(A4_SCREEN, 32))
    >>> len(loads), round(sum(load.mass_kg for load in loads if isinstance(load, PlateLoad)) * 1e3, 2)
    (64, 7.39)
    """
    of = ceramic or Ceramic()
    weight, rigidity_n_m = of.density_kg_per_m3 * of.thickness_m, of.added_rigidity_n_m(plate)
    whole("bonded_loads", lowest=1, n_parts=n_parts)
    parts = [(x, y, patch.area_m2 / n_parts**2) for patch in patches for x, y in _parts(patch, n_parts)]
    masses = [PlateLoad(x, y, mass_kg=weight * area_m2) for x, y, area_m2 in parts if mass]
    stiffeners = [Stiffener(x, y, rigidity_n_m * area_m2) for x, y, area_m2 in parts if stiffness]
    return [*masses, *stiffeners]


def _parts(patch: Patch | DiscPatch, n: int) -> list[tuple[float, float]]:
    """Centres of n x n parts of equal area; of a disc on a spiral."""
    if isinstance(patch, Patch):
        steps = (np.arange(n) + 0.5) / n - 0.5
        xs, ys = patch.x_m + steps * patch.length_m, patch.y_m + steps * patch.width_m
        return [(float(x), float(y)) for x in xs for y in ys]
    k = np.arange(n * n) if n > 1 else np.array([-0.5])  # one part lies in the middle, not on the spiral
    r, angle = patch.diameter_m / 2 * np.sqrt((k + 0.5) / n**2), k * GOLDEN_RAD
    xs, ys = patch.x_m + r * np.cos(angle), patch.y_m + r * np.sin(angle)
    return [(float(x), float(y)) for x, y in zip(xs, ys, strict=True)]
