"""Sensitivity shape and the rule of the component furthest above threshold."""

import numpy as np
import pytest
from hard_cases import exact_case, hard_case
from hypothesis import given, strategies as st

from tactometry.errors import InvalidParameter
from tactometry.stimuli.perception import Components, components, sensation_level_db, sensitivity_db


def test_sensitivity_shape() -> None:
    expected_db = [62.00, 39.04, 30.31, 17.11, 12.27, 0.06, 20.60, 23.69]
    found_db = sensitivity_db([0, 40, 60, 100, 120, 240, 480, 500])
    np.testing.assert_allclose(found_db, expected_db, rtol=0, atol=5.1e-3)


def test_the_cap_is_reached_at_780_hz() -> None:
    assert sensitivity_db(780.74) < 77
    assert sensitivity_db(780.76) == 77


@given(st.floats(0, 1e6))
def test_nothing_is_felt_better_than_250_hz(frequency_hz: float) -> None:
    assert sensitivity_db(frequency_hz) >= sensitivity_db(250.0) == 0


@given(frequency_hz=st.floats(20, 900), amplitude=st.floats(1e-9, 1e9), offset=st.floats(-10, 10))
def test_the_amplitude_of_a_steady_tone_is_read_within_four_parts_in_a_thousand(
    frequency_hz: float, amplitude: float, offset: float
) -> None:
    t_s = np.arange(4000) / 4000
    found = components(amplitude * (offset + np.sin(2 * np.pi * frequency_hz * t_s)), 4000.0)
    strongest = np.argmax(found.amplitudes)
    read = found.amplitudes[strongest]
    hard_case("a tone of 1e-9 to 1e9 beside a constant", read, amplitude, 4e-3, against="its amplitude")
    assert abs(found.frequencies_hz[strongest] - frequency_hz) <= 0.004


def test_the_component_furthest_above_threshold_decides() -> None:
    parts = Components(np.array([40.0, 250.0]), np.array([1.0, 0.05]))
    levels_db = [-39.04, 20 * np.log10(0.05)]
    assert sensation_level_db(parts, 1.0) == pytest.approx(max(levels_db), abs=0.01)


@pytest.mark.parametrize("samples", [[], [1.0], np.zeros(100), np.full(100, 3.7)])
def test_silence_and_constants_are_not_felt(samples: list[float]) -> None:
    assert sensation_level_db(components(samples, 1000.0), 1.0) == -np.inf
    exact_case("records of no sample, of one, of a constant", against="not felt")


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: sensitivity_db(-1.0), "frequency_hz: found -1.0, expected a finite number, at least 0"),
        (
            lambda: components(np.zeros((2, 3)), 1.0),
            "components.samples: found shape (2, 3), expected (n_samples,) finite numbers",
        ),
        (
            lambda: sensation_level_db(Components(np.ones(1), np.ones(1)), 0.0),
            "sensation_level_db.reference: found 0.0, expected a finite number above 0",
        ),
    ],
)
def test_bad_input_is_one_clear_sentence(call, message: str) -> None:
    with pytest.raises(InvalidParameter) as caught:
        call()
    assert str(caught.value) == message
