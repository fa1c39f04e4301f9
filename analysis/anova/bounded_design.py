"""A design of values of which some are bounds or missing, from a table in long form.

The largest part of a within-participant design that has holes: complete, or with values enough for a model.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product
from typing import Any

import numpy as np
import pandas as pd

from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter

from ..arrays import Array, Bools, size_of
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
from .strata import BoundedValues

MIN_KNOWN = 2
"""Known values that each condition needs (in each group)."""
BOUND = "a value, or a bound below or above it, in this order; leave the row out"


@dataclass(frozen=True)
class BoundedDesign:
    """`data` is in units of `scale` about `centre`. `levels` are those of the `factors`, `groups` those of participants
    (one, without a name, where there are none). `n_censored` values are bounds, `n_missing` are not known at all."""

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
        """The names of the means: group by group the cells, the last factor fastest."""
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
    """The design of a table: a row per value, at most one in each cell; a row without value and bounds is as no row.

    Raises
    ------
    InvalidParameter
        For a column that is not there, crossed bounds, several values in a cell, a participant in two groups.
    UndefinedStatistic
        For too few participants, levels or known values in a cell, and the same value everywhere.
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
    """The interval (row, 2) of each value; both ends meet where it is known.

    Raises
    ------
    InvalidParameter
        For what is no number, infinite values and crossed bounds, naming the row.
    """
    y, bottom, top = (numbers(table, name) for name in (dependent, low, high))
    known = ~np.isnan(y)
    bottom = np.where(np.isnan(bottom), -np.inf, bottom)
    top = np.where(np.isnan(top), np.inf, top)
    bottom, top = np.where(known, y, bottom), np.where(known, y, top)
    bad = ~(bottom <= top) | (known & np.isinf(y))
    row = int(bad.argmax())
    found = f"the bounds {bottom[row]:g} and {top[row]:g}"
    expect(not bad.any(), f"{dependent}, row {row}", found, BOUND)
    return np.stack([bottom, top], axis=1)


def numbers(table: pd.DataFrame, name: str) -> Array:
    """A column with NaN where it is empty.

    Raises
    ------
    InvalidParameter
        For what is no number, naming the row.
    """
    values = pd.to_numeric(table[name], errors="coerce").to_numpy(dtype=np.float64, na_value=np.nan)
    bad = np.isnan(values) & table[name].notna().to_numpy()
    row = int(bad.argmax())
    expect(not bad.any(), f"{name}, row {row}", table[name].iloc[row], "a number or nothing")
    return values


def _layout(
    ends: Array,
    codes: Sequence["np.ndarray[tuple[int], np.dtype[np.int64]]"],
    levels: Sequence[Sequence[object]],
    table: pd.DataFrame,
    keys: Sequence[str],
) -> tuple[Array, Array]:
    """Low and high ends (participant, cell); infinite where the table has no row."""
    shape = tuple(len(names) for names in levels)
    place = np.ravel_multi_index(list(codes), shape)
    order, n = np.unique(place, return_counts=True)
    if (n > 1).any():
        rows = np.flatnonzero(place == order[n.argmax()])
        row = table.iloc[int(rows[0])]
        cell = ", ".join(f"{name} = {row[name]}" for name in keys[: len(codes)])
        raise InvalidParameter(f"{cell}: found {n.max()} values, expected one in each cell, as bounds have no mean")
    laid = np.tile([-np.inf, np.inf], (int(np.prod(shape)), 1))  # a cell without a row may hold any value
    laid[place] = ends
    low, high = laid.reshape(shape[0], -1, 2).transpose(2, 0, 1)
    return low, high


def _refuse_unknown(design: BoundedDesign) -> None:
    group, is_known = design.data.group, design.data.known
    known = np.stack([is_known[group == g].sum(axis=0) for g in range(len(design.groups))])
    for names, n in zip(design.cells(), known.ravel(), strict=True):
        cell = ", ".join(f"{name} = {level}" for name, level in names.items()) or "table"
        found = f"{n} known value{'s' if n != 1 else ''}"
        expected = f"at least {MIN_KNOWN} beside the bounds; leave the condition out"
        expect_defined(n >= MIN_KNOWN, DesignStatus.TOO_FEW_KNOWN, cell, found, expected)


def _standardised(design: BoundedDesign, dependent: str) -> BoundedDesign:
    """About the mean of the known values, in their standard deviations."""
    data = design.data
    size = size_of(data.low[data.known])
    known = data.low[data.known] / size
    centre, scale = float(known.mean()), float(known.std())
    refuse_constant(scale, float(np.abs(known).max()), dependent)
    low, high = ((ends / size - centre) / scale for ends in (data.low, data.high))
    return replace(design, data=replace(data, low=low, high=high), centre=centre * size, scale=scale * size)


MAX_SUBSETS = 200_000

Subset = tuple[tuple[int, ...], ...]
"""Places of the levels of each factor that are kept."""


@dataclass(frozen=True)
class SubDesign:
    """What is kept, and in words what was left out (empty: nothing); `within` names the factors that keep at least two
    levels."""

    table: pd.DataFrame
    within: tuple[str, ...]
    left_out: tuple[str, ...]


@dataclass(frozen=True)
class _Presence:
    """`has` (participant, level of the first factor, ...): whether a table holds a value there."""

    table: pd.DataFrame
    within: Sequence[str]
    subject: str
    subjects: list[Any]
    levels: Sequence[Sequence[object]]
    has: Bools

    @classmethod
    def of(cls, table: pd.DataFrame, dependent: str, within: Sequence[str], subject: str) -> "_Presence":
        levels = [sorted(table[name].unique()) for name in within]
        axes = [sorted(table[subject].unique()), *levels]
        has = np.zeros([len(names) for names in axes], dtype=bool)
        present = table[table[dependent].notna()]
        columns = zip((subject, *within), axes, strict=True)
        has[tuple([names.index(value) for value in present[column]] for column, names in columns)] = True
        return cls(table, within, subject, axes[0], levels, has)

    def complete(self, chosen: Subset) -> Bools:
        """The participants who have a value at all chosen levels."""
        n = len(self.subjects)
        has_chosen = self.has[np.ix_(range(n), *chosen)]
        return np.asarray(has_chosen.reshape(n, -1).all(axis=1))

    def part(self, chosen: Subset, complete: Bools) -> SubDesign:
        """The table at the chosen levels, of the participants who are `complete`."""
        pairs = list(zip(self.subjects, complete.tolist(), strict=True))
        kept = self.table[self.table[self.subject].isin([code for code, ok in pairs if ok])]
        left_out = [f"participant {code}" for code, ok in pairs if not ok]
        for name, values, places in zip(self.within, self.levels, chosen, strict=True):
            kept = kept[kept[name].isin([values[i] for i in places])]
            left_out += [f"{name} = {values[i]}" for i in range(len(values)) if i not in places]
        factors = tuple(name for name, places in zip(self.within, chosen, strict=True) if len(places) > 1)
        return SubDesign(kept, factors, tuple(left_out))


def largest_complete(table: pd.DataFrame, *, dependent: str, within: Sequence[str], subject: str) -> SubDesign | None:
    """Participants and factor levels that are complete together, with as many values as possible.

    `table` then has a value in every cell. Every combination of subsets of levels is tried (of one level each beyond
    `MAX_SUBSETS`: all levels only); ties go to more participants. None if no three participants share two levels of a
    factor.
    """
    presence = _Presence.of(table, dependent, within, subject)
    ranks: dict[Subset, tuple[int, int]] = {}
    for chosen in _subsets(presence.levels):
        n_complete = int(presence.complete(chosen).sum())
        if n_complete >= MIN_PARTICIPANTS:
            ranks[chosen] = (n_complete * _n_cells(chosen), n_complete)
    if not ranks:
        return None
    best = max(ranks, key=lambda chosen: ranks[chosen])  # of equal choices the first
    return presence.part(best, presence.complete(best))


def largest_known(
    table: pd.DataFrame, *, dependent: str, within: Sequence[str], subject: str, between: str | None, at_least: int
) -> SubDesign | None:
    """The factor levels of which every combination has at least so many known values (in each group of participants),
    as many combinations as possible; all participants are kept. None if no factor keeps two levels."""
    presence = _Presence.of(table, dependent, within, subject)
    subjects, has = presence.subjects, presence.has
    by_subject = table.drop_duplicates(subject).set_index(subject)
    group = np.zeros(len(subjects)) if between is None else pd.factorize(by_subject.loc[subjects, between])[0]
    n_known = np.stack([has[group == g].sum(axis=0) for g in np.unique(group)]).min(axis=0)
    subsets = _subsets(presence.levels)
    held = [chosen for chosen in subsets if n_known[np.ix_(*chosen)].min() >= at_least]
    if not held:
        return None
    everybody = np.ones(len(subjects), dtype=bool)
    return presence.part(max(held, key=_n_cells), everybody)  # of equal choices the first


def _n_cells(chosen: Subset) -> int:
    return int(np.prod([len(places) for places in chosen]))


def _subsets(levels: Sequence[Sequence[object]]) -> list[Subset]:
    """Those in which a factor keeps two levels."""
    # Floats: the number of subsets may pass any integer of numpy's.
    n_subsets = np.prod([2.0 ** len(names) - 1 for names in levels])
    if n_subsets > MAX_SUBSETS:
        return [tuple(tuple(range(len(names))) for names in levels)]
    by_factor = [_selections(len(names)) for names in levels]
    return [chosen for chosen in product(*by_factor) if _n_cells(chosen) > 1]


def _selections(n: int) -> list[tuple[int, ...]]:
    """Some of n places, the largest selections first: of equal choices the first is taken."""
    return [places for size in range(n, 0, -1) for places in combinations(range(n), size)]
