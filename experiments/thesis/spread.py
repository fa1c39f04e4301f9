"""Ranges of uncertain values with sources, and draws from them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import pi, sqrt
from typing import Final, Literal

import numpy as np

from tactometry.stimuli.arrays import FloatArray
from tactometry.stimuli.time_reversal.pulp import PulpLoad, Tissue

from .setups import FOCUS


@dataclass(frozen=True)
class SourcedRange:
    """Values that sources leave open, all equally likely on a scale.

    - `low`, `high`: Ends of the range, above 0 on the scale "log".
    - `source`: Where the ends are from and how they were read, or "no source".
    """

    name: str
    unit: str
    low: float
    high: float
    source: str
    scale: Literal["linear", "log"] = "linear"

    @property
    def label(self) -> str:
        """Name with the unit, if any."""
        return f"{self.name}, {self.unit}" if self.unit else self.name

    def at(self, share: FloatArray) -> FloatArray:
        """Return the values at shares (0 to 1) of the range.

        >>> SourcedRange("area", "m^2", 1.0, 100.0, "no source", "log").at(np.array([0.0, 0.5])).tolist()
        [1.0, 10.0]
        """
        if self.scale == "log":
            return np.asarray(self.low * (self.high / self.low) ** share)
        return np.asarray(self.low + (self.high - self.low) * share)


def draw(ranges: Mapping[str, SourcedRange], n_draws: int, seed: int) -> dict[str, FloatArray]:
    """Return (n_draws,) values of each range, a Latin hypercube.

    Each range has one draw in each of `n_draws` equal parts, so that quantiles need fewer draws than independent ones.
    """
    rng = np.random.default_rng(seed)
    parts = rng.permuted(np.tile(np.arange(n_draws), (len(ranges), 1)), axis=1)
    shares = (parts + rng.random(parts.shape)) / n_draws
    return {name: one.at(share) for (name, one), share in zip(ranges.items(), shares, strict=True)}


def rank_correlations(drawn: Mapping[str, FloatArray], result: FloatArray) -> dict[str, float]:
    """Return Spearman's correlation of a result (n_draws,) with each range.

    >>> rank_correlations({"area": np.array([1.0, 2.0, 3.0])}, np.array([9.0, 4.0, 1.0]))
    {'area': -1.0}
    """
    ranks = np.asarray(np.argsort(np.argsort([result, *drawn.values()], axis=1), axis=1), dtype=np.float64)
    return dict(zip(drawn, np.corrcoef(ranks)[0, 1:].round(12).tolist(), strict=True))


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
