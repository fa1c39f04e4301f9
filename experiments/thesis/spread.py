"""Ranges of uncertain values with sources, and draws from them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tactometry.stimuli.arrays import FloatArray


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
