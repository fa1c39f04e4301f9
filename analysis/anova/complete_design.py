"""The largest part of a within-participant design that has holes: complete, or with values enough for a model."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np
import pandas as pd

from ..arrays import Bools

MAX_SUBSETS = 200_000
MIN_PARTICIPANTS = 3


@dataclass(frozen=True)
class SubDesign:
    """What is kept, and in words what was left out (empty: nothing); `within` names the factors that keep at least two
    levels."""

    table: pd.DataFrame
    within: tuple[str, ...]
    left_out: tuple[str, ...]


def largest_complete(table: pd.DataFrame, *, dependent: str, within: Sequence[str], subject: str) -> SubDesign | None:
    """Participants and factor levels that are complete together, with as many values as possible.

    `table` then has a value in every cell. Every combination of subsets of levels is tried (of one level each beyond
    `MAX_SUBSETS`: all levels only); ties go to more participants. None if no three participants share two levels of a
    factor.
    """
    levels = [sorted(table[name].unique()) for name in within]
    subjects = sorted(table[subject].unique())
    has = _presence(table, dependent, within, subject, levels, subjects)
    best: tuple[int, int, int, tuple[tuple[int, ...], ...]] | None = None
    for chosen in _subsets(levels):
        if all(len(places) < 2 for places in chosen):
            continue
        complete = has[np.ix_(range(len(subjects)), *chosen)].reshape(len(subjects), -1).all(axis=1)
        n_complete, n_cells = int(complete.sum()), int(np.prod([len(places) for places in chosen]))
        rank = (n_complete * n_cells, n_complete, n_cells, chosen)
        # Without the levels themselves: of equal choices the first stays.
        if n_complete >= MIN_PARTICIPANTS and (best is None or rank[:3] > best[:3]):
            best = rank
    return None if best is None else _kept(table, within, subject, levels, subjects, has, best[3])


def largest_known(
    table: pd.DataFrame, *, dependent: str, within: Sequence[str], subject: str, between: str | None, at_least: int
) -> SubDesign | None:
    """The factor levels of which every combination has at least so many known values (in each group of participants),
    as many combinations as possible; all participants are kept. None if no factor keeps two levels."""
    levels = [sorted(table[name].unique()) for name in within]
    subjects = sorted(table[subject].unique())
    has = _presence(table, dependent, within, subject, levels, subjects)
    by_subject = table.drop_duplicates(subject).set_index(subject)
    group = np.zeros(len(subjects)) if between is None else pd.factorize(by_subject.loc[subjects, between])[0]
    n_known = np.stack([has[group == g].sum(axis=0) for g in np.unique(group)]).min(axis=0)
    sizes = {
        chosen: int(np.prod([len(places) for places in chosen]))
        for chosen in _subsets(levels)
        if max(map(len, chosen)) > 1 and n_known[np.ix_(*chosen)].min() >= at_least
    }
    if not sizes:
        return None
    everybody = np.ones_like(has)
    return _kept(table, within, subject, levels, subjects, everybody, max(sizes, key=lambda chosen: sizes[chosen]))


def _presence(
    table: pd.DataFrame,
    dependent: str,
    within: Sequence[str],
    subject: str,
    levels: Sequence[Sequence[object]],
    subjects: Sequence[object],
) -> Bools:
    """Whether there is a value, of shape (participant, level of the first factor, ...)."""
    axes = [subjects, *levels]
    has = np.zeros([len(names) for names in axes], dtype=bool)
    present = table[table[dependent].notna()]
    columns = zip((subject, *within), axes, strict=True)
    has[tuple([names.index(value) for value in present[column]] for column, names in columns)] = True
    return has


def _subsets(levels: Sequence[Sequence[object]]) -> "list[tuple[tuple[int, ...], ...]]":
    # Floats: the number of subsets may pass any integer of numpy's.
    n_subsets = np.prod([2.0 ** len(names) - 1 for names in levels])
    if n_subsets > MAX_SUBSETS:
        return [tuple(tuple(range(len(names))) for names in levels)]
    return list(product(*(_subsets_of(len(names)) for names in levels)))


def _subsets_of(n: int) -> list[tuple[int, ...]]:
    """The largest first."""
    return [places for size in range(n, 0, -1) for places in combinations(range(n), size)]


def _kept(
    table: pd.DataFrame,
    within: Sequence[str],
    subject: str,
    levels: Sequence[Sequence[object]],
    subjects: Sequence[object],
    has: Bools,
    chosen: tuple[tuple[int, ...], ...],
) -> SubDesign:
    complete = np.asarray(has[np.ix_(range(len(subjects)), *chosen)].reshape(len(subjects), -1).all(axis=1)).tolist()
    kept = table[table[subject].isin([code for code, ok in zip(subjects, complete, strict=True) if ok])]
    left_out = [f"participant {code}" for code, ok in zip(subjects, complete, strict=True) if not ok]
    for name, values, places in zip(within, levels, chosen, strict=True):
        kept = kept[kept[name].isin([values[i] for i in places])]
        left_out += [f"{name} = {values[i]}" for i in range(len(values)) if i not in places]
    factors = tuple(name for name, places in zip(within, chosen, strict=True) if len(places) > 1)
    return SubDesign(kept, factors, tuple(left_out))
