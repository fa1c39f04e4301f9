"""Counts of answers by level: checks, pooling and scaling."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter

from ..arrays import Array, Bools, Indices, Rows

POOLED_BELOW = 1e-9
"""Levels closer than this fraction of their range are pooled."""
LARGEST = 1e300
"""Largest absolute level, as the range of larger levels could overflow."""


@dataclass(frozen=True)
class Counts(Rows):
    """Counts of many data sets, at levels u = (level - centre) / spread.

    `u`, `n_yes`, `n_trials` have the shape (n_sets, n_levels); unused slots have n_trials 0 and u 0.
    `centre`, `spread` (the range of the levels, or 1 for a single level), `gap` (smallest spacing over
    spread) and `n_levels` (distinct levels used) have the shape (n_sets,).
    """

    u: Array
    n_yes: Array
    n_trials: Array
    centre: Array
    spread: Array
    gap: Array
    n_levels: Indices

    def __len__(self) -> int:
        return len(self.u)

    def by_level(self) -> "Counts":
        """Return the counts with sets adjacent in memory, for faster sums."""
        u, k, n = (np.asfortranarray(values) for values in (self.u, self.n_yes, self.n_trials))
        return replace(self, u=u, n_yes=k, n_trials=n)


def count_arrays(
    levels: ArrayLike, n_correct: ArrayLike, n_trials: ArrayLike, *, logarithms: bool = False
) -> tuple[Array, Array, Array]:
    """Check levels and counts and return arrays (n_sets, n_levels).

    With `logarithms` the levels are replaced by their logarithms. Values without trials are 0.

    Raises `InvalidParameter` for an invalid value. The error names the row (and the data set) of the first one.
    """
    x = _numbers("levels", levels)
    k = _numbers("n_correct", n_correct)
    n = _numbers("n_trials", n_trials)
    try:
        if x.ndim and k.ndim and x.shape[-1] != k.shape[-1]:
            raise ValueError  # a single count would broadcast to every level
        x, k, n = (np.atleast_2d(v) for v in np.broadcast_arrays(x, k, n))
    except ValueError:
        raise InvalidParameter(
            f"levels, n_correct, n_trials: found the shapes {x.shape}, {k.shape}, {n.shape}, expected equal shapes"
        ) from None
    expect(x.ndim == 2, "levels", f"{x.ndim} dimensions", "(data set, level)")
    used = n != 0
    # The tests are negated expectations, so that NaN is rejected too.
    is_size = np.isfinite(n) & (n > 0) & (n == np.floor(n))
    _refuse("n_trials", n, used & ~is_size, "a whole number, 0 or more")
    _refuse("levels", x, used & ~np.isfinite(x), "a finite number")
    _refuse("levels", x, used & (np.abs(x) > LARGEST), f"an absolute value of at most {LARGEST:g}")
    if logarithms:
        _refuse("levels", x, used & ~(x > 0), "a level above 0, as its logarithm is fitted")
        x = np.log(np.where(used, x, 1.0))
    is_count = (k >= 0) & (k == np.floor(k))
    _refuse("n_correct", k, used & ~is_count, "a whole number, 0 or more")
    _refuse("n_correct", k, used & (k > n), "at most n_trials of the row")
    return np.where(used, x, 0.0), np.where(used, k, 0.0), np.where(used, n, 0.0)


def _numbers(name: str, values: ArrayLike) -> Array:
    array = np.asarray(values)
    if array.dtype.kind in "biuf":
        return array.astype(np.float64)
    for row, value in enumerate(array.ravel().tolist()):
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InvalidParameter(f"{name}, row {row}: found {value!r}, expected a number")
    return array.astype(np.float64)


def _refuse(name: str, values: Array, bad: Bools, expected: str) -> None:
    if bad.any():
        dataset, row = np.argwhere(bad)[0]
        where = f"{name}, row {row}" + (f" of data set {dataset}" if values.shape[0] > 1 else "")
        raise InvalidParameter(f"{where}: found {values[dataset, row]:g}, expected {expected} (rows count from 0)")


def normalise(x: Array, k: Array, n: Array, *, robust_range: bool = False) -> Counts:
    """Sort levels (n_sets, n_levels), pool equal levels, and scale each set.

    Levels that differ by less than `POOLED_BELOW` of the range are pooled. The range is that of all levels, or
    (`robust_range`) of those within Tukey's fences.
    """
    if x.shape[1] == 0:  # add an unused slot, as the code below needs at least one
        x, k, n = (np.zeros((x.shape[0], 1)) for _ in range(3))
    # Sort unused slots last, as pooling and spacings compare neighbours.
    order = np.argsort(np.where(n > 0, x, np.inf), axis=1, kind="stable")
    x, k, n = (np.take_along_axis(values, order, 1) for values in (x, k, n))
    used = n > 0
    low, high = _tukey_range(x, n, *_ends(x, used)) if robust_range else _ends(x, used)
    centre, spread = low + (high - low) / 2, np.where(high > low, high - low, 1.0)
    u = np.where(used, (x - centre[:, None]) / spread[:, None], 0.0)
    u, k, n = _pool(u, k, n)
    return Counts(u, k, n, centre, spread, _smallest_gap(u, n), (n > 0).sum(axis=1))


def _ends(x: Array, used: Bools) -> tuple[Array, Array]:
    low = np.where(used, x, np.inf).min(axis=1)
    high = np.where(used, x, -np.inf).max(axis=1)
    return np.where(np.isfinite(low), low, 0.0), np.where(np.isfinite(high), high, 0.0)


def _tukey_range(x: Array, n: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """Clip the range to the fences of Tukey (1977), if quartiles differ."""
    share = np.cumsum(n, axis=1) / np.maximum(n.sum(axis=1, keepdims=True), 1)
    places = ((share < quarter).sum(axis=1, keepdims=True) for quarter in (0.25, 0.75))
    first, third = (np.take_along_axis(x, np.minimum(place, x.shape[1] - 1), 1)[:, 0] for place in places)
    reach = 1.5 * (third - first)
    # If most trials are at one level, the interquartile range is 0 and the fences would keep only that level.
    kept = (reach > 0) & (n.sum(axis=1) > 0)
    inner, outer = np.maximum(low, first - reach), np.minimum(high, third + reach)
    return np.where(kept, inner, low), np.where(kept, outer, high)


def _pool(u: Array, k: Array, n: Array) -> tuple[Array, Array, Array]:
    used = n > 0
    is_new = np.ones_like(used)
    is_new[:, 1:] = np.diff(u, axis=1) > POOLED_BELOW
    if (is_new | ~used).all():
        return u, k, n  # return early, as the mean u n / n would change the last bits of the levels
    place = np.cumsum(is_new & used, axis=1) - 1
    rows = np.broadcast_to(np.arange(u.shape[0])[:, None], u.shape)[used]
    cells = rows * u.shape[1] + place[used]
    sums, k, n = (totals(cells, value[used], u.shape) for value in (u * n, k, n))
    return np.divide(sums, n, out=sums, where=n > 0), k, n


def totals(cells: Indices, values: Array, shape: tuple[int, ...]) -> Array:
    """Return the sum of the values in each cell of an array."""
    return np.bincount(cells, values, int(np.prod(shape))).astype(np.float64).reshape(shape)


def _smallest_gap(u: Array, n: Array) -> Array:
    if u.shape[1] < 2:
        return np.ones(u.shape[0])
    both = (n[:, 1:] > 0) & (n[:, :-1] > 0)
    return np.asarray(np.where(both, np.diff(u, axis=1), 1.0).min(axis=1))
