"""Signals of packed one-bit outputs."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tactometry.signal import Signal

RATE_HZ = 1000.0

bits = arrays(np.int8, st.tuples(st.integers(1, 70), st.integers(0, 50)), elements=st.sampled_from([-1, 1]))


def volts(values):
    return Signal(np.array(values, dtype=float), RATE_HZ, "V")
