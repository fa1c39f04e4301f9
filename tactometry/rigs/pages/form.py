"""A page of a questionnaire: a row for each question, all of them open until the page is left."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from . import layout
from .page import ACCENT, EDGE, GOOD, INK, QUIET, Answer, Box, Button, Item, Page, Text

WORDS = 0.03
TOP, BOTTOM = 0.42, -0.24
SCALE_LENGTH = 0.52
MOST_DIGITS = 9
"""Of a row with more rings no ring has a digit of its own."""
NEXT, BEFORE = "next row", "row before"
CONFIRM_BUTTON = Button(layout.CONFIRM, layout.CONTINUE_KEYS, 0, -0.32, 0.26, 0.09)


@dataclass(frozen=True)
class Form:
    """What a page asks: `rows` of (statement, left word, right word), each with `n_positions` places.

    `gaps` is what the page says when it should be left with open questions.
    """

    rows: tuple[tuple[str, str, str], ...]
    n_positions: int
    rings: bool
    hint: str
    gaps: str


@dataclass(frozen=True)
class Marks:
    """The marks of a form up to now, the row that the keys go to, and whether the gaps were pointed out."""

    places: tuple[int | None, ...]
    row: int = 0
    warned: bool = False

    @property
    def complete(self) -> bool:
        return None not in self.places

    def set(self, row: int, place: int) -> "Marks":
        """With another mark in a row, which the keys then go to."""
        places = (*self.places[:row], place, *self.places[row + 1 :])
        return replace(self, places=places, row=row, warned=False)


def hint_for(steps: int | None) -> str:
    """The message that tells how a row of so many rings is answered, of a line without.

    >>> hint_for(7), hint_for(21), hint_for(None)
    ('hint_fill', 'hint_fill_arrows', 'hint_fill_arrows')
    """
    return "hint_fill" if steps is not None and steps <= MOST_DIGITS else "hint_fill_arrows"


def after(form: Form, marks: Marks, answer: Answer) -> tuple[Marks, bool]:
    """The marks that follow an answer, and whether the page is left: with gaps only at the second wish.

    >>> form = Form((("", "a", "b"), ("", "c", "d")), n_positions=7, rings=True, hint="", gaps="")
    >>> after(form, Marks((3, None)), layout.CONFIRM)
    (Marks(places=(3, None), row=1, warned=True), False)
    >>> after(form, Marks((3, None), warned=True), layout.CONFIRM)[1], after(form, Marks((3, 0)), layout.CONFIRM)[1]
    (True, True)
    """
    if isinstance(answer, tuple):
        return marks.set(*answer), False
    if isinstance(answer, int):
        answered = marks.set(marks.row, answer)
        return replace(answered, row=min(answered.row + 1, len(form.rows) - 1)), False
    if answer == layout.CONFIRM:
        return _leave(marks)
    if answer in (NEXT, BEFORE):
        row = marks.row + (1 if answer == NEXT else -1)
        return replace(marks, row=min(max(row, 0), len(form.rows) - 1)), False
    return marks.set(marks.row, layout.shift(marks.places[marks.row], answer, form.n_positions)), False


def _leave(marks: Marks) -> tuple[Marks, bool]:
    if marks.complete or marks.warned:
        return marks, True
    return replace(marks, row=marks.places.index(None), warned=True), False


def form_page(form: Form, marks: Marks, aspect: float) -> Page:
    """The rows with their marks, and a box to leave the page."""
    pitch = (TOP - BOTTOM) / len(form.rows)
    centres = [TOP - (k + 0.5) * pitch for k in range(len(form.rows))]
    items: list[Item] = []
    buttons: list[Button] = []
    for k, (row, y) in enumerate(zip(form.rows, centres, strict=True)):
        if k == marks.row:
            items.append(Box(0, y, layout.MARGIN * aspect, 0.94 * pitch, line=ACCENT))
        items += _row(form, row, marks.places[k], y, pitch, aspect)
        buttons += _places(form, k, y, pitch)
    words = form.gaps if marks.warned else form.hint
    return Page((*items, *_foot(words, marks, aspect)), (*buttons, *_keys(form)))


def _row(
    form: Form, row: tuple[str, str, str], place: int | None, y: float, pitch: float, aspect: float
) -> Sequence[Item]:
    statement, left, right = row
    side = (layout.MARGIN * aspect - SCALE_LENGTH) / 2 - 0.04
    middle = y - 0.2 * pitch if statement else y
    edge = SCALE_LENGTH / 2 + 0.02
    words: list[Item] = [Text(statement, 0, y + 0.25 * pitch, WORDS, wrap_width=0.95 * layout.MARGIN * aspect)]
    return [
        *(words if statement else []),
        Text(left, -edge, middle, WORDS, wrap_width=side, align="right"),
        Text(right, edge, middle, WORDS, wrap_width=side, align="left"),
        *_scale(form, place, middle),
    ]


def _xs(n_positions: int) -> list[float]:
    return [((k + 0.5) / n_positions - 0.5) * SCALE_LENGTH for k in range(n_positions)]


def _scale(form: Form, place: int | None, y: float) -> list[Item]:
    xs = _xs(form.n_positions)
    if form.rings:
        return layout.rings(xs, y, min(0.024, 0.4 * SCALE_LENGTH / form.n_positions), place)
    line = Box(0, y, xs[-1] - xs[0], 0.004, fill=EDGE)
    ends = [Box(side * SCALE_LENGTH / 2, y, 0.005, 0.05, fill=INK) for side in (-1, 1)]
    mark = [] if place is None else [Box(xs[place], y, 0.012, 0.06, fill=GOOD)]
    return [line, *ends, *mark]


def _places(form: Form, row: int, y: float, pitch: float) -> list[Button]:
    middle = y - 0.2 * pitch if form.rows[row][0] else y
    width, height = SCALE_LENGTH / form.n_positions, min(0.09, 0.6 * pitch)
    return [Button((row, k), (), x, middle, width, height) for k, x in enumerate(_xs(form.n_positions))]


def _foot(words: str, marks: Marks, aspect: float) -> list[Item]:
    colour = GOOD if marks.warned else QUIET
    return [
        *layout.confirm_box(CONFIRM_BUTTON, ready=marks.complete or marks.warned),
        Text(words, 0, -0.43, layout.HINT, colour, layout.MARGIN * aspect),
    ]


def _keys(form: Form) -> tuple[Button, ...]:
    digits = range(form.n_positions) if form.rings and form.n_positions <= MOST_DIGITS else ()
    return (
        *(Button(k, layout.digit_keys(k)) for k in digits),
        *layout.ARROWS,
        Button(BEFORE, ("up",)),
        Button(NEXT, ("down", "tab")),
        CONFIRM_BUTTON,
    )
