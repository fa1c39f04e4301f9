"""Orders of conditions: balance, completeness, purity."""

import itertools
from collections import Counter

import pytest
from hypothesis import given, strategies as st

from tactometry.protocols.order import Crossing, n_orders, williams_square


def counterbalanced(factors, number):
    """Return a participant's cells with Williams squares for every factor."""
    return Crossing(factors, dict.fromkeys(factors, "williams")).cells(number - 1, None)


@given(n=st.integers(2, 14))
def test_each_condition_follows_each_other_equally_often(n):
    pairs = Counter(pair for row in williams_square(n) for pair in itertools.pairwise(row))
    assert len(pairs) == n * (n - 1)
    assert len(set(pairs.values())) == 1


def test_one_condition_has_one_row():
    assert williams_square(1) == [[0]]


@given(n=st.integers(1, 14))
def test_each_condition_stands_equally_often_in_each_position(n):
    rows = williams_square(n)
    places = Counter((position, item) for row in rows for position, item in enumerate(row))
    assert set(places.values()) == {len(rows) // n}


@given(sizes=st.lists(st.integers(1, 5), min_size=1, max_size=3), number=st.integers(1, 100))
def test_every_cell_comes_once(sizes, number):
    factors = {f"factor_{n}": list(range(size)) for n, size in enumerate(sizes)}
    cells = counterbalanced(factors, number)
    assert len({tuple(cell.items()) for cell in cells}) == len(cells)
    assert len(cells) == pytest.approx(_product(sizes))


def _product(sizes):
    total = 1
    for size in sizes:
        total *= size
    return total


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
    names = ("slow", "fast")
    factors = {name: list(range(size)) for name, size in zip(names, sizes, strict=True)}
    crossing = Crossing(factors, dict(zip(names, rules, strict=True)))
    n_rows = n_orders(rules[0], sizes[0]) * n_orders(rules[1], sizes[1])
    met = Counter()
    for row in range(n_rows):
        cells = crossing.cells(row, None)
        for place, block in enumerate(_chunks(cells, sizes[1])):
            met[place, block[0]["slow"], tuple(cell["fast"] for cell in block)] += 1
    assert len({order for *_, order in met}) == n_orders(rules[1], sizes[1])
    assert len(met) == len({key[:2] for key in met}) * n_orders(rules[1], sizes[1])
    assert len(set(met.values())) == 1


def _chunks(values, size):
    return [values[n : n + size] for n in range(0, len(values), size)]


@given(n=st.integers(1, 8))
def test_williams_square_has_stated_number_of_rows(n):
    assert len(williams_square(n)) == n_orders("williams", n)


def test_order_follows_file_without_counterbalancing():
    cells = Crossing({"a": [1, 2], "b": [3, 4]}).cells(6, None)
    assert cells == [{"a": 1, "b": 3}, {"a": 1, "b": 4}, {"a": 2, "b": 3}, {"a": 2, "b": 4}]
