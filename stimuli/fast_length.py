"""Lengths of transforms that are fast, as scipy's `next_fast_len` gives them, which takes 0.2 s to load."""

from collections.abc import Sequence
from typing import Final

REAL: Final = (3, 5)
COMPLEX: Final = (3, 5, 7, 11)


def fast_length(n: int, odd_factors: Sequence[int] = REAL) -> int:
    """The least number of at least `n` (at least 1) that is made of 2 and of these factors alone.

    >>> fast_length(13), fast_length(13, COMPLEX)
    (15, 14)
    """
    odd = [1]
    for factor in odd_factors:
        odd = [
            product * factor**k for product in odd for k in range(n.bit_length()) if product * factor**k < factor * n
        ]
    return min(product << (-(-n // product) - 1).bit_length() for product in odd)
