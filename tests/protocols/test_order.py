"""Orders of conditions: balance, completeness, purity."""

import itertools
import math
from collections import Counter

from hypothesis import given, strategies as st

from tactometry.protocols.order import Crossing, n_orders, williams_square


def counterbalanced(factors, number):
    """Return a participant's cells with Williams squares for every factor."""
    return Crossing(factors, dict.fromkeys(factors, "williams")).cells(number - 1, None)


def chunks(values, size):
    return [values[n : n + size] for n in range(0, len(values), size)]


@given(n=st.integers(2, 14))
def test_each_condition_follows_each_other_equally_often(n):
    pairs = Counter(pair for row in williams_square(n) for pair in itertools.pairwise(row))
    assert len(pairs) == n * (n - 1)
    assert len(set(pairs.values())) == 1


@given(n=st.integers(1, 14))
def test_each_condition_stands_equally_often_in_each_position(n):
    rows = williams_square(n)
    places = Counter((position, item) for row in rows for position, item in enumerate(row))
    assert set(places.values()) == {len(rows) // n}
    assert len(rows) == n_orders("williams", n)


@given(sizes=st.lists(st.integers(1, 5), min_size=1, max_size=3), number=st.integers(1, 100))
def test_every_cell_comes_once(sizes, number):
    factors = {f"factor_{n}": list(range(size)) for n, size in enumerate(sizes)}
    cells = counterbalanced(factors, number)
    assert len({tuple(cell.items()) for cell in cells}) == len(cells) == math.prod(sizes)


def test_the_outer_factor_changes_slowest():
    cells = counterbalanced({"force_n": [0.5, 1.5], "frequency_hz": [30, 60, 120]}, 1)
    assert [cell["force_n"] for cell in cells] == [0.5] * 3 + [1.5] * 3


def test_outer_orders_are_balanced_over_full_square():
    orders = Counter(
        tuple(dict.fromkeys(cell["force_n"] for cell in counterbalanced({"force_n": [1, 2, 3]}, number)))
        for number in range(1, 13)
    )
    assert set(orders.values()) == {2}


@given(
    rules=st.tuples(*[st.sampled_from(["williams", "complete", "fixed"])] * 2),
    sizes=st.tuples(st.integers(1, 4), st.integers(2, 3)),
)
def test_orders_of_two_factors_are_fully_crossed(rules, sizes):
    slow, fast = (n_orders(rule, size) for rule, size in zip(rules, sizes, strict=True))
    factors = {"slow": list(range(sizes[0])), "fast": list(range(sizes[1]))}
    crossing, orders = Crossing(factors, dict(zip(factors, rules, strict=True))), Counter()
    for row in range(slow * fast):
        for place, cells in enumerate(chunks(crossing.cells(row, None), sizes[1])):
            orders[place, cells[0]["slow"], tuple(cell["fast"] for cell in cells)] += 1
    assert len({order for *_, order in orders}) == fast
    assert len(orders) == len({key[:2] for key in orders}) * fast
    assert len(set(orders.values())) == 1


def test_order_follows_file_without_counterbalancing():
    cells = Crossing({"a": [1, 2], "b": [3, 4]}).cells(6, None)
    assert cells == [{"a": 1, "b": 3}, {"a": 1, "b": 4}, {"a": 2, "b": 3}, {"a": 2, "b": 4}]
