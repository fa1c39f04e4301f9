"""Orders of conditions and random streams, as pure functions."""

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar

import numpy as np

from tactometry.arguments.require import expect, one_of, whole

T = TypeVar("T")
LARGEST_PLACE = 2**32 - 1
LARGEST_SEED = 2**128 - 1


def williams_square(n: int) -> list[list[int]]:
    """Return rows in which each condition follows each other one equally often.

    n rows for even n, 2n for odd n (the square and its mirror image). Williams, Aust. J. Sci. Res. A2, 149 (1949).

    >>> williams_square(4)
    [[0, 1, 3, 2], [1, 2, 0, 3], [2, 3, 1, 0], [3, 0, 2, 1]]
    """
    whole("williams_square", lowest=1, n=n)
    # 0, 1, n - 1, 2, n - 2, ...: all steps differ, so that every pair of neighbours occurs once
    zigzag = [(k + 1) // 2 if k % 2 else (n - k // 2) % n for k in range(n)]
    rows = [[(start + step) % n for step in zigzag] for start in range(n)]
    return rows + [row[::-1] for row in rows] if n % 2 and n > 1 else rows


def nth_permutation(n: int, row: int) -> list[int]:
    """Return permutation `row` (modulo n!) of 0..n-1 in lexicographic order.

    >>> [nth_permutation(3, row) for row in range(6)]
    [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]]
    """
    left, order, row = list(range(n)), [], row % math.factorial(n)
    for n_left in range(n, 0, -1):
        index, row = divmod(row, math.factorial(n_left - 1))
        order.append(left.pop(index))
    return order


ORDERS: Mapping[str, Callable[[int, int, np.random.Generator], list[int]]] = {
    "williams": lambda n, row, rng: williams_square(n)[row % n_orders("williams", n)],
    "complete": lambda n, row, rng: nth_permutation(n, row),
    "random": lambda n, row, rng: [int(k) for k in rng.permutation(n)],
    "fixed": lambda n, row, rng: list(range(n)),
}
"""Rules for the order of n levels in a row: balanced for carry-over, all orders in turn, random, as in the file."""


def n_orders(rule: str, n: int) -> int:
    """Return the number of rows after which an order of n levels repeats.

    >>> n_orders("williams", 3), n_orders("complete", 3), n_orders("fixed", 3)
    (6, 6, 1)
    """
    return {"williams": 2 * n if n % 2 and n > 1 else n, "complete": math.factorial(n)}.get(rule, 1)


Nested = Mapping[str, Mapping[T, Mapping[str, Sequence[T]]]]


@dataclass(frozen=True)
class Crossing(Generic[T]):
    """Factors with their levels, the slowest factor first, and their orders.

    - `rules`: One of `ORDERS` for each factor. Factors without a rule are fixed.
    - `nested`: Levels of a faster factor at a level of a slower one, by slower factor, its level, and faster factor.
    """

    factors: Mapping[str, Sequence[T]]
    rules: Mapping[str, str] = field(default_factory=dict)
    nested: Nested[T] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, rule in self.rules.items():
            one_of("plan.orders", rule, ORDERS)
            sizes = self._sizes(name)
            unequal = f"a {rule} order of an unequal design ({' or '.join(map(str, sizes))} levels)"
            is_possible = rule not in ("williams", "complete") or len(sizes) == 1
            equal = "equal numbers of levels; make them equal, or choose random or fixed"
            expect(is_possible, f"plan.orders, {name}", unequal, equal)

    def _sizes(self, name: str) -> list[int]:
        inner = [by_factor for by_level in self.nested.values() for by_factor in by_level.values()]
        return sorted({len(self.factors[name]), *(len(levels[name]) for levels in inner if name in levels)})

    def cells(self, row: int, rng: np.random.Generator) -> list[dict[str, T]]:
        """Return all combinations in the order of a row (from 0).

        Each faster factor moves to its next row whenever it restarts, so that carry-over is also balanced within a
        participant. It skips one more row after each round of the slower factor's orders. So every order of one
        factor meets every order of the other equally often.
        """
        return list(self._inner(list(self.factors), {}, row, rng))

    def _inner(
        self, names: Sequence[str], outer: Mapping[str, T], row: int, rng: np.random.Generator
    ) -> Iterator[dict[str, T]]:
        if not names:
            yield dict(outer)
            return
        name, *faster = names
        given = (self.nested.get(factor, {}).get(level, {}).get(name) for factor, level in outer.items())
        levels = next((levels for levels in given if levels is not None), self.factors[name])
        rule = self.rules.get(name, "fixed")
        order = ORDERS[rule](len(levels), row, rng)
        n_round, turn = divmod(row, n_orders(rule, len(levels)))
        for position, index in enumerate(order):
            inner_row = n_round + turn * len(order) + position
            yield from self._inner(faster, {**outer, name: levels[index]}, inner_row, rng)


def combinations(factors: Mapping[str, Sequence[T]]) -> list[dict[str, T]]:
    """Return all combinations, the last factor fastest."""
    return [dict(zip(factors, cell, strict=True)) for cell in itertools.product(*factors.values())]


def stream(seed: int, *place: int) -> np.random.Generator:
    """Return the random stream of a position in nested loops: study, track.

    The stream belongs to this position only and does not depend on the order of work. Each number of the position is
    one word of the key, and the seed at most four.

    >>> float(stream(1, 0, 7).random()) == float(stream(1, 0, 7).random()) != float(stream(1, 7, 0).random())
    True
    """
    whole("stream", lowest=0, highest=LARGEST_SEED, seed=seed)
    for number in place:
        whole("stream", lowest=0, highest=LARGEST_PLACE, place=number)
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=place))
