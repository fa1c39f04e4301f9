"""A value as a cell of the trials table."""

from .trial import Value


def cell(value: Value) -> str:
    """A value as a cell: empty for None, 1/0 for a truth value, the shortest form that reads back for a number.

    >>> cell(True), cell(12.0), cell(0.1), cell(None)
    ('1', '12', '0.1', '')
    """
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return str(int(value))
    return repr(value) if isinstance(value, float) else str(value)
