"""Ranges of published values behind the bands of findings 1 and 2, and draws from them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import pi, sqrt
from typing import Any, Final

import numpy as np

from tactometry.stimuli.arrays import FloatArray
from tactometry.stimuli.time_reversal.pulp import PulpLoad, Tissue

from .reproduction import Number
from .setups import FOCUS

N_DRAWS, SEED = 500, 35
BAND = (5.0, 95.0)
"""Percentiles that are the ends of a band."""


@dataclass(frozen=True)
class Range:
    """Values between which one is drawn, evenly, or evenly in the logarithm."""

    low: float
    high: float
    source: str
    is_log: bool = False

    def draw(self, rng: np.random.Generator, n: int) -> FloatArray:
        """Return n values."""
        if self.is_log:
            return np.asarray(np.exp(rng.uniform(np.log(self.low), np.log(self.high), n)))
        return rng.uniform(self.low, self.high, n)


TEXTBOOK: Final = "soft tissue, textbook"
RANGES: Final[Mapping[str, Range]] = {
    "area_at_1n_m2": Range(0.8e-4, 1.2e-4, "no source: from memory"),
    "area_exponent": Range(0.2, 0.5, "no source: from memory; a sphere of Hertz has 2/3"),
    "density_kg_per_m3": Range(1000, 1100, TEXTBOOK),
    "sound_speed_m_per_s": Range(1500, 1700, TEXTBOOK),
    "shear_modulus_pa": Range(2e3, 5e4, "about a third of 15 and 40 kPa (Li et al. 2022, abstract), widened", True),
    "shear_viscosity_pa_s": Range(0.3, 15, "15: von Gierke and Oestreicher, from memory; 0.3: no source", True),
    "threshold_m": Range(0.03e-6, 0.3e-6, "no source: 0.1 um of the sensitivity curve by 10 dB either way", True),
    "summation_s": Range(0.1, 0.4, "no source: 0.2 s by a factor of 2 either way", True),
}


@dataclass(frozen=True)
class Drawn:
    """One draw of the finger and of its sensitivity."""

    area_at_1n_m2: float
    area_exponent: float
    tissue: Tissue
    threshold_m: float
    summation_s: float

    def area_m2(self, force_n: float) -> float:
        """Return the contact area under a force above 0."""
        return self.area_at_1n_m2 * force_n**self.area_exponent

    def load(self, force_n: float) -> PulpLoad:
        """Return the pulp at the focus under a force above 0."""
        return PulpLoad(*FOCUS, sqrt(self.area_m2(force_n) / pi), self.tissue)


def draws(n: int = N_DRAWS, seed: int = SEED) -> Iterator[Drawn]:
    """Yield draws from all ranges."""
    rng = np.random.default_rng(seed)
    columns = {name: each.draw(rng, n).tolist() for name, each in RANGES.items()}
    for row in zip(*columns.values(), strict=True):
        drawn = dict(zip(columns, row, strict=True))
        tissue = Tissue(*(drawn.pop(name) for name in list(drawn)[2:6]))
        yield Drawn(tissue=tissue, **drawn)


@dataclass(frozen=True)
class Band:
    """Median of the draws, and the percentiles that are its ends."""

    low: float
    value: float
    high: float

    def holds(self, stated: float) -> bool:
        """Return True if a statement is within the band."""
        return self.low <= stated <= self.high

    def number(self, quantity: str, condition: str, unit: str, **statement: Any) -> Number:
        """Return a derived number with this band."""
        return Number(quantity, condition, self.value, unit, "derived", low=self.low, high=self.high, **statement)


def band_of(values: Sequence[float] | FloatArray) -> Band:
    """Return the band of values."""
    return Band(*np.percentile(values, [BAND[0], 50, BAND[1]]).tolist())
