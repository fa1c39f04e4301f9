"""Lines of a column map that say what a refused cell means."""

import json
import re

NOT_MEASURED = frozenset(("none", "null", "nan", "na", "n/a", "-", "--", "undefined", "#n/a", "timeout"))
"""What other programs write where nothing was measured."""
NAMED_VALUES = ("response", "target", "session", "correct", "catch", "valid", "practice")
"""Columns whose values other programs write in words."""
NEGATIVE = frozenset(("n", "no", "nein", "false", "f", "wrong", "incorrect", "miss", "not felt"))
"""Words that most likely mean 0."""


def meaning(name: str, text: str) -> str:
    """Return how a column map states what a word means.

    >>> meaning("response", "y")
    "; say what it means in a column map (--columns), below [values.response], for example: 'y' = 1"
    >>> meaning("response", "None"), meaning("response", "7")
    ("; say in a column map (--columns) that it was not measured: missing = ['None']", '')
    """
    if name == "participant" and text:
        return f"; give each a code in a column map (--columns), below [values.participant]: {_toml_text(text)} = 'P1'"
    word, plain = _toml_text(text), text.strip().lower()
    if plain in NOT_MEASURED:
        return f"; say in a column map (--columns) that it was not measured: missing = [{word}]"
    if name not in NAMED_VALUES or not text or _NUMBER.fullmatch(text):
        return ""
    number = 0 if plain in NEGATIVE and name != "target" else 1
    return f"; say what it means in a column map (--columns), below [values.{name}], for example: {word} = {number}"


def _toml_text(text: str) -> str:
    r"""
    >>> print(_toml_text("y"), _toml_text("don't\n"))
    'y' "don't\n"
    """
    if text.isprintable() and "'" not in text:
        return f"'{text}'"
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")  # JSON may hold it as it is, TOML may not


_NUMBER = re.compile(r"[+-]?\d+\.?\d*")
