"""Table 3.3: alpha of the two plates."""

from itertools import product

import numpy as np

from tactometry.stimuli.time_reversal.design.closed_forms import ALPHA
from tactometry.stimuli.time_reversal.plate.glass import BOROFLOAT_33

from ..reproduction import Number, Reproduction
from .thick_plates import ASSUMES, DIAMETERS_M, THICKNESSES_M, foci


def numbers() -> list[Number]:
    return [number for pair in product(THICKNESSES_M, DIAMETERS_M) for number in _of(*pair)]


def _of(thickness_m: float, diameter_m: float) -> list[Number]:
    """Least squares of R_s = a / sqrt(f_mean), and a over the square root of the wave constant."""
    rows = [focus for focus in foci() if (focus.thickness_m, focus.diameter_m) == (thickness_m, diameter_m)]
    per_root = np.array([(focus.f_max_hz / 2) ** -0.5 for focus in rows])
    fitted = float(per_root @ [focus.width_m for focus in rows] / (per_root @ per_root))
    root = BOROFLOAT_33.plate(0.297, 0.21, thickness_m, "SSSS").wave_constant_m2_per_s ** 0.5
    condition = f"{thickness_m * 1e3:g} mm glass, {diameter_m * 1e3:g} mm discs"
    return [
        Number("alpha", condition, fitted / root, "", "derived"),
        Number("diffuse-field law, sqrt(pi / 2)", condition, ALPHA, "", "derived"),
        Number("R_s sqrt(f_mean)", condition, fitted, "m Hz^0.5", "derived"),
    ]


TABLE = Reproduction(
    title="Computed values of alpha",
    stated="That alpha was computed for 2 and 3 mm glass (page 16); neither its values nor its definition are "
    "in our sources.",
    assumes=f"alpha is the factor in R_s = alpha (D / rho_s)^(1/4) / sqrt(f_mean) (read between the lines). {ASSUMES}",
    numbers=numbers,
)
