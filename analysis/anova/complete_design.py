"""The largest part of a within-participant design that has holes: complete, or with values enough for a model."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any

import numpy as np
import pandas as pd

from ..arrays import Bools

MAX_SUBSETS = 200_000
MIN_PARTICIPANTS = 3
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
        return np.asarray(self.has[np.ix_(range(n), *chosen)].reshape(n, -1).all(axis=1))

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
    best: tuple[tuple[int, int, int], Subset] | None = None
    for chosen in _subsets(presence.levels):
        if all(len(places) < 2 for places in chosen):
            continue
        n_complete, n_cells = int(presence.complete(chosen).sum()), int(np.prod([len(places) for places in chosen]))
        rank = (n_complete * n_cells, n_complete, n_cells)
        # Of equal choices the first stays.
        if n_complete >= MIN_PARTICIPANTS and (best is None or rank > best[0]):
            best = (rank, chosen)
    return None if best is None else presence.part(best[1], presence.complete(best[1]))


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
    sizes = {
        chosen: int(np.prod([len(places) for places in chosen]))
        for chosen in _subsets(presence.levels)
        if max(map(len, chosen)) > 1 and n_known[np.ix_(*chosen)].min() >= at_least
    }
    if not sizes:
        return None
    return presence.part(max(sizes, key=lambda chosen: sizes[chosen]), np.ones(len(subjects), dtype=bool))


def _subsets(levels: Sequence[Sequence[object]]) -> list[Subset]:
    # Floats: the number of subsets may pass any integer of numpy's.
    n_subsets = np.prod([2.0 ** len(names) - 1 for names in levels])
    if n_subsets > MAX_SUBSETS:
        return [tuple(tuple(range(len(names))) for names in levels)]
    return list(product(*(_subsets_of(len(names)) for names in levels)))


def _subsets_of(n: int) -> list[tuple[int, ...]]:
    """The largest first."""
    return [places for size in range(n, 0, -1) for places in combinations(range(n), size)]
