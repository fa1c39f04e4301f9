"""Array types of the estimators, and linear algebra on them."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]
Indices = NDArray[np.int64]
Which = Indices | Bools | slice
RELATIVE_ZERO = 1e-12
"""A spread below this fraction of the largest value is rounding error."""
FLATTEST = 1e-8


def size_of(values: Array) -> float:
    """Return the largest power of two not above the largest value.

    >>> size_of(np.array([-5.0, 3.0])), size_of(np.array([1e308])) < 1e308
    (4.0, True)
    """
    return float(np.exp2(np.frexp(np.abs(values).max())[1] - 1.0))


class StatusWithNote(StrEnum):
    """Status of a fit with a note: ``NAME = "word", "note"``."""

    note: str

    def __new__(cls, word: str, note: str = "") -> Self:
        status = str.__new__(cls, word)
        status._value_ = word
        status.note = note
        return status


@dataclass(frozen=True)
class Rows:
    """Arrays with one row per fit; other fields apply to all rows."""

    def _of_each(self, rule: Callable[..., Any], *others: Self) -> Self:
        columns = ([getattr(rows, field.name) for rows in (self, *others)] for field in fields(self))
        kept = (rule(*column) if isinstance(column[0], np.ndarray | Rows) else column[0] for column in columns)
        return type(self)(*kept)

    def __getitem__(self, which: Which) -> Self:
        return self._of_each(lambda values: values[which])

    def joined(self, other: Self) -> Self:
        """Return the rows of this object followed by those of `other`."""
        return self._of_each(lambda *both: np.concatenate(both), other)

    def replaced(self, places: Indices, other: Self) -> Self:
        """Return a copy with the rows at `places` replaced by those of `other`."""

        def merged(ours: Any, theirs: Any) -> Any:
            if isinstance(ours, Rows):
                return ours.replaced(places, theirs)
            changed = ours.copy()
            changed[places] = theirs
            return changed

        return self._of_each(merged, other)

    def where(self, chosen: Bools, other: Self) -> Self:
        """Return rows of this object where `chosen` (n,), else of `other`."""

        def merged(ours: Any, theirs: Any) -> Any:
            if isinstance(ours, Rows):
                return ours.where(chosen, theirs)
            return np.where(chosen.reshape(-1, *[1] * (ours.ndim - 1)), ours, theirs)

        return self._of_each(merged, other)


@dataclass(frozen=True)
class Expansion(Rows):
    """Value (n,), gradient (n, 4) and Hessian (n, 4, 4) of a log density."""

    value: Array
    gradient: Array
    hessian: Array

    def __add__(self, other: "Expansion") -> "Expansion":
        return Expansion(self.value + other.value, self.gradient + other.gradient, self.hessian + other.hessian)


def symmetric_inverse(matrix: Array) -> Array:
    """Invert symmetric matrices (..., p, p), made positive definite.

    Matrices are scaled to a diagonal of 1. Each eigenvalue is then replaced by its absolute value, at least `FLATTEST`.
    """
    scale = np.sqrt(np.maximum(np.abs(np.diagonal(matrix, axis1=-2, axis2=-1)), FLATTEST))
    outer = scale[..., :, None] * scale[..., None, :]
    values, vectors = np.linalg.eigh(matrix / outer)
    inverse = (vectors / np.maximum(np.abs(values), FLATTEST)[..., None, :]) @ vectors.mT / outer
    return np.asarray((inverse + inverse.mT) / 2)


def lay_out(cluster: Indices, *columns: Array, n_clusters: int = 0) -> list[Array]:
    """Arrange rows (n_rows, ...) by cluster, as (n_clusters, n_slots, ...).

    Unused slots are 0. Clusters without rows are empty. Without `n_clusters`, the largest index sets the number of
    clusters.
    """
    order = np.argsort(cluster, kind="stable")  # stable: the slots of a cluster keep the order of its rows
    sizes = np.bincount(cluster, minlength=n_clusters)
    slot = np.arange(len(cluster)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    laid = []
    for column in columns:
        whole = np.zeros((len(sizes), sizes.max(), *column.shape[1:]))
        whole[cluster[order], slot] = column[order]
        laid.append(whole)
    return laid
