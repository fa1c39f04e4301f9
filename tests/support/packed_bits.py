"""Signals of packed one-bit outputs."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tactometry.signal import Signal

RATE_HZ = 1000.0

bits = st.sampled_from([(-1, 1), (-1, 0, 1)]).flatmap(
    lambda values: arrays(
        np.int8, st.tuples(st.integers(1, 70), st.integers(0, 50)), elements=st.sampled_from(values)
    ).filter(lambda drawn: drawn.size == 0 or drawn.any())
)
"""Random pulses, some with zeros; an all-zero pattern carries no signal."""


def volts(values):
    return Signal(np.array(values, dtype=float), RATE_HZ, "V")
