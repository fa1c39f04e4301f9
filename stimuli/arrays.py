"""What arrays hold."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
IntArray = NDArray[np.int64]
IndexArray = NDArray[np.intp]


def real_product(real: FloatArray, numbers: ComplexArray) -> ComplexArray:
    """A product of a real and a complex matrix, without making the real one complex."""
    return np.asarray(real @ np.ascontiguousarray(numbers).view(float)).view(complex)
