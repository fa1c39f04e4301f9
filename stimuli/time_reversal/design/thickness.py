"""Choice of the glass thickness: the nearest one that meets a target.

Thinner glass sharpens a focus (width ~ h^(1/2)), has more modes (~ 1/h) and moves more for the same moment. It also
bends and breaks more easily: stress under a finger ~ 1/h^2, deflection ~ 1/h^3.

The moment of a patch per volt is that of the given plate for every thickness, an unverified choice. The lever arm of a
bonded ceramic is half its own plus half the sheet's thickness, and it stiffens a thin sheet. Amplitudes of sheets much
thinner than the given one are therefore upper bounds.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from tactometry.arguments.checked import Positive, checked
from tactometry.arguments.require import positive_array, some

from ..filters import Band
from ..plate.plate import Plate
from ..plate.statics import bending_stress_pa, deflection_m
from .guide import FINGER_DIAMETER_M, FINGER_FORCE_N, STRESS_MAX_PA, Guide, Target, Transducers, recommend

SHEETS_M: Final = (0.3e-3, 0.4e-3, 0.5e-3, 0.55e-3, 0.7e-3, 0.9e-3, 1.1e-3, 1.3e-3, 1.6e-3, 2e-3, 2.5e-3, 3e-3, 4e-3)
"""Thicknesses in which thin glass is sold; unverified default."""


SMALL: Final = 0.5
"""Largest ratio of deflection to thickness for small-deflection theory; unverified default."""


@checked
@dataclass(frozen=True)
class Sheet:
    """A sheet of glass: its design guide, and its stress and deflection under 2 N at the centre (supported edges).

    Both assume small deflections. A plate that bends by more than half of its thickness stretches and bends less
    (`bends_linearly`).
    """

    guide: Guide
    stress_pa: float
    deflection_m: float

    @property
    def thickness_m(self) -> float:
        return self.guide.design.plate.thickness_m

    @property
    def bends_linearly(self) -> bool:
        """True if the deflection is at most `SMALL` of the thickness."""
        return self.deflection_m <= SMALL * self.thickness_m

    @property
    def unreachable(self) -> tuple[str, ...]:
        """Targets missed, and the stress if it exceeds that of glass."""
        if self.stress_pa <= STRESS_MAX_PA:
            return self.guide.unreachable
        return (
            *self.guide.unreachable,
            f"stress: {FINGER_FORCE_N:.0f} N bend {self.thickness_m * 1e3:.3g} mm with {self.stress_pa / 1e6:.3g} MPa, "
            f"more than the {STRESS_MAX_PA / 1e6:.0f} MPa that glass bears permanently; use a thicker or smaller plate",
        )


@checked
def sheets(
    plate: Plate,
    transducers: Transducers,
    band: Band,
    tau_s: float,
    target: Target,
    thicknesses_m: Sequence[float] = SHEETS_M,
) -> list[Sheet]:
    """Return the guide of each thickness, ascending, including `plate`'s."""
    some("sheets.thicknesses_m", thicknesses_m)
    positive_array("sheets.thicknesses_m", thicknesses_m)
    held = replace(plate, boundary="SSSS")
    centre = plate.length_m / 2, plate.width_m / 2
    stress_pa = bending_stress_pa(held, FINGER_FORCE_N, min(FINGER_DIAMETER_M, plate.length_m, plate.width_m))
    bent_m = float(deflection_m(held, FINGER_FORCE_N, centre, *centre)[0])
    choices = []
    for thickness_m in sorted({*map(float, thicknesses_m), plate.thickness_m}):
        thinner = plate.thickness_m / thickness_m
        guide = recommend(replace(plate, thickness_m=thickness_m), transducers, band, tau_s, target)
        choices.append(Sheet(guide, stress_pa * thinner**2, bent_m * thinner**3))
    return choices


@checked
def best_sheet(among: Sequence[Sheet], thickness_m: Positive) -> Sheet:
    """Return the sheet with the fewest missed targets, nearest in thickness.

    >>> from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
    >>> result = sheets(A4_SCREEN, Transducers(side_m=5e-3), Band(20e3, 60e3), 3.5e-3, Target(contrast=28.0))
    >>> best = best_sheet(result, A4_SCREEN.thickness_m)
    >>> best.thickness_m, best.unreachable
    (0.0009, ())
    """
    some("best_sheet.among", among)
    return min(among, key=lambda sheet: (len(sheet.unreachable), abs(math.log(sheet.thickness_m / thickness_m))))
