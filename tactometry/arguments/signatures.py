"""A signature as `help` shows it: names of annotations, and not what they stand for, which fills a screen."""

import inspect
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .annotations import (
    Matrix,
    NotNegative,
    NotNegativeArray,
    Positive,
    PositiveArray,
    PositiveWhole,
    Unbounded,
    UnboundedArray,
    UnboundedComplex,
    Vector,
)

ARRAY = "NDArray[float64]"
NAMES: dict[Any, str] = {
    **dict.fromkeys((ArrayLike, UnboundedArray, PositiveArray, NotNegativeArray), "ArrayLike"),
    **dict.fromkeys((NDArray[np.float64], Vector, Matrix), ARRAY),
    **dict.fromkeys((NDArray[np.complex128], UnboundedComplex), "NDArray[complex128]"),
    **dict.fromkeys((Unbounded, Positive, NotNegative), "float"),
    PositiveWhole: "int",
}


def in_short(signature: inspect.Signature) -> inspect.Signature:
    """With the names of long annotations.

    >>> def force_n(voltage_v: ArrayLike, area_m2: Positive = 1e-4) -> NDArray[np.float64]: ...
    >>> str(in_short(inspect.signature(force_n)))
    "(voltage_v: 'ArrayLike', area_m2: 'float' = 0.0001) -> 'NDArray[float64]'"
    """
    named = [each.replace(annotation=_name(each.annotation)) for each in signature.parameters.values()]
    return signature.replace(parameters=named, return_annotation=_name(signature.return_annotation))


def _name(annotation: Any) -> Any:
    return NAMES.get(annotation, annotation)
