"""Tables by condition, means with t-intervals, rates with Wilson's."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.special import expit, ndtri

from .arrays import RELATIVE_ZERO, Array, size_of
from .distributions import Student


def parts(table: pd.DataFrame, keys: Sequence[str]) -> Iterable[tuple[tuple[Any, ...], pd.DataFrame]]:
    """Return the rows of each combination of values, in sorted order."""
    return table.groupby(list(keys), sort=True, observed=True) if keys else [((), table)]


def by_condition(
    table: pd.DataFrame, keys: Sequence[str], row_of: Callable[[pd.DataFrame], Mapping[str, object]]
) -> pd.DataFrame:
    """Return one row per combination: its values and the result of `row_of`.

    >>> table = pd.DataFrame({"force_n": [3.0, 0.5, 3.0], "y": [1, 2, 3]})
    >>> by_condition(table, ["force_n"], lambda part: {"sum": part["y"].sum()}).values.tolist()
    [[0.5, 2.0], [3.0, 4.0]]
    """
    groups = parts(table, keys) if len(table) else ()
    return pd.DataFrame([dict(zip(keys, key, strict=True)) | dict(row_of(rows)) for key, rows in groups])


@dataclass(frozen=True)
class Range:
    """Possible values of a quantity, which limit the interval of a mean."""

    low: float = -np.inf
    high: float = np.inf

    @property
    def is_bounded(self) -> bool:
        return bool(np.isfinite([self.low, self.high]).any())

    def around(self, mean: float, half: float) -> tuple[float, float]:
        """Return the interval of a mean from half its unbounded length.

        By the delta method, the interval is symmetric on the logit of the range, or on the logarithm if one end is
        open.

        >>> [round(end, 3) for end in Range(0, 1).around(0.71, 0.75)]
        [0.06, 0.989]
        >>> [round(end, 3) for end in Range(0).around(2.0, 3.0)], Range().around(2.0, 3.0)
        ([0.446, 8.963], (-1.0, 5.0))
        """
        if not self.low < mean < self.high:
            return mean - half, mean + half
        below, above = mean - self.low, self.high - mean
        if np.isfinite(above) and np.isfinite(below):
            step = half * (1 / below + 1 / above)
            low, high = (self.low + (below + above) * expit(np.log(below / above) + s) for s in (-step, step))
            return float(low), float(high)
        if np.isfinite(below):
            return self.low + below * float(np.exp(-half / below)), self.low + below * float(np.exp(half / below))
        if np.isfinite(above):
            return self.high - above * float(np.exp(half / above)), self.high - above * float(np.exp(-half / above))
        return mean - half, mean + half


ANY, RATE, POSITIVE, AT_MOST_1 = Range(), Range(0.0, 1.0), Range(0.0), Range(high=1.0)
FEWEST_IN_RANGE = 3
"""Smallest number of values for an interval of a bounded quantity."""
INTERVAL = 0.95
MEAN = ("mean", "mean_low", "mean_high", "sd")


def mean_row(values: Array, interval: float = INTERVAL, name: str = "mean", possible: Range = ANY) -> dict[str, object]:
    """Return the columns of `MEAN` with prefix `name`, None if undefined."""
    row = dict.fromkeys(MEAN) | mean_with_interval(values, interval, possible)
    return {column.replace("mean", name): value for column, value in row.items()}


def mean_with_interval(values: Array, interval: float = INTERVAL, possible: Range = ANY) -> dict[str, object]:
    """Return the mean, SD and t-interval, as far as they are defined.

    The interval stays within the `possible` range. If the range is bounded, it needs `FEWEST_IN_RANGE` values.

    >>> {name: round(x, 3) for name, x in mean_with_interval(np.array([1.0, 2, 4]), 0.95).items()}
    {'mean': 2.333, 'mean_low': -1.461, 'mean_high': 6.128, 'sd': 1.528}
    >>> {name: round(x, 3) for name, x in mean_with_interval(np.array([0.4, 0.8, 0.93]), possible=RATE).items()}
    {'mean': 0.71, 'mean_low': 0.08, 'mean_high': 0.986, 'sd': 0.276}
    """
    n, size = len(values), size_of(values)
    mean = float((values / size).mean())
    if n < 2:
        return {"mean": mean * size}
    sd = float((values / size).std(ddof=1))
    if sd <= RELATIVE_ZERO * float(np.abs(values / size).max()):
        return {"mean": mean * size, "sd": 0.0}
    known: dict[str, object] = {"mean": mean * size, "sd": sd * size}
    if possible.is_bounded and n < FEWEST_IN_RANGE:
        return known
    half = float(Student.ppf((1 + interval) / 2, n - 1)) * sd / float(np.sqrt(n)) * size
    low, high = possible.around(mean * size, half)
    return {"mean": mean * size, "mean_low": low, "mean_high": high, "sd": sd * size}


def rate_interval(n_yes: ArrayLike, n_trials: ArrayLike, interval: float = INTERVAL) -> tuple[Array, Array]:
    """Return the Wilson interval of rates (1927, J. Am. Stat. Assoc. 22, 209).

    >>> [end.round(3).tolist() for end in rate_interval([0, 5, 10], [10, 10, 10])]
    [[0.0, 0.237, 0.722], [0.278, 0.763, 1.0]]
    """
    k, n = (np.asarray(counts, dtype=np.float64) for counts in (n_yes, n_trials))
    z = float(ndtri((1 + interval) / 2))
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = k / n
        middle = (rate + z**2 / (2 * n)) / (1 + z**2 / n)
        half = z * np.sqrt(rate * (1 - rate) / n + (z / (2 * n)) ** 2) / (1 + z**2 / n)
    # Rounding may exclude a rate of exactly 0 or 1, but error bars must not be negative.
    return np.minimum(middle - half, rate), np.maximum(middle + half, rate)
