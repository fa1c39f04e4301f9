"""Text of a data file, made safe for where it goes: a cell that a spreadsheet opens, the name of a file."""

import re

FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""A spreadsheet computes text that begins so (OWASP, "CSV injection")."""
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


def cell_text(text: str) -> str:
    """`text` with an apostrophe before it where a spreadsheet would compute it; a number stays a number.

    >>> cell_text("=1+1"), cell_text("-0.5"), cell_text("P01")
    ("'=1+1", '-0.5', 'P01')
    """
    return f"'{text}" if text.startswith(FORMULA) and not _NUMBER.fullmatch(text) else text


def file_text(text: str) -> str:
    """`text` as part of a file's name: letters, digits, `_`, `-` and `.` stay, others become their number in Unicode.

    Different texts give different names, and none holds a separator of paths.

    >>> file_text("force_n"), file_text("x/../y")
    ('force_n', 'x%2F..%2Fy')
    """
    return "".join(sign if sign.isalnum() or sign in "_-." else f"%{ord(sign):02X}" for sign in text)
