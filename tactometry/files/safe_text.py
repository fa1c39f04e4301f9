"""Text of a data file, made safe for where it goes: a cell of a spreadsheet, a README, the name of a file."""

import re

FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n", "\uff1d", "\uff0b", "\uff0d", "\uff20")
"""A spreadsheet computes text that begins with one of these (OWASP, "CSV injection"); the last four are full-width."""
BYTE_ORDER_MARK = "\ufeff"
_MARKUP = re.compile(r"[\\<\[]")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


def cell_text(text: str) -> str:
    """Escape a text that a spreadsheet would compute with an apostrophe; a number stays a number.

    A byte-order mark before it is removed, which programs skip at the beginning of a file.

    >>> cell_text("=1+1"), cell_text("\\ufeff=1+1"), cell_text("-0.5"), cell_text("P01")
    ("'=1+1", "'=1+1", '-0.5', 'P01')
    """
    text = text.lstrip(BYTE_ORDER_MARK)
    return f"'{text}" if text.startswith(FORMULA) and not _NUMBER.fullmatch(text) else text


def markdown_text(text: str) -> str:
    r"""Escape the signs of a text that begin HTML or a link in Markdown, and remove a byte-order mark before it.

    >>> print(markdown_text("<script> [a](b)"))
    \<script> \[a](b)
    """
    return _MARKUP.sub(r"\\\g<0>", text.lstrip(BYTE_ORDER_MARK))


def file_text(text: str) -> str:
    """`text` as part of a file's name: letters, digits, `_`, `-` and `.` stay, others become their number in Unicode.

    Different texts give different names, and none holds a separator of paths.

    >>> file_text("force_n"), file_text("x/../y")
    ('force_n', 'x%2F..%2Fy')
    """
    return "".join(sign if sign.isalnum() or sign in "_-." else f"%{ord(sign):02X}" for sign in text)
