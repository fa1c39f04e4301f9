"""Arrays as the estimators write them: their types, rounding, and a density with its derivatives."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]
Indices = NDArray[np.int64]
Which = Indices | Bools | slice
RELATIVE_ZERO = 1e-12
"""A spread below this part of the values' size is rounding."""


def size_of(values: Array) -> float:
    """The power of two below the largest value: values over it lose no digit, and their squares stay finite.

    >>> size_of(np.array([-5.0, 3.0])), size_of(np.array([1e308])) < 1e308
    (4.0, True)
    """
    return float(np.exp2(np.frexp(np.abs(values).max())[1] - 1.0))


@dataclass(frozen=True)
class Expansion:
    """Value (n,), gradient (n, 4) and Hessian (n, 4, 4) of a log density."""

    value: Array
    gradient: Array
    hessian: Array

    def __add__(self, other: "Expansion") -> "Expansion":
        return Expansion(self.value + other.value, self.gradient + other.gradient, self.hessian + other.hessian)

    def __getitem__(self, which: Which) -> "Expansion":
        return Expansion(self.value[which], self.gradient[which], self.hessian[which])

    def where(self, chosen: Bools, other: "Expansion") -> "Expansion":
        """This one where `chosen` (n,), else the other."""
        return Expansion(
            np.where(chosen, self.value, other.value),
            np.where(chosen[:, None], self.gradient, other.gradient),
            np.where(chosen[:, None, None], self.hessian, other.hessian),
        )
