"""Large tables through pyarrow. What is not plain is left (None) to the slower reader, which says what is wrong."""

import numpy as np
import pandas as pd

from ..arrays import Array


def plain_cells(text: str, separator: str) -> pd.DataFrame | None:
    """All cells as text, the header too, if there is no quotation mark, blank line or row of another length.

    >>> plain_cells("a,b" + chr(10) + "1,2", ",").values.tolist()
    [['a', 'b'], ['1', '2']]
    >>> plain_cells("a,b" + chr(10) + "1", ",") is None
    True
    """
    import pyarrow as pa  # type: ignore[import-untyped,unused-ignore]
    from pyarrow import csv

    whole = text.rstrip("\r\n")
    has_blank_line = "\n\n" in whole or "\r\n\r" in whole or whole.startswith(("\n", "\r"))
    if not whole or '"' in whole or has_blank_line:
        return None
    header = whole.partition("\n")[0]
    names = [str(place) for place in range(header.count(separator) + 1)]
    if len(names) < 2 or whole.count("\r") != whole.count("\r\n"):
        return None
    try:
        table = csv.read_csv(
            pa.py_buffer(whole.encode()),
            read_options=csv.ReadOptions(column_names=names),
            parse_options=csv.ParseOptions(delimiter=separator, quote_char=False),
            convert_options=csv.ConvertOptions(
                column_types=dict.fromkeys(names, pa.string()), strings_can_be_null=False, check_utf8=False
            ),
        )
    except pa.ArrowInvalid:
        return None
    cells: pd.DataFrame = table.to_pandas()
    return cells.set_axis(range(len(names)), axis=1)


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
