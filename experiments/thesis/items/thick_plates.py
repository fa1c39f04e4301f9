"""Tables 3.1 to 3.3: widths and amplitudes of foci of the rig of chapter 3, on glass of 2 and 3 mm."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product

import numpy as np

from tactometry.stimuli.time_reversal import Band, focus_amplitude
from tactometry.stimuli.time_reversal.design.closed_forms import ALPHA, resolution_m
from tactometry.stimuli.time_reversal.focusing.merit import resolution_per_focus_m
from tactometry.stimuli.time_reversal.plate.glass import BOROFLOAT_33

from ..figures.gallery import RIG_BAND, rig
from ..reproduction import Number, Reproduction

FOCI_M = ((0.121, 0.093), (0.15, 0.105), (0.17, 0.12), (0.1, 0.11), (0.14, 0.08))
THICKNESSES_M = (2e-3, 3e-3)
DIAMETERS_M = (12e-3, 35e-3)
F_MAX_HZ = (10e3, 15e3, 20e3, 25e3)
ASSUMES = (
    "A4 sheets of Borofloat with supported edges, eight discs along two sides, tau = 3.5 ms, T = 2 tau, one bit at "
    "30 V; bands from 0 Hz on (10 and 25 kHz are named in the list of figures, those between were chosen here); mean "
    "over five foci around the middle; width at half of the amplitude. Glass, places of the discs and tau (set to "
    "finding-2) are unverified defaults."
)
EARLIER = "Earlier work, on a plate that is not described: eight actuators at 30 V, 10 um, resolution 10 mm (page 36)."
"""Of another prototype: stated, and not compared."""


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


def _widths() -> Iterator[Number]:
    for focus in foci():
        yield Number("simulated width", focus.condition, 1e3 * focus.width_m, "mm", "derived")
        yield Number("diffuse-field law", focus.condition, 1e3 * focus.law_m, "mm", "derived")


def _amplitudes() -> Iterator[Number]:
    first_m = foci()[0].amplitude_m
    for focus in foci():
        yield Number("amplitude", focus.condition, 1e6 * focus.amplitude_m, "um", "calibrated")
        yield Number("over the first row", focus.condition, focus.amplitude_m / first_m, "", "derived")


def _alphas() -> Iterator[Number]:
    """Least squares of R_s = a / sqrt(f_mean), and a over the square root of the wave constant."""
    for thickness_m, diameter_m in product(THICKNESSES_M, DIAMETERS_M):
        rows = [focus for focus in foci() if (focus.thickness_m, focus.diameter_m) == (thickness_m, diameter_m)]
        per_root = np.array([(focus.f_max_hz / 2) ** -0.5 for focus in rows])
        slope = float(per_root @ [focus.width_m for focus in rows] / (per_root @ per_root))
        root = BOROFLOAT_33.plate(0.297, 0.21, thickness_m, "SSSS").wave_constant_m2_per_s ** 0.5
        condition = f"{thickness_m * 1e3:g} mm glass, {diameter_m * 1e3:g} mm discs"
        yield Number("alpha", condition, slope / root, "", "derived")
        yield Number("diffuse-field law, sqrt(pi / 2)", condition, ALPHA, "", "derived")
        yield Number("R_s sqrt(f_mean)", condition, slope, "m Hz^0.5", "derived")


TABLE_3_1 = Reproduction(
    title="Spatial resolution of the focus",
    stated="That there is such a table, in mm, for 2 and 3 mm glass and discs of 12 and 35 mm (pages 11, 12 "
    f"and 16); its values are not in our sources. {EARLIER}",
    assumes=ASSUMES,
    numbers=_widths,
)
TABLE_3_2 = Reproduction(
    title="Displacement amplitude of the focus",
    stated=f"That there is such a table, in um (page 16); its values are not in our sources. {EARLIER}",
    assumes=f"{ASSUMES} The moment per volt of a patch is the constant that was set so that the prototype of "
    "chapter 4 gives 10 um, and is kept for other glass.",
    numbers=_amplitudes,
)
TABLE_3_3 = Reproduction(
    title="Computed values of alpha",
    stated="That alpha was computed for 2 and 3 mm glass (page 16); neither its values nor its definition are "
    "in our sources.",
    assumes=f"alpha is the factor in R_s = alpha (D / rho_s)^(1/4) / sqrt(f_mean) (read between the lines). {ASSUMES}",
    numbers=_alphas,
)
