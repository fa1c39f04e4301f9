"""Ranges of published values behind the bands of findings 1 and 2, and draws from them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import pi, sqrt
from typing import Final

import numpy as np

from tactometry.stimuli.time_reversal.pulp import PulpLoad, Tissue

from .setups import FOCUS
from .spread import SourcedRange

N_DRAWS, SEED = 500, 35

TEXTBOOK: Final = "textbook"
PULP: Final = (
    SourcedRange("contact area at 1 N", "mm2", 80, 120, "no source: from memory"),
    SourcedRange("its exponent of force", "", 0.2, 0.5, "no source: from memory"),
    SourcedRange("density", "kg/m3", 1000, 1100, TEXTBOOK),
    SourcedRange("sound speed", "m/s", 1500, 1700, TEXTBOOK),
    SourcedRange(
        "shear modulus", "Pa", 2e3, 5e4, "a third of 15 and 40 kPa of Li et al. 2022 (abstract), widened", "log"
    ),
    SourcedRange("shear viscosity", "Pa s", 0.3, 15, "15 of Oestreicher 1951 from memory; 0.3: no source", "log"),
)
RANGES: Final = (
    *PULP,
    SourcedRange(
        "threshold at 250 Hz", "um", 0.03, 0.3, "no source: 0.1 of the sensitivity curve, 10 dB either way", "log"
    ),
    SourcedRange("time of summation", "s", 0.1, 0.4, "no source: 0.2 by a factor of 2 either way", "log"),
)


def of_ranges(ranges: Sequence[SourcedRange]) -> str:
    """List ranges with their sources."""
    return "; ".join(f"{one.label} {one.low:g} to {one.high:g} ({one.source})" for one in ranges)


@dataclass(frozen=True)
class FingerDraw:
    """One draw of the finger and of its sensitivity."""

    area_at_1n_m2: float
    area_exponent: float
    tissue: Tissue
    threshold_m: float
    summation_s: float

    def area_m2(self, force_n: float) -> float:
        """Return the contact area under a force above 0."""
        return float(self.area_at_1n_m2 * force_n**self.area_exponent)

    def load(self, force_n: float) -> PulpLoad:
        """Return the pulp at the focus under a force above 0."""
        return PulpLoad(*FOCUS, sqrt(self.area_m2(force_n) / pi), self.tissue)


def draws(n: int = N_DRAWS, seed: int = SEED) -> Iterator[FingerDraw]:
    """Yield draws from all ranges."""
    rng = np.random.default_rng(seed)
    columns = [each.at(rng.random(n)).tolist() for each in RANGES]
    for area_mm2, exponent, *of_tissue, threshold_um, summation_s in zip(*columns, strict=True):
        yield FingerDraw(1e-6 * area_mm2, exponent, Tissue(*of_tissue), 1e-6 * threshold_um, summation_s)
