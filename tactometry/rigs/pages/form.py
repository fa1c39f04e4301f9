"""Questionnaire page with one row per question, editable until it is left."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from . import layout
from .page import ACCENT, EDGE, GOOD, INK, QUIET, Answer, Box, Button, Item, Page, Slider, Text

WORDS, WORDS_OF_WIDTH = 0.034, 0.02
"""Height of letters, and its limit in screen widths, with which the longest SUS statement fits on one line."""
TOP, BOTTOM = 0.37, -0.27
"""Upper and lower edge of the rows."""
STEM_Y = 0.435
MOST_DIGITS = 9
"""Rows with more rings have no digit keys and fill the width of the page."""
NARROW = 0.62
"""Largest length of a scale with its words at the sides."""
NEXT, BEFORE, BACK, OPEN = "next row", "row before", "page before", "leave open"
FOOT_Y = -0.34
CONFIRM_BUTTON = Button(layout.CONFIRM, layout.CONTINUE_KEYS, 0, FOOT_Y, 0.26, 0.08)
BACK_BUTTON = Button(BACK, ("backspace", "pageup"), -0.42, FOOT_Y, 0.34, 0.08)
OPEN_BUTTON = Button(OPEN, ("0", "num_0"), 0.42, FOOT_Y, 0.34, 0.08)


@dataclass(frozen=True)
class FormWords:
    """Texts of a page in addition to its questions.

    `stem` is above all questions, `count` is the page number, `hint` explains keys, `gaps` open questions; `back` and
    `leave_open` label boxes. `back` is empty on a first page.
    """

    hint: str
    gaps: str
    stem: str = ""
    count: str = ""
    back: str = ""
    leave_open: str = ""


@dataclass(frozen=True)
class Form:
    """Rows of (statement, left word, right word) with `n_positions` places each."""

    rows: tuple[tuple[str, str, str], ...]
    n_positions: int
    rings: bool
    words: FormWords

    @property
    def wide(self) -> bool:
        """True if a scale fills the width, with its words below its ends."""
        return not self.rings or self.n_positions > MOST_DIGITS


@dataclass(frozen=True)
class Marks:
    """Marks of a form, the row that gets the keys, whether gaps were pointed out, and whether to go back."""

    places: tuple[int | None, ...]
    row: int = 0
    warned: bool = False
    back: bool = False

    @property
    def complete(self) -> bool:
        return None not in self.places

    def set(self, row: int, place: int) -> "Marks":
        places = (*self.places[:row], place, *self.places[row + 1 :])
        return replace(self, places=places, row=row, warned=False)


def begun(places: tuple[int | None, ...]) -> Marks:
    """Return the initial state of a page: keys go to the first open row.

    >>> begun((3, None, None)).row, begun((3, 2, 1)).row
    (1, 0)
    """
    return Marks(places, row=places.index(None) if None in places else 0)


def hint_for(steps: int | None) -> str:
    """Return the message that explains how to answer a row.

    >>> hint_for(7), hint_for(21), hint_for(None)
    ('hint_fill', 'hint_fill_arrows', 'hint_fill_line')
    """
    if steps is None:
        return "hint_fill_line"
    return "hint_fill" if steps <= MOST_DIGITS else "hint_fill_arrows"


def after(form: Form, marks: Marks, answer: Answer) -> tuple[Marks, bool]:
    """Return the marks after an answer, and whether the page is left.

    Return leaves a complete page; a first attempt with open questions shows the box that leaves them open.

    >>> form = Form((("", "a", "b"), ("", "c", "d")), n_positions=7, rings=True, words=FormWords("", ""))
    >>> after(form, Marks((3, None)), layout.CONFIRM)
    (Marks(places=(3, None), row=1, warned=True, back=False), False)
    >>> [after(form, Marks((3, None), warned=True), answer)[1] for answer in (layout.CONFIRM, OPEN)]
    [False, True]
    """
    if isinstance(answer, tuple):
        return marks.set(*answer), False
    if isinstance(answer, int):
        answered = marks.set(marks.row, answer)
        return replace(answered, row=min(answered.row + 1, len(form.rows) - 1)), False
    if answer in (layout.CONFIRM, OPEN, BACK):
        if answer == BACK:
            return replace(marks, back=True), True
        if answer == OPEN or marks.complete:
            return marks, True
        return replace(marks, row=marks.places.index(None), warned=True), False
    if answer in (NEXT, BEFORE):
        row = marks.row + (1 if answer == NEXT else -1)
        return replace(marks, row=min(max(row, 0), len(form.rows) - 1)), False
    return marks.set(marks.row, layout.shift(marks.places[marks.row], answer, form.n_positions)), False


def form_page(form: Form, marks: Marks, aspect: float) -> Page:
    """Return a page of rows with their marks, and boxes to leave it."""
    pitch = (TOP - BOTTOM) / len(form.rows)
    width = layout.MARGIN * aspect
    stem = Text(form.words.stem, -width / 2, STEM_Y, layout.BODY, wrap_width=width - 0.24, align="left")
    count = Text(form.words.count, width / 2, STEM_Y, layout.HINT, QUIET, 0.24, "right")
    head = [text for text in (stem, count) if text.words]
    items: list[Item] = [*head]
    sliders: list[Slider] = []
    for k, row in enumerate(form.rows):
        y = TOP - (k + 0.5) * pitch
        if k == marks.row:
            items.append(Box(0, y, layout.MARGIN * aspect, 0.94 * pitch, line=ACCENT))
        items += _row(form, row, marks.places[k], y, pitch, aspect)
        middle, height = scale_y(form, k, y, pitch), min(0.1, 0.7 * pitch)
        slider = Slider(k, form.n_positions, 0.0, middle, scale_extent(form, aspect), height)
        sliders.append(slider)
    words = form.words
    colour = GOOD if marks.warned else QUIET
    back = _box(BACK_BUTTON, words.back) if words.back else []
    leave_open = _box(OPEN_BUTTON, words.leave_open) if marks.warned else []
    foot = [
        *layout.confirm_box(CONFIRM_BUTTON, ready=marks.complete),
        *back,
        *leave_open,
        Text(words.gaps if marks.warned else words.hint, 0, -0.44, layout.HINT, colour, layout.MARGIN * aspect),
    ]
    return Page((*items, *foot), (*sliders, *_keys(form, marks)))


def scale_extent(form: Form, aspect: float) -> float:
    width = layout.MARGIN * aspect
    return width - 0.1 if form.wide else min(NARROW, 0.4 * width)


def scale_y(form: Form, row: int, y: float, pitch: float) -> float:
    """Return the height of a scale in a row: below a statement, above digits or words."""
    return y - 0.08 * pitch if form.rows[row][0] else y + 0.13 * pitch


def _row(
    form: Form, row: tuple[str, str, str], place: int | None, y: float, pitch: float, aspect: float
) -> Sequence[Item]:
    statement, left, right = row
    width, length = layout.MARGIN * aspect, scale_extent(form, aspect)
    letters = min(WORDS, WORDS_OF_WIDTH * aspect)
    above: list[Item] = [Text(statement, 0, y + 0.3 * pitch, letters, wrap_width=0.98 * width)] if statement else []
    middle = scale_y(form, form.rows.index(row), y, pitch)
    if form.wide:
        ends_y, edge, side = middle - 0.05, length / 2, 0.45 * length
    else:
        ends_y, edge, side = middle, length / 2 + 0.02, (width - length) / 2 - 0.03
    return [
        *above,
        Text(left, -edge, ends_y, letters, wrap_width=side, align="left" if form.wide else "right"),
        Text(right, edge, ends_y, letters, wrap_width=side, align="right" if form.wide else "left"),
        *_scale(form, place, middle, length),
    ]


def _scale(form: Form, place: int | None, y: float, length: float) -> list[Item]:
    xs = [((k + 0.5) / form.n_positions - 0.5) * length for k in range(form.n_positions)]
    if form.rings:
        rings = layout.rings(xs, y, min(0.02, 0.4 * length / form.n_positions), place)
        digits = [Text(str(k), x, y - 0.034, 0.022, QUIET) for k, x in enumerate(xs, 1)]
        return [*rings, *(digits if len(xs) <= MOST_DIGITS else [])]
    line = Box(0, y, length, 0.004, fill=EDGE)
    ends = [Box(side * length / 2, y, 0.005, 0.05, fill=INK) for side in (-1, 1)]
    mark = [] if place is None else [Box(xs[place], y, 0.012, 0.06, fill=GOOD)]
    return [line, *ends, *mark]


def _box(button: Button, words: str) -> list[Item]:
    return [button.outline(INK), Text(words, button.x, button.y, WORDS, wrap_width=button.width)]


def _keys(form: Form, marks: Marks) -> tuple[Button, ...]:
    digits = range(form.n_positions) if form.rings and form.n_positions <= MOST_DIGITS else ()
    return (
        *(Button(k, layout.digit_keys(k)) for k in digits),
        *layout.ARROWS,
        Button(BEFORE, ("up",), repeats=True),
        Button(NEXT, ("down", "tab"), repeats=True),
        CONFIRM_BUTTON,
        *([BACK_BUTTON] if form.words.back else []),
        *([OPEN_BUTTON] if marks.warned else []),
    )
