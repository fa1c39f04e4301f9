"""Samples that a signal accepts and refuses."""

import numpy as np
import pytest
from numpy.ma import masked

from tactometry.errors import InvalidParameter
from tactometry.signal import Signal

REFUSED = {
    "complex": (np.array([[1.0 + 0j]]), "values of type complex128"),
    "complex number in a list": ([[1.0, 2j]], "values of type complex128"),
    "masked": (np.ma.array([[1.0, 2.0]], mask=[[False, True]]), "a masked array"),
    "masked without a mask": (np.ma.array([[1.0]]), "a masked array"),
    "masked channel": ([np.ma.array([1.0, 2.0], mask=[False, True])], "a masked array"),
    "masked sample": ([[1.0, masked]], "a masked array"),
    "text": (np.array([["1"]]), "values of type <U1"),
    "text among numbers": ([[1.0, "2"]], "values of type <U32"),
    "bytes": (np.array([[b"1"]]), r"values of type \|S1"),
    "date": (np.array([["2020-01-01"]], dtype="M8[s]"), r"values of type datetime64\[s\]"),
    "interval": (np.array([[3]], dtype="m8[s]"), r"values of type timedelta64\[s\]"),
    "structured": (np.zeros((1, 2), dtype=[("a", float), ("b", float)]), r"values of type \[\('a', '<f8'\), \('b',"),
    "raw": (np.zeros((1, 2), dtype="V8"), r"values of type \|V8"),
    "objects": (np.array([[1.0]], dtype=object), "values of type object"),
    "number beyond a double": ([[10**400]], "values of type object"),
    "None": (None, "values of type object"),
    "rows of two lengths": ([[1.0, 2.0], [3.0]], "rows that do not form an array"),
}


@pytest.mark.parametrize("kind", REFUSED)
@pytest.mark.filterwarnings("error")
def test_signal_refuses_samples_that_are_not_real(kind):
    samples, found = REFUSED[kind]
    with pytest.raises(InvalidParameter, match=rf"^Signal\.samples: found {found}.*, expected real numbers"):
        Signal(samples, 1000.0, "V")


@pytest.mark.parametrize("dtype", ["?", "u1", "i2", "i8", "f2", "f4", ">f8", "longdouble"])
def test_signal_converts_real_samples(dtype):
    made = Signal(np.array([[0, 1, 1]], dtype=dtype), 1000.0, "V")
    assert made.samples.dtype == np.float64
    assert made.samples.tolist() == [[0.0, 1.0, 1.0]]


@pytest.mark.filterwarnings("error")
@pytest.mark.skipif(np.finfo(np.longdouble).max == np.finfo(float).max, reason="longdouble is double here")
def test_signal_refuses_long_float_beyond_double():
    with pytest.raises(InvalidParameter, match=r"^Signal\.samples\[0, 1\]: found inf, expected a finite number"):
        Signal(np.array([[0.0, 1e300]], dtype=np.longdouble) ** 2, 1000.0, "V")
