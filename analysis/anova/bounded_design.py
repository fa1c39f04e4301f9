"""Designs with bounds or missing values, and their complete subsets."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product
from typing import Any

import numpy as np
import pandas as pd

from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter

from ..arrays import Array, Bools, Indices, size_of
from .bounded_fit import BoundedValues
from .design import (
    MIN_PARTICIPANTS,
    DesignStatus,
    codes_of,
    expect_columns,
    expect_defined,
    expect_names,
    refuse_constant,
    refuse_few,
)
from .split_plot import groups_of

MIN_KNOWN = 2
"""Smallest number of known values in each condition (of each group)."""
BOUND = "a value, or a lower bound that does not exceed the upper bound; remove this row"
MAX_SUBSETS = 200_000

Subset = tuple[tuple[int, ...], ...]
"""Indices of the levels kept, for each factor."""


@dataclass(frozen=True)
class BoundedDesign:
    """Standardised values with their bounds, factors, levels and groups.

    Values are in units of `scale` about `centre`. `n_censored` values are known only by a bound, `n_missing` values are
    unknown. Without a factor `between` there is one group.
    """

    data: BoundedValues
    factors: tuple[str, ...]
    levels: tuple[tuple[object, ...], ...]
    between: str | None
    groups: tuple[object, ...]
    n_censored: int
    n_missing: int
    centre: float = 0.0
    scale: float = 1.0

    def cells(self) -> list[dict[str, object]]:
        """Return the condition of each mean, with the last factor varying fastest."""
        names = [*([self.between] if self.between else []), *self.factors]
        levels = [*([self.groups] if self.between else []), *self.levels]
        return [dict(zip(names, cell, strict=True)) for cell in product(*levels)]


def bounded_design(
    table: pd.DataFrame,
    *,
    dependent: str,
    low: str,
    high: str,
    within: Sequence[str],
    between: str | None,
    subject: str,
) -> BoundedDesign:
    """Arrange a table with at most one row per cell as a design.

    Raises `InvalidParameter` for a missing column, a lower bound above the upper bound, several values in a cell, or a
    participant in two groups. Raises `UndefinedStatistic` for too few participants, levels or known values in a cell,
    or if all values are equal.
    """
    keys = [subject, *within, *([between] if between else [])]
    expect_columns(table, [dependent, low, high, *keys], "censored_anova")
    expect_names(table, keys)
    coded = [codes_of(table, name) for name in (subject, *within)]
    levels = tuple(tuple(different) for _, different in coded)
    refuse_few(levels, subject, within)

    groups = None if between is None else groups_of(table, levels[0], subject, between)
    of = np.zeros(len(levels[0]), dtype=np.int64) if groups is None else groups.of
    ends = _layout(ends_of(table, dependent, low, high), [codes for codes, _ in coded], levels, table, keys)
    data = BoundedValues(*ends, of, tuple(len(names) for names in levels[1:]))
    n_missing = int((np.isinf(data.low) & np.isinf(data.high)).sum())
    design = BoundedDesign(
        data=data,
        factors=tuple(within),
        levels=levels[1:],
        between=between,
        groups=("",) if groups is None else groups.names,
        n_censored=int((~data.known).sum()) - n_missing,
        n_missing=n_missing,
    )
    _refuse_unknown(design)
    return _standardised(design, dependent)


def ends_of(table: pd.DataFrame, dependent: str, low: str, high: str) -> Array:
    """Return the interval (row, 2) of each value; ends of known values agree.

    Raises `InvalidParameter` for text, infinite values, or a lower bound above the upper bound. The error names the
    row.
    """
    y, bottom, top = (_numbers(table, name) for name in (dependent, low, high))
    known = ~np.isnan(y)
    bottom = np.where(known, y, np.where(np.isnan(bottom), -np.inf, bottom))
    top = np.where(known, y, np.where(np.isnan(top), np.inf, top))
    bad = ~(bottom <= top) | (known & np.isinf(y))
    row = int(bad.argmax())
    expect(not bad.any(), f"{dependent}, row {row}", f"the bounds {bottom[row]:g} and {top[row]:g}", BOUND)
    return np.stack([bottom, top], axis=1)


def _numbers(table: pd.DataFrame, name: str) -> Array:
    values = pd.to_numeric(table[name], errors="coerce").to_numpy(dtype=np.float64, na_value=np.nan)
    bad = np.isnan(values) & table[name].notna().to_numpy()
    row = int(bad.argmax())
    expect(not bad.any(), f"{name}, row {row}", table[name].iloc[row], "a number or nothing")
    return values


def _layout(
    ends: Array,
    codes: Sequence[Indices],
    levels: Sequence[Sequence[object]],
    table: pd.DataFrame,
    keys: Sequence[str],
) -> tuple[Array, Array]:
    """Return lower and upper ends (participant, cell), infinite if missing."""
    shape = tuple(len(names) for names in levels)
    place = np.ravel_multi_index(list(codes), shape)
    order, n = np.unique(place, return_counts=True)
    if (n > 1).any():
        row = table.iloc[int(np.flatnonzero(place == order[n.argmax()])[0])]
        cell = ", ".join(f"{name} = {row[name]}" for name in keys[: len(codes)])
        raise InvalidParameter(
            f"{cell}: found {n.max()} values, expected one in each cell, as bounds cannot be averaged"
        )
    laid = np.tile([-np.inf, np.inf], (int(np.prod(shape)), 1))
    laid[place] = ends
    low, high = laid.reshape(shape[0], -1, 2).transpose(2, 0, 1)
    return low, high


def _refuse_unknown(design: BoundedDesign) -> None:
    group, is_known = design.data.group, design.data.known
    known = np.stack([is_known[group == g].sum(axis=0) for g in range(len(design.groups))])
    for names, n in zip(design.cells(), known.ravel(), strict=True):
        cell = ", ".join(f"{name} = {level}" for name, level in names.items()) or "table"
        found = f"{n} known value{'s' if n != 1 else ''}"
        expected = f"at least {MIN_KNOWN} in addition to bounds; remove this condition"
        expect_defined(n >= MIN_KNOWN, DesignStatus.TOO_FEW_KNOWN, cell, found, expected)


def _standardised(design: BoundedDesign, dependent: str) -> BoundedDesign:
    """Standardise by the mean and standard deviation of the known values."""
    data = design.data
    size = size_of(data.low[data.known])
    known = data.low[data.known] / size
    centre, scale = float(known.mean()), float(known.std())
    refuse_constant(scale, float(np.abs(known).max()), dependent)
    low, high = ((ends / size - centre) / scale for ends in (data.low, data.high))
    return replace(design, data=replace(data, low=low, high=high), centre=centre * size, scale=scale * size)


@dataclass(frozen=True)
class SubDesign:
    """Subset of a table, with its factors and the names of what it omits."""

    table: pd.DataFrame
    within: tuple[str, ...]
    left_out: tuple[str, ...]


def largest_complete(table: pd.DataFrame, *, dependent: str, within: Sequence[str], subject: str) -> SubDesign | None:
    """Return the largest complete set of participants and levels.

    Among sets of equal size, the one with more participants wins. All combinations of levels are tried, or only the
    full set of levels if there are more than `MAX_SUBSETS` combinations. None if no three participants share two levels
    of a factor.
    """
    axes, has = _presence(table, dependent, (subject, *within))
    best: tuple[Subset, Bools] | None = None
    best_rank = 0, 0
    for chosen in _subsets(axes[1:]):
        complete: Bools = np.asarray(has[np.ix_(range(len(has)), *chosen)].reshape(len(has), -1).all(axis=1))
        n_complete = int(complete.sum())
        rank = n_complete * _n_cells(chosen), n_complete
        if n_complete >= MIN_PARTICIPANTS and rank > best_rank:  # ties keep the first set
            best, best_rank = (chosen, complete), rank
    return None if best is None else _part(table, (subject, *within), axes, *best)


def largest_known(
    table: pd.DataFrame, *, dependent: str, within: Sequence[str], subject: str, between: str | None, at_least: int
) -> SubDesign | None:
    """Return the largest set of levels with enough known values.

    Each combination of levels has `at_least` known values (in each group). All participants are kept. None if no such
    set has two levels of a factor.
    """
    axes, has = _presence(table, dependent, (subject, *within))
    by_subject = table.drop_duplicates(subject).set_index(subject)
    group = np.zeros(len(has)) if between is None else pd.factorize(by_subject.loc[axes[0], between])[0]
    n_known = np.stack([has[group == g].sum(axis=0) for g in np.unique(group)]).min(axis=0)
    known = [chosen for chosen in _subsets(axes[1:]) if n_known[np.ix_(*chosen)].min() >= at_least]
    everyone = np.ones(len(has), dtype=bool)
    # `max` keeps the first of equally large sets.
    return _part(table, (subject, *within), axes, max(known, key=_n_cells), everyone) if known else None


def _presence(table: pd.DataFrame, dependent: str, columns: Sequence[str]) -> tuple[list[list[Any]], Bools]:
    """Return the values of each column, and which combinations are known."""
    axes = [sorted(table[name].unique()) for name in columns]
    has = np.zeros([len(names) for names in axes], dtype=bool)
    known = table[table[dependent].notna()]
    has[tuple(pd.Index(names).get_indexer(known[name]) for name, names in zip(columns, axes, strict=True))] = True
    return axes, has


def _part(
    table: pd.DataFrame, columns: Sequence[str], axes: Sequence[list[Any]], chosen: Subset, complete: Bools
) -> SubDesign:
    """Select `complete` participants (first column) at the chosen levels."""
    kept_places = [tuple(np.flatnonzero(complete)), *chosen]
    left_out = [f"participant {code}" for code, is_kept in zip(axes[0], complete, strict=True) if not is_kept]
    for n, (name, values, places) in enumerate(zip(columns, axes, kept_places, strict=True)):
        table = table[table[name].isin([values[i] for i in places])]
        left_out += [f"{name} = {values[i]}" for i in range(len(values)) if n and i not in places]
    within = tuple(name for name, places in zip(columns[1:], chosen, strict=True) if len(places) > 1)
    return SubDesign(table, within, tuple(left_out))


def _n_cells(chosen: Subset) -> int:
    return int(np.prod([len(places) for places in chosen]))


def _subsets(levels: Sequence[Sequence[object]]) -> list[Subset]:
    """Return subsets with at least two levels of a factor, largest first."""
    sizes = [len(names) for names in levels]
    if np.prod([2.0**n - 1 for n in sizes]) > MAX_SUBSETS:  # float, as the product may overflow an integer
        return [tuple(tuple(range(n)) for n in sizes)]
    by_factor = [[places for size in range(n, 0, -1) for places in combinations(range(n), size)] for n in sizes]
    return [chosen for chosen in product(*by_factor) if _n_cells(chosen) > 1]
