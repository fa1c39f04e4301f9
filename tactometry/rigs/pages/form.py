"""Questionnaire page with a row per question, editable until it is left."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

from ...session.answer import Marked
from ...session.request import Fill, value_at
from ..texts import Texts
from . import layout
from .page import ACCENT, EDGE, GOOD, INK, QUIET, Answer, Box, Button, Item, Page, Slider, Text

WORDS, WORDS_OF_WIDTH = 0.034, 0.02
"""Height of letters, and its limit in screen widths. The longest SUS statement then fits on one line."""
TOP, BOTTOM = 0.37, -0.27
"""Upper and lower edge of the rows."""
STEM_Y = 0.435
N_POSITIONS_CONTINUOUS = 101
MOST_DIGITS = 9
"""Rows with more positions have no digit keys and fill the width of the page."""
NARROW = 0.62
"""Longest scale that has its end labels at the sides."""
KEPT_EVERY_S = 0.2
"""Interval at which rapid changes of a mark, for example during a drag, are recorded."""
NEXT, BEFORE, BACK, OPEN = "next row", "row before", "page before", "leave open"
FOOT_Y = -0.34
CONFIRM_BUTTON = Button(layout.CONFIRM, layout.CONTINUE_KEYS, 0, FOOT_Y, 0.26, 0.08)
BACK_BUTTON = Button(BACK, ("backspace", "pageup"), -0.42, FOOT_Y, 0.34, 0.08)
OPEN_BUTTON = Button(OPEN, ("0", "num_0"), 0.42, FOOT_Y, 0.34, 0.08)
Values = tuple[float | None, ...]


@dataclass(frozen=True)
class Marks:
    """Answers on a form, and its state.

    The state is the active row, whether unanswered rows were pointed out, and whether to go back.
    """

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


@dataclass(frozen=True)
class Form:
    """Page of a questionnaire in the participant's language."""

    request: Fill
    texts: Texts

    @cached_property
    def rows(self) -> tuple[tuple[str, str, str], ...]:
        """Return statement, left label and right label of each question."""
        return tuple(map(self.texts.question, self.request.questions))

    @property
    def n_positions(self) -> int:
        return self.request.steps or N_POSITIONS_CONTINUOUS

    @property
    def rings(self) -> bool:
        return self.request.steps is not None

    @property
    def wide(self) -> bool:
        """True if a scale fills the width, with its labels below its ends."""
        return self.n_positions > MOST_DIGITS

    @property
    def hint(self) -> str:
        """Name of the message that explains how to answer a row."""
        if not self.rings:
            return "hint_fill_line"
        return "hint_fill_arrows" if self.wide else "hint_fill"

    def begun(self) -> Marks:
        """Return the marks given so far, with the first unanswered row active."""
        request, last = self.request, self.n_positions - 1
        places: list[int | None] = [None] * len(request.questions)
        for row, value in enumerate(request.given):
            if value is not None:
                place = round((value - request.low) / (request.high - request.low) * last)
                places[row] = min(max(place, 0), last)
        return Marks(tuple(places), row=places.index(None) if None in places else 0)

    def values(self, marks: Marks) -> Values:
        """Return the value of each mark, or None for an unanswered row."""
        n, low, high = self.n_positions, self.request.low, self.request.high
        return tuple(None if place is None else value_at(place, n, low, high) for place in marks.places)


@dataclass
class Keeping:
    """Recorder of marks as they change, called in each frame."""

    form: Form
    keep: Callable[[Marked], None]
    session_s: Callable[[float], float]
    _kept_s: float = field(default=-float("inf"), init=False)

    def __post_init__(self) -> None:
        self._kept = self.form.values(self.form.begun())

    def __call__(self, marks: Marks) -> None:
        values, now_s = self.form.values(marks), time.perf_counter()
        if values != self._kept and now_s - self._kept_s >= KEPT_EVERY_S:
            self.keep(Marked(self.form.request.form, values, self.session_s(now_s)))
            self._kept, self._kept_s = values, now_s


def after(form: Form, marks: Marks, answer: Answer) -> tuple[Marks, bool]:
    """Return the marks after an answer, and whether the page is left.

    Return leaves a complete page. The first attempt with unanswered questions shows the box that leaves them open.
    """
    last = len(marks.places) - 1
    if isinstance(answer, tuple):
        return marks.set(*answer), False
    if isinstance(answer, int):
        return replace(marks.set(marks.row, answer), row=min(marks.row + 1, last)), False
    if answer == BACK:
        return replace(marks, back=True), True
    if answer == OPEN or (answer == layout.CONFIRM and marks.complete):
        return marks, True
    if answer == layout.CONFIRM:
        return replace(marks, row=marks.places.index(None), warned=True), False
    if answer in (NEXT, BEFORE):
        row = marks.row + (1 if answer == NEXT else -1)
        return replace(marks, row=min(max(row, 0), last)), False
    return marks.set(marks.row, layout.shift(marks.places[marks.row], answer, form.n_positions)), False


def form_page(form: Form, marks: Marks, aspect: float) -> Page:
    """Return a page of rows with their marks, and boxes to leave it."""
    pitch = (TOP - BOTTOM) / len(form.rows)
    items, sliders = _head(form, aspect), []
    for k in range(len(form.rows)):
        y = TOP - (k + 0.5) * pitch
        if k == marks.row:
            items.append(Box(0, y, layout.MARGIN * aspect, 0.94 * pitch, line=ACCENT))
        middle = scale_y(form, k, y, pitch)
        items += _row(form, k, y, pitch, aspect)
        items += _scale(form, marks.places[k], middle, scale_extent(form, aspect))
        sliders.append(Slider(k, form.n_positions, 0.0, middle, scale_extent(form, aspect), min(0.1, 0.7 * pitch)))
    items += layout.confirm_box(CONFIRM_BUTTON, ready=marks.complete)
    buttons = [*_keys(form), CONFIRM_BUTTON]
    boxes = ((form.request.page > 1, BACK_BUTTON, "page_back"), (marks.warned, OPEN_BUTTON, "leave_open"))
    for is_shown, button, words in boxes:
        if is_shown:
            text = Text(form.texts.message(words), button.x, button.y, WORDS, wrap_width=button.width)
            items += [button.outline(INK), text]
            buttons.append(button)
    hint, colour = ("hint_gaps", GOOD) if marks.warned else (form.hint, QUIET)
    items.append(Text(form.texts.message(hint), 0, -0.44, layout.HINT, colour, layout.MARGIN * aspect))
    return Page(tuple(items), (*sliders, *buttons))


def _head(form: Form, aspect: float) -> list[Item]:
    """Draw the stem common to all questions, and the page number."""
    request, texts, width = form.request, form.texts, layout.MARGIN * aspect
    stem, items = texts.in_language(request.stem), list[Item]()
    if stem:
        items.append(Text(stem, -width / 2, STEM_Y, layout.BODY, wrap_width=width - 0.24, align="left"))
    if request.n_pages > 1:
        count = texts.message("page_count", {"page": request.page, "n_pages": request.n_pages})
        items.append(Text(count, width / 2, STEM_Y, layout.HINT, QUIET, 0.24, "right"))
    return items


def scale_extent(form: Form, aspect: float) -> float:
    width = layout.MARGIN * aspect
    return width - 0.1 if form.wide else min(NARROW, 0.4 * width)


def scale_y(form: Form, row: int, y: float, pitch: float) -> float:
    """Return the height of a scale in a row: below a statement, or above digits."""
    return y - 0.08 * pitch if form.rows[row][0] else y + 0.13 * pitch


def _row(form: Form, row: int, y: float, pitch: float, aspect: float) -> list[Item]:
    """Draw the statement and the end labels of a scale."""
    statement, left, right = form.rows[row]
    width, length = layout.MARGIN * aspect, scale_extent(form, aspect)
    letters = min(WORDS, WORDS_OF_WIDTH * aspect)
    above: list[Item] = [Text(statement, 0, y + 0.3 * pitch, letters, wrap_width=0.98 * width)] if statement else []
    middle = scale_y(form, row, y, pitch)
    if form.wide:
        ends_y, edge, side = middle - 0.05, length / 2, 0.45 * length
    else:
        ends_y, edge, side = middle, length / 2 + 0.02, (width - length) / 2 - 0.03
    return [
        *above,
        Text(left, -edge, ends_y, letters, wrap_width=side, align="left" if form.wide else "right"),
        Text(right, edge, ends_y, letters, wrap_width=side, align="right" if form.wide else "left"),
    ]


def _scale(form: Form, place: int | None, y: float, length: float) -> list[Item]:
    xs = [((k + 0.5) / form.n_positions - 0.5) * length for k in range(form.n_positions)]
    if form.rings:
        rings = layout.rings(xs, y, min(0.02, 0.4 * length / form.n_positions), place)
        digits = [] if form.wide else [Text(str(k), x, y - 0.034, 0.022, QUIET) for k, x in enumerate(xs, 1)]
        return [*rings, *digits]
    line = Box(0, y, length, 0.004, fill=EDGE)
    ends = [Box(side * length / 2, y, 0.005, 0.05, fill=INK) for side in (-1, 1)]
    mark = [] if place is None else [Box(xs[place], y, 0.012, 0.06, fill=GOOD)]
    return [line, *ends, *mark]


def _keys(form: Form) -> list[Button]:
    digits = range(0 if form.wide else form.n_positions)
    return [
        *(Button(k, (str(k + 1), f"num_{k + 1}")) for k in digits),
        *layout.ARROWS,
        Button(BEFORE, ("up",), repeats=True),
        Button(NEXT, ("down", "tab"), repeats=True),
    ]
