"""Components of a record, and the most detectable of them."""

import numpy as np
import pytest
from hard_cases import exact_case, hard_case
from hypothesis import given, strategies as st

from tactometry.errors import InvalidParameter
from tactometry.stimuli.perception import sensation_level_db
from tactometry.stimuli.perception.detection import Components, components


@given(frequency_hz=st.floats(20, 900), amplitude=st.floats(1e-9, 1e9), offset=st.floats(-10, 10))
def test_steady_tone_amplitude_is_accurate(frequency_hz: float, amplitude: float, offset: float) -> None:
    t_s = np.arange(4000) / 4000
    found = components(amplitude * (offset + np.sin(2 * np.pi * frequency_hz * t_s)), 4000.0)
    strongest = np.argmax(found.amplitudes)
    read = found.amplitudes[strongest]
    hard_case("a tone of 1e-9 to 1e9 beside a constant", read, amplitude, 4e-3, against="its amplitude")
    assert abs(found.frequencies_hz[strongest] - frequency_hz) <= 0.004


def test_the_component_furthest_above_threshold_decides() -> None:
    parts = Components(np.array([40.0, 250.0]), np.array([1.0, 0.05]))
    levels_db = [-29.32, 20 * np.log10(0.05)]
    assert sensation_level_db(parts, 1.0) == pytest.approx(max(levels_db), abs=0.01)
    fainter = Components(parts.frequencies_hz, np.array([1.0, 0.01]))
    assert sensation_level_db(fainter, 1.0) == pytest.approx(levels_db[0], abs=0.01)


@pytest.mark.parametrize("samples", [[], [1.0], np.zeros(100), np.full(100, 3.7)])
def test_silence_and_constants_are_not_felt(samples: list[float]) -> None:
    assert sensation_level_db(components(samples, 1000.0), 1.0) == -np.inf
    exact_case("records of no sample, of one, of a constant", against="not felt")


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: components(np.zeros((2, 3)), 1.0),
         "components.samples: found shape (2, 3), expected (n_samples,) finite numbers"),
        (lambda: sensation_level_db(Components(np.ones(1), np.ones(1)), 0.0),
         "sensation_level_db.reference_m: found 0.0, expected a finite number above 0"),
    ],
)  # fmt: skip
def test_bad_input_is_one_clear_sentence(call, message: str) -> None:
    with pytest.raises(InvalidParameter) as caught:
        call()
    assert str(caught.value) == message
