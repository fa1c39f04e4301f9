"""Sequential sampling: batches of studies until powers are precise."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

from ..harness import share_interval
from ..workers import Spread
from .design import Case, PowerDesign
from .replicate import Row, replicate

EXCLUDED_AT: Final = 0.999
"""Sampling stops when an interval with this coverage excludes the target. An interval of 95 % would exclude it by
chance too often, as it is checked after every batch."""


def is_settled(n_yes: int, n: int, precision: float, target: float | None) -> bool:
    """Return True if a share is precise enough or excludes the target.

    >>> is_settled(40, 40, 0.05, 0.8), is_settled(32, 40, 0.05, 0.8), is_settled(10, 40, 0.05, 0.8)
    (True, False, True)
    """
    low, high = share_interval(n_yes, n)
    if (high - low) / 2 <= precision:
        return True
    if target is None:
        return False
    least, most = share_interval(n_yes, n, EXCLUDED_AT)
    return not least <= target <= most


@dataclass(frozen=True)
class Batch:
    """Studies of one case, numbered from `first` to below `end`."""

    case: Case
    first: int
    end: int

    @property
    def name(self) -> str:
        """Stem of the batch's file name. Names sort by number within a case."""
        return f"{self.case.name}_{self.first:07d}"


class Significances:
    """Numbers of simulated and of significant studies of a case."""

    def __init__(self, design: PowerDesign, case: Case) -> None:
        self._design, self._case = design, case
        self._n_yes: dict[int, int] = defaultdict(int)
        self.n = 0

    def add(self, rows: Iterable[Row], n: int) -> None:
        self.n += n
        for row in rows:
            self._n_yes[row.n_participants] += row.significant

    @property
    def are_settled(self) -> bool:
        """True if all shares are settled. False positives have no target."""
        if self.n >= self._design.most:
            return True
        target = self._design.target if self._case.has_effect else None
        precision = self._design.precision
        return self.n > 0 and all(
            is_settled(self._n_yes[n], self.n, precision, target) for n in self._design.participants
        )


Kept = Callable[[Batch], tuple[Row, ...] | None]
"""Function that returns the stored rows of a batch, or None."""
Keep = Callable[[Batch, Sequence[Row]], None]
Simulate = Callable[[PowerDesign, Batch, Spread], Iterable[Row]]


def sample(
    design: PowerDesign,
    spread: Spread,
    kept: Kept = lambda batch: None,
    keep: Keep = lambda batch, rows: None,
    simulate: Simulate | None = None,
) -> Iterator[tuple[Batch, tuple[Row, ...]]]:
    """Yield the batches of each case with their rows, reusing stored ones.

    The batches depend only on the design.
    """
    for case in design.cases:
        counts = Significances(design, case)
        while not counts.are_settled:
            batch = Batch(case, counts.n, min(counts.n + design.batch, design.most))
            rows = kept(batch)
            if rows is None:
                rows = tuple((simulate or simulated)(design, batch, spread))
                keep(batch, rows)
            counts.add(rows, batch.end - batch.first)
            yield batch, rows


def simulated(design: PowerDesign, batch: Batch, spread: Spread) -> Iterator[Row]:
    """Yield the rows of a batch."""
    for rows in spread(partial(replicate, design, batch.case), range(batch.first, batch.end)):
        yield from rows
