"""Tests of signal detection measures (science 11.3) and inverses."""

import re

import numpy as np
import pytest
from examples import examples
from hypothesis import given, strategies as st
from scipy.special import ndtri

from tactometry.analysis.tasks.signal_detection import (
    forced_choice_chance,
    forced_choice_sensitivity,
    yes_no_sensitivity,
)
from tactometry.errors import InvalidParameter


@pytest.mark.parametrize(
    ("rate", "values"),
    [(0.75, (0.95387, 1.4338, 1.6822)), (0.70711, (0.7707, 1.2647, 1.5191)), (0.79370, (1.1587, 1.6232, 1.8650))],
)
def test_published_sensitivities_of_forced_choices(rate: float, values: tuple[float, ...]) -> None:
    found = [forced_choice_sensitivity(rate, m) for m in (2, 3, 4)]
    assert found == pytest.approx(list(values), abs=1e-4)


def test_published_chances_at_unit_sensitivity() -> None:
    found = [forced_choice_chance(1.0, m) for m in (2, 3, 4)]
    assert found == pytest.approx([0.76025, 0.63370, 0.55203], abs=5e-6)


def test_log_linear_rule_of_perfect_answers() -> None:
    found = yes_no_sensitivity(20, 20, 0, 20)
    assert (found.d_prime, found.criterion) == (pytest.approx(3.9615, abs=5e-5), pytest.approx(0.0, abs=1e-12))


def test_lenient_observer_has_negative_criterion() -> None:
    found = yes_no_sensitivity(19, 20, 9, 20)
    assert found.criterion == pytest.approx(-(ndtri(19.5 / 21) + ndtri(9.5 / 21)) / 2)
    assert found.criterion < 0


@given(rate=st.floats(0.01, 0.999))
@examples(30)
def test_two_alternatives_have_a_closed_form(rate: float) -> None:
    """d' = sqrt(2) z(Pc)."""
    assert forced_choice_sensitivity(rate, 2) == pytest.approx(np.sqrt(2) * ndtri(rate), abs=1e-9)


@given(d=st.floats(-2, 5), m=st.integers(2, 8))
@examples(30)
def test_sensitivity_inverts_percent_correct(d: float, m: int) -> None:
    assert forced_choice_sensitivity(forced_choice_chance(d, m), m) == pytest.approx(d, abs=1e-6)


@given(m=st.integers(2, 10))
def test_zero_sensitivity_has_chance_level(m: int) -> None:
    assert forced_choice_chance(0.0, m) == pytest.approx(1 / m, rel=1e-10)


@given(hits=st.integers(0, 30), alarms=st.integers(0, 30))
def test_mirrored_answers_negate_the_criterion(hits: int, alarms: int) -> None:
    here, mirrored = yes_no_sensitivity(hits, 30, alarms, 30), yes_no_sensitivity(30 - alarms, 30, 30 - hits, 30)
    assert mirrored.d_prime == pytest.approx(here.d_prime, abs=1e-12)
    assert mirrored.criterion == pytest.approx(-here.criterion, abs=1e-12)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: yes_no_sensitivity(3, 2, 0, 5), "n_hits: found 3, expected a count from 0 to n_signals (2)"),
        (lambda: yes_no_sensitivity(-1, 2, 0, 5), "n_hits: found -1, expected a count from 0 to n_signals (2)"),
        (lambda: yes_no_sensitivity(1, 2, 0, 0), "n_noises: found 0, expected at least 1"),
        (lambda: forced_choice_chance(1.0, 1), "n_alternatives: found 1, expected a whole number from 2"),
        (lambda: forced_choice_chance(np.inf, 2), "d_prime: found inf, expected a finite number"),
        (lambda: forced_choice_sensitivity(1.0, 3), "rate_correct: found 1.0, expected a rate between "),
    ],
)
def test_impossible_arguments_are_rejected(call, message: str) -> None:
    with pytest.raises(InvalidParameter, match=f"^{re.escape(message)}"):
        call()
