"""The rig of chapter 3: widths and amplitudes of foci on glass of 2 and 3 mm, for discs and bands."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from tactometry.stimuli.time_reversal import Band, focus_amplitude
from tactometry.stimuli.time_reversal.design.closed_forms import resolution_m
from tactometry.stimuli.time_reversal.field.merit import resolution_per_focus_m
from tactometry.stimuli.time_reversal.figures.gallery import RIG_BAND, rig

FOCI_M = ((0.121, 0.093), (0.15, 0.105), (0.17, 0.12), (0.1, 0.11), (0.14, 0.08))
THICKNESSES_M = (2e-3, 3e-3)
DIAMETERS_M = (12e-3, 35e-3)
F_MAX_HZ = (10e3, 15e3, 20e3, 25e3)
ASSUMES = (
    "A4 sheets of Borofloat with supported edges, eight discs along two sides, tau = 3.5 ms, T = 2 tau, one bit at "
    "30 V; bands from 0 Hz on (10 and 25 kHz are named in the list of figures, those between were chosen here); mean "
    "over five foci around the middle; width at half of the amplitude."
)


@dataclass(frozen=True)
class Focus:
    """Mean width (m), amplitude (m) and the width of a diffuse field (m) under a condition."""

    thickness_m: float
    diameter_m: float
    f_max_hz: float
    width_m: float
    amplitude_m: float
    law_m: float

    @property
    def condition(self) -> str:
        glass, disc = f"{self.thickness_m * 1e3:g} mm glass", f"{self.diameter_m * 1e3:g} mm discs"
        return f"{glass}, {disc}, 0-{self.f_max_hz / 1e3:g} kHz"


@lru_cache(maxsize=1)
def foci() -> tuple[Focus, ...]:
    """Every condition."""
    return tuple(_foci())


def _foci() -> Iterator[Focus]:
    for thickness_m in THICKNESSES_M:
        for diameter_m in DIAMETERS_M:
            screen = rig(diameter_m, thickness_m)
            for f_max_hz in F_MAX_HZ:
                emission = replace(RIG_BAND, band=Band(0.0, f_max_hz))
                widths_m = resolution_per_focus_m(screen, FOCI_M, emission)
                heard = [emission.responses(screen, [at_m]) for at_m in FOCI_M]
                amplitudes_m = [focus_amplitude(emission.drive(one), one) for one in heard]
                law_m = resolution_m(screen.plate, emission.band)
                yield Focus(
                    thickness_m, diameter_m, f_max_hz, float(widths_m.mean()), float(np.mean(amplitudes_m)), law_m
                )
