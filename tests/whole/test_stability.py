"""docs/explanation/stability.md matches the hard cases of the tests."""

import math
from collections import Counter

import pytest
from hard_cases import PAGE, ROOMS, SEEN, cases, exact_case, hard_case, page, stated


@pytest.fixture
def unseen():
    before = dict(SEEN)
    yield
    SEEN.clear()
    SEEN.update(before)


def test_stability_page_is_up_to_date() -> None:
    assert page(stated()) == PAGE.read_text(encoding="utf-8"), "run make stability"
    assert set(stated()) == {case.name for case in cases()}, "run make stability"


def test_case_names_are_unique() -> None:
    assert [name for name, n in Counter(case.name for case in cases()).items() if n > 1] == []


def test_every_case_has_reference_and_package_has_cases() -> None:
    assert all(case.name and case.against for case in cases())
    assert {case.room for case in cases()} == set(ROOMS.values())


@pytest.mark.parametrize("found", [1.2, math.nan, math.inf])
def test_an_error_above_its_bound_fails(unseen, found) -> None:
    with pytest.raises(AssertionError, match="a new case: found an error of .*, the bound is 0.1"):
        hard_case("a new case", [1.0, found], [1.0, 1.0], 0.1, against="one")


def test_hard_case_keeps_worst_relative_error(unseen) -> None:
    hard_case("a new case", [1.0, 0.0, 11.0], [1.0, 0.0, 10.0], 1.0, against="one")
    assert SEEN["a new case"] == pytest.approx(0.1)
    hard_case("a new case", 1e-3, 0.0, 1.0, against="zero", floor=0.01)
    assert SEEN["a new case"] == pytest.approx(0.1)
    exact_case("another", against="equality")
    assert SEEN["another"] == 0


def test_hundredfold_error_fails(unseen, monkeypatch) -> None:
    monkeypatch.setattr("hard_cases.stated", lambda: {"a new case": 1e-6})
    hard_case("a new case", 1 + 9e-5, 1.0, 1e-2, against="one")
    hard_case("a new case", 1 + 2e-4, 1.0, 1.0, against="one")
    with pytest.raises(AssertionError, match="run make stability"):
        hard_case("a new case", 1 + 2e-4, 1.0, 1e-2, against="one")
