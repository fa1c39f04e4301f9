"""Numbers of text cells. Large columns go through pyarrow; what is not plain is left to a slower reader."""

import numpy as np
import pandas as pd

from ..arrays import Array


def numbers_of(text: "pd.Series[str]") -> "pd.Series[float]":
    """Numbers of text cells, NaN for what is none."""
    numbers = plain_numbers(text)
    return pd.Series(_numbers_of_words(text) if numbers is None else numbers, index=text.index)


def plain_numbers(text: "pd.Series[str]") -> Array | None:
    """Numbers of text cells, NaN for empty ones, if all are numbers.

    >>> plain_numbers(pd.Series(["1.5", "", "-2e3"]))
    array([ 1.5e+00,      nan, -2.0e+03])
    >>> plain_numbers(pd.Series(["1.5", "loud"])) is None
    True
    """
    import pyarrow as pa  # type: ignore[import-untyped,unused-ignore]
    import pyarrow.compute as pc  # type: ignore[import-untyped,unused-ignore]

    try:
        words = pa.array(text, type=pa.string())
        known = pc.if_else(pc.equal(words, ""), None, words)
        numbers = pc.cast(known, pa.float64())
    except (pa.ArrowInvalid, pa.ArrowTypeError, pa.ArrowNotImplementedError):
        return None
    values = numbers.to_numpy(zero_copy_only=False) if isinstance(numbers, pa.Array) else numbers.to_numpy()
    return np.array(values, dtype=np.float64)  # a copy: arrow's own memory may not be written to


def _numbers_of_words(text: "pd.Series[str]") -> Array:
    """Each different text is read once."""
    codes, different = pd.factorize(text)
    words = [word or "nan" for word in different.tolist()]
    # numpy reads "1_000" as a number, as Python does; a table means a word by it.
    try:
        numbers = np.array(words, dtype=np.float64) if not any("_" in word for word in words) else None
    except ValueError:
        numbers = None
    if numbers is None:
        numbers = np.asarray(pd.to_numeric(pd.Series(words), errors="coerce"), dtype=np.float64)
    return numbers[codes]
