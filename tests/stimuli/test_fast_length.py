"""Lengths of fast transforms are those of scipy."""

import pytest
from hypothesis import example, given, strategies as st
from scipy.fft import next_fast_len

from tactometry.stimuli.arrays import COMPLEX, REAL, fast_length


@pytest.mark.parametrize(("factors", "real"), [(REAL, True), (COMPLEX, False)])
@given(n=st.integers(1, 10**8))
@example(n=1)
@example(n=2)
@example(n=7)
@example(n=3**15)
def test_fast_length_matches_scipy(factors: tuple[int, ...], real: bool, n: int) -> None:
    assert fast_length(n, factors) == next_fast_len(n, real=real)
