"""Page on which the participant types a number, with keys or by touch."""

import math

from . import layout
from .page import EDGE, INK, Answer, Box, Button, Page, Text

ROWS = ("789", "456", "123", ".0<")
POINT, ERASE = ".", "<"
N_LONGEST = 9
CONFIRM_BUTTON = Button(layout.CONFIRM, layout.CONTINUE_KEYS, 0.42, -0.21, 0.2, 0.09)
KEYS = {
    POINT: ("period", "comma", "num_decimal", "num_separator"),
    ERASE: ("backspace", "delete"),
    **{str(k): (str(k), f"num_{k}") for k in range(10)},
}
BUTTONS = tuple(
    Button(symbol, KEYS[symbol], 0.16 * (column - 1), 0.12 - 0.11 * row, 0.14, 0.09)
    for row, symbols in enumerate(ROWS)
    for column, symbol in enumerate(symbols)
)


def value_of(typed: str, low: float, high: float | None) -> float | None:
    """Return the typed number, or None if it is invalid or out of range.

    >>> value_of("12.5", 0.0, None), value_of(".", 0.0, None), value_of("11", 0.0, 10.0)
    (12.5, None, None)
    """
    if not typed.strip(POINT):  # empty, or only a decimal point, which `float` refuses
        return None
    value = float(typed)
    return value if low <= value <= (math.inf if high is None else high) else None


def after(typed: str, answer: Answer, low: float, high: float | None) -> tuple[str, bool]:
    """Return the text after a key press, and whether it is confirmed.

    >>> after("1", "2", 0.0, None), after("12", ERASE, 0.0, None), after("", layout.CONFIRM, 0.0, None)
    (('12', False), ('1', False), ('', False))
    """
    if answer == layout.CONFIRM:
        return typed, value_of(typed, low, high) is not None
    if answer == ERASE:
        return typed[:-1], False
    fits = len(typed) < N_LONGEST and not (answer == POINT and POINT in typed)
    return (typed + str(answer) if fits else typed), False


def entry_page(words: str, typed: str, hint: str, aspect: float, *, ready: bool) -> Page:
    """Return a page with the question, the typed text, and on-screen keys."""
    keys = [item for key in BUTTONS for item in (key.outline(EDGE), Text(str(key.answer), key.x, key.y, layout.BODY))]
    items = (
        layout.heading(words, 0.37, aspect),
        Box(0, 0.24, 0.5, 0.11, line=INK),
        Text(typed or " ", 0, 0.24, 0.07),
        *keys,
        *layout.confirm_box(CONFIRM_BUTTON, ready=ready),
        layout.hint_line(hint, aspect),
    )
    return Page(items, (*BUTTONS, CONFIRM_BUTTON))
