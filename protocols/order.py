"""Orders of conditions that are a pure function of the participant's number."""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import TypeVar

from tactometry.errors import InvalidParameter

T = TypeVar("T")


def williams_square(n: int) -> list[list[int]]:
    """Rows of an order balanced for carry-over: each condition follows each other equally often.

    n rows for even n, 2n for odd n (the square and its mirror image). Williams, Aust. J. Sci. Res. A2, 149 (1949).

    >>> williams_square(4)
    [[0, 1, 3, 2], [1, 2, 0, 3], [2, 3, 1, 0], [3, 0, 2, 1]]

    Raises
    ------
    InvalidParameter
        If `n` is below 1.
    """
    if n < 1:
        raise InvalidParameter(f"williams_square: found {n} conditions, expected at least 1")
    zigzag = [(k + 1) // 2 if k % 2 else (n - k // 2) % n for k in range(n)]
    rows = [[(start + step) % n for step in zigzag] for start in range(n)]
    return rows + [row[::-1] for row in rows] if n % 2 and n > 1 else rows


def counterbalanced(factors: Mapping[str, Sequence[T]], outer_first: Sequence[str], number: int) -> list[dict[str, T]]:
    """All combinations of `factors` in the order of participant `number` (from 1).

    Factors named in `outer_first` change their order with the participant by a Williams square, the first slowest;
    each further one takes its next row whenever it starts anew, so that carry-over is balanced within a session too.
    Factors that are not named follow, in their given order.

    Raises
    ------
    InvalidParameter
        If the number is below 1.
    """
    if number < 1:
        raise InvalidParameter(f"participant number: found {number}, expected a number from 1; give --number")
    names = [*outer_first, *(name for name in factors if name not in outer_first)]
    return [{name: cell[name] for name in factors} for cell in _nested(factors, names, set(outer_first), number - 1)]


def _nested(
    factors: Mapping[str, Sequence[T]], names: Sequence[str], balanced: set[str], row: int
) -> Iterator[dict[str, T]]:
    if not names:
        yield {}
        return
    name, *inner = names
    values = factors[name]
    rows = williams_square(len(values)) if name in balanced else [list(range(len(values)))]
    order = rows[row % len(rows)]
    for position, index in enumerate(order):
        for rest in _nested(factors, inner, balanced, row * len(order) + position):
            yield {name: values[index], **rest}


def crossed(factors: Mapping[str, Sequence[T]]) -> list[dict[str, T]]:
    """All combinations, the last factor fastest."""
    return [dict(zip(factors, cell, strict=True)) for cell in itertools.product(*factors.values())]
