"""Array types, and operations on arrays."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
IntArray = NDArray[np.int64]
IndexArray = NDArray[np.intp]


def real_product(real: FloatArray, numbers: ComplexArray) -> ComplexArray:
    """Multiply a real by a complex matrix without copying the real one."""
    return np.asarray(real @ np.ascontiguousarray(numbers).view(float)).view(complex)


REAL: Final = (3, 5)
COMPLEX: Final = (3, 5, 7, 11)


def fast_length(n: int, odd_factors: Sequence[int] = REAL) -> int:
    """Return the least number >= `n` with factors 2 and `odd_factors` only.

    >>> fast_length(13), fast_length(13, COMPLEX)
    (15, 14)
    """
    odd = [1]
    for factor in odd_factors:
        odd = [
            product * factor**k for product in odd for k in range(n.bit_length()) if product * factor**k < factor * n
        ]
    return min(product << (-(-n // product) - 1).bit_length() for product in odd)
