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


TEXTBOOK: Final = "textbook"
PULP: Final[Mapping[str, Range]] = {
    "contact area at 1 N, mm2": Range(80, 120, "no source: from memory"),
    "its exponent of force": Range(0.2, 0.5, "no source: from memory"),
    "density, kg/m3": Range(1000, 1100, TEXTBOOK),
    "sound speed, m/s": Range(1500, 1700, TEXTBOOK),
    "shear modulus, Pa": Range(2e3, 5e4, "a third of 15 and 40 kPa of Li et al. 2022 (abstract), widened", True),
    "shear viscosity, Pa s": Range(0.3, 15, "15 of Oestreicher 1951 from memory; 0.3: no source", True),
}
RANGES: Final[Mapping[str, Range]] = {
    **PULP,
    "threshold at 250 Hz, um": Range(0.03, 0.3, "no source: 0.1 of the sensitivity curve, 10 dB either way", True),
    "time of summation, s": Range(0.1, 0.4, "no source: 0.2 by a factor of 2 either way", True),
}


def of_ranges(ranges: Mapping[str, Range]) -> str:
    """List ranges with their sources."""
    return "; ".join(f"{name} {each.low:g} to {each.high:g} ({each.source})" for name, each in ranges.items())


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
        return float(self.area_at_1n_m2 * force_n**self.area_exponent)

    def load(self, force_n: float) -> PulpLoad:
        """Return the pulp at the focus under a force above 0."""
        return PulpLoad(*FOCUS, sqrt(self.area_m2(force_n) / pi), self.tissue)


def draws(n: int = N_DRAWS, seed: int = SEED) -> Iterator[Drawn]:
    """Yield draws from all ranges."""
    rng = np.random.default_rng(seed)
    columns = [each.draw(rng, n).tolist() for each in RANGES.values()]
    for area_mm2, exponent, *of_tissue, threshold_um, summation_s in zip(*columns, strict=True):
        yield Drawn(1e-6 * area_mm2, exponent, Tissue(*of_tissue), 1e-6 * threshold_um, summation_s)


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
