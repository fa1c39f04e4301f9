"""From the counts of a sensor to newton: a factor, a polynomial or a table."""

import math
from dataclasses import dataclass
from datetime import date

import numpy as np
from numpy.typing import NDArray

from ...arguments.require import expect, given, not_zero
from ...errors import InvalidParameter
from ..measured import Measured, check_age

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class ForceCalibration:
    """One of three forms; what lies outside of a range that is known becomes NaN, a lost sample.

    Parameters
    ----------
    newtons_per_count : float, optional
        With `zero_count`: N per count, not 0 (below 0 where pressing lowers the counts).
    polynomial : tuple of float, optional
        Coefficients of rising power, N, N per count and so on; it rises or falls from `count_low` to `count_high`.
    table_counts, table_forces_n : tuple of float, optional
        Rising counts and the force of each, which rises or falls with them; straight lines between them.
    count_low, count_high : float, optional
        Where the sensor saturates.
    measured_on, measured_by, max_age_days
        When and by whom, and how old it may be.

    Examples
    --------
    >>> ForceCalibration(newtons_per_count=0.01, zero_count=100.0).force_n(np.array([100.0, 350.0])).tolist()
    [0.0, 2.5]
    >>> ForceCalibration(table_counts=(0.0, 10.0), table_forces_n=(0.0, 1.0)).force_n(np.array([5.0, 11.0])).tolist()
    [0.5, nan]
    """

    newtons_per_count: float | None = None
    zero_count: float = 0.0
    polynomial: tuple[float, ...] | None = None
    table_counts: tuple[float, ...] | None = None
    table_forces_n: tuple[float, ...] | None = None
    count_low: float = -math.inf
    count_high: float = math.inf
    measured_on: date | None = None
    measured_by: str | None = None
    max_age_days: int | None = None

    def __post_init__(self) -> None:
        check_age("ForceCalibration", self.max_age_days)
        forms = given({name: getattr(self, name) for name in ("newtons_per_count", "polynomial", "table_counts")})
        several = "none or more than one of newtons_per_count, polynomial and table_counts"
        expect(len(forms) == 1, "ForceCalibration", several, "exactly one")
        if self.newtons_per_count is not None:
            not_zero("ForceCalibration", newtons_per_count=self.newtons_per_count)
        if self.polynomial is not None:
            enough = len(self.polynomial) >= 2 and np.isfinite(self.polynomial).all()
            expect(enough, "ForceCalibration.polynomial", self.polynomial, "at least two finite numbers")
            _check_turns(self.polynomial, self.count_low, self.count_high)
        if self.table_counts is not None:
            _check_table(self.table_counts, self.table_forces_n or ())
        rises = self.count_low < self.count_high
        expect(rises, "ForceCalibration.count_low", self.count_low, f"below count_high, {self.count_high}")

    @property
    def measured(self) -> Measured:
        return Measured(self.measured_on, self.measured_by, self.max_age_days)

    def force_n(self, counts: FloatArray) -> FloatArray:
        """(n_samples,) counts to newton; NaN outside of what is known."""
        known = (counts >= self.count_low) & (counts <= self.count_high)
        return np.where(known, self._force_n(counts), np.nan)

    def _force_n(self, counts: FloatArray) -> FloatArray:
        if self.table_counts is not None and self.table_forces_n is not None:
            return np.interp(counts, self.table_counts, self.table_forces_n, left=np.nan, right=np.nan)
        if self.polynomial is not None:
            return np.asarray(np.polynomial.polynomial.polyval(counts, self.polynomial))
        return (counts - self.zero_count) * (self.newtons_per_count or math.nan)


def _check_table(counts: tuple[float, ...], forces_n: tuple[float, ...]) -> None:
    where = "ForceCalibration.table_counts"
    paired = len(counts) == len(forces_n) >= 2 and np.isfinite([counts, forces_n]).all()
    sizes = f"{len(counts)} counts and {len(forces_n)} table_forces_n"
    expect(paired, where, sizes, "as many of both, at least two, all finite")
    expect(np.all(np.diff(counts) > 0), where, "counts that do not rise", "rising ones")
    steps_n = np.diff(forces_n)
    follows = np.all(steps_n > 0) or np.all(steps_n < 0)
    turns = "forces that neither rise nor fall with the counts"
    expect(follows, "ForceCalibration.table_forces_n", turns, "that; measure them again")


def _check_turns(polynomial: tuple[float, ...], low: float, high: float) -> None:
    slope = np.polynomial.Polynomial(polynomial).deriv().trim()
    roots = np.asarray(slope.roots(), complex)
    turns = (roots.imag == 0) & (roots.real > low) & (roots.real < high)
    is_flat = not np.any(slope.coef)  # a constant has no slope, hence no root that would tell
    if np.any(turns) or is_flat:
        raise InvalidParameter(
            f"ForceCalibration.polynomial: found {polynomial}, which gives one force for several counts from "
            f"{low:g} to {high:g}, expected it to rise or fall there; state count_low and count_high as measured"
        )
