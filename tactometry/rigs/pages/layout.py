"""Layout of the participant's pages: functions that return a `Page`."""

import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

from ...session.request import Adjust
from ..texts import PageImage
from .page import ACCENT, EDGE, GOOD, INK, PAPER, QUIET, Answer, Box, Button, Disc, Item, Page, Picture, Text

BODY, HEADING, HINT = 0.042, 0.056, 0.032
"""Letter heights, in screen heights."""
MARGIN = 0.9
"""Largest part of the screen's width that a page fills."""
LONGEST_NEXT_TO_BAR = 0.5
WIDEST = 1.5
"""Largest width of a line of text."""

TALLEST = 0.4
"""Largest height of an image on a page of text."""
LIST_TOP, LIST_HEIGHT, LEAST_ROWS = 0.28, 0.62, 6
"""Top and height of a column of options, in screen heights. The height is divided among at least `LEAST_ROWS` rows."""
ELSEWHERE: Final = {"a": ("q",), "m": ("semicolon",), "q": ("a",), "w": ("z",), "y": ("z",), "z": ("y", "w")}
"""US names of the keys for a letter on QWERTZ and AZERTY keyboards, if they differ."""
CONTINUE_KEYS = ("space", "return", "num_enter")
LEFT, RIGHT, UP, DOWN, CONFIRM = "left", "right", "up", "down", "confirm"
FIRST, LAST = "first place", "last place"
ARROWS = (
    Button(LEFT, ("left",), repeats=True),
    Button(RIGHT, ("right",), repeats=True),
    Button(FIRST, ("home",)),
    Button(LAST, ("end",)),
)
CONFIRM_BUTTON = Button(CONFIRM, CONTINUE_KEYS, 0, -0.27, 0.26, 0.1)


def shift(place: int | None, answer: Answer, n_places: int) -> int:
    """Return the position on a scale after an arrow key, Home or End.

    On an unmarked scale an arrow starts at its own end of the scale, so that the page does not suggest an answer.

    >>> shift(None, RIGHT, 7), shift(None, LEFT, 7), shift(3, LEFT, 7), shift(3, LAST, 7)
    (0, 6, 2, 6)
    """
    if place is None:
        place = n_places if answer == LEFT else -1
    places = {LEFT: place - 1, RIGHT: place + 1, FIRST: 0, LAST: n_places - 1}
    return min(max(places[str(answer)], 0), n_places - 1)


def heading(words: str, y: float, aspect: float) -> Text:
    return Text(words, 0, y, HEADING, wrap_width=min(WIDEST, MARGIN * aspect))


def hint_line(words: str, aspect: float) -> Text:
    return Text(words, 0, -0.42, HINT, QUIET, MARGIN * aspect)


def message_page(
    words: str, hint: str, aspect: float, progress: float | None = None, image: PageImage | None = None
) -> Page:
    """Return a page of text, left with space, Return or a click.

    `progress` (0..1) is drawn as a bar, an `image` below the heading.
    """
    width = min(WIDEST, MARGIN * aspect)
    first, _, body = words.strip().partition("\n\n")
    items: list[Item] = [heading(first, 0.43 if image else 0.33 if body else 0.05, aspect)]
    if image is not None:
        height = min(TALLEST, width / image.ratio)
        items.append(Picture(image.path, 0, 0.18, image.ratio * height, height))
    if body:
        items.append(Text(body.strip(), 0, -0.16 if image else 0, BODY, wrap_width=width))
    if progress is not None:
        length = 0.8
        done = length * min(max(progress, 0.0), 1.0)
        progress_bar = [
            Box((done - length) / 2, -0.26, done, 0.02, fill=ACCENT),
            Box(0, -0.26, length, 0.02, line=EDGE),
        ]
        items += progress_bar
    items.append(Text(hint, 0, -0.42, HINT, QUIET, width))
    return Page(tuple(items), (Button("continue", CONTINUE_KEYS, 0, 0, aspect, 1.0),))


def bar_page(words: str, hint: str, aspect: float, length: float) -> Page:
    """Return a page with a bar of `length` next to a text."""
    message = message_page("", hint, aspect)
    first, _, body = words.partition("\n\n")
    items = (
        heading(first, 0.36, aspect),
        Box(-0.5, 0, 0.02, length, fill=INK),
        Text(body, -0.4, 0, BODY, wrap_width=0.95, align="left"),
        message.items[-1],
    )
    return Page(items, message.buttons)


def question_page(words: str, options: Sequence[int], labels: Sequence[str], hint: str, aspect: float) -> Page:
    """Return a question with a box for each option, with label and key."""
    gap = 0.04
    width = min(0.42, MARGIN * aspect / len(options) - gap)
    left = -(len(options) - 1) / 2 * (width + gap)
    keys = option_keys(options, labels)
    buttons = tuple(
        Button(option, key, left + k * (width + gap), -0.06, width, 0.24)
        for k, (option, key) in enumerate(zip(options, keys, strict=True))
    )
    boxes = [item for button, label in zip(buttons, labels, strict=True) for item in _option_box(button, label)]
    return Page((heading(words, 0.24, aspect), *boxes, hint_line(hint, aspect)), buttons)


def _option_box(button: Button, label: str) -> list[Item]:
    x, width, key = button.x, button.width, button.keys[0].upper()
    box = button.outline(INK)
    if label.upper() == key:  # if the label is the key, show it once, in large letters
        return [box, Text(label, x, -0.06, 0.1, wrap_width=width)]
    words = Text(label, x, -0.02, HEADING, wrap_width=0.95 * width)
    return [box, words, Box(x, -0.125, 0.07, 0.07, line=QUIET), Text(key, x, -0.125, BODY, QUIET)]


def list_page(words: str, options: Sequence[int], labels: Sequence[str], hint: str, aspect: float) -> Page:
    """Return a question with its options in a column, for long or many labels."""
    width, pitch = min(0.9, MARGIN * aspect), LIST_HEIGHT / max(len(options), LEAST_ROWS)
    buttons = tuple(
        Button(option, (str(option), f"num_{option}"), 0, LIST_TOP - (k + 0.5) * pitch, width, 0.84 * pitch)
        for k, option in enumerate(options)
    )
    rows: list[Item] = []
    for button, label in zip(buttons, labels, strict=True):
        digit = Text(button.keys[0], 0.06 - width / 2, button.y, BODY, QUIET)
        label_text = Text(label, 0.12 - width / 2, button.y, BODY, wrap_width=width - 0.16, align="left")
        rows += [button.outline(INK), digit, label_text]
    return Page((heading(words, 0.37, aspect), *rows, hint_line(hint, aspect)), buttons)


def option_keys(options: Sequence[int], labels: Sequence[str]) -> list[tuple[str, ...]]:
    """Return the keys of each option: its digit and, if unique, its initial."""
    letters = [_letter_keys(label) for label in labels]
    distinct = all(letters) and len({key for keys in letters for key in keys}) == sum(map(len, letters))
    digits = [(str(option), f"num_{option}") if 0 <= option <= 9 else () for option in options]
    return [(*keys, *digit) if distinct else digit for keys, digit in zip(letters, digits, strict=True)]


def _letter_keys(label: str) -> tuple[str, ...]:
    """Return the keys of a label's first letter by their place on a US keyboard."""
    plain = unicodedata.normalize("NFKD", label).casefold()[:1]
    letter = plain if "a" <= plain <= "z" else ""
    return (letter, *ELSEWHERE.get(letter, ())) if letter else ()


def marker_page(interval: int | None, *, playing: bool, words: str = "", why: str = "") -> Page:
    """Return a page with the interval's number in a ring.

    The ring is filled while a stimulus may be felt. `words` is the instruction, and `why` the reason why the last
    touch did not count.
    """
    fill, ink = (ACCENT, PAPER) if playing else (None, INK)
    number = [Text(str(interval), 0, 0, 0.16, ink)] if interval is not None else []
    above = [Text(words, 0, 0.4, HEADING, wrap_width=1.3)] if words else []
    below = [Text(why, 0, 0.31, BODY, wrap_width=1.3)] if why else []
    return Page((*above, *below, Disc(0, 0, 0.15, fill=fill, line=ACCENT), *number))


def waiting_page() -> Page:
    return Page((Box(0, 0, 0.04, 0.006, fill=QUIET), Box(0, 0, 0.006, 0.04, fill=QUIET)))


def force_page(page: Page, force_n: float | None, target_n: float, tolerance: float) -> Page:
    """Add a bar for the force, which changes colour within the force band."""
    held = force_n is not None and abs(force_n - target_n) <= tolerance * target_n
    x, bottom, full = 0.4, -0.3, 0.56
    scale = full / (2 * target_n)  # the target is at half of the bar's height
    height = min(max(force_n or 0.0, 0.0) * scale, full)
    middle, half = bottom + target_n * scale, tolerance * target_n * scale
    bar = (
        Box(x, bottom + full / 2, 0.1, full, line=EDGE),
        Box(x, bottom + height / 2, 0.1, height, fill=GOOD if held else INK),
        *(Box(x, middle + side * half, 0.18, 0.006, fill=ACCENT) for side in (-1, 1)),
    )
    square = [Box(x + 0.16, middle, 0.05, 0.05, fill=GOOD)] if held else []
    return Page((*page.items, *bar, *square), page.buttons)


def track_page(page: Page, cue: float, length: float, finger: float | None = None) -> Page:
    """Add a track with a moving dot, and a ring for the finger.

    `length` is in screen heights. `cue` and `finger` are positions from -1 to 1. A short track is drawn next to the
    force bar, a long one below it.
    """
    y = -0.23 if length <= LONGEST_NEXT_TO_BAR else -0.36
    moving = [Disc(cue * length / 2, y, 0.022, fill=ACCENT)]
    if finger is not None:
        place = min(max(finger, -1.1), 1.1)  # clipped just beyond the end, so that the finger appears outside the track
        moving.append(Disc(place * length / 2, y, 0.036, line=GOOD))
    return Page((Box(0, y, length, 0.006, fill=EDGE), *page.items, *moving), page.buttons)


def sweep(phase: float) -> float:
    """Return the position (-1..1) of a cue that moves to and fro at constant speed.

    >>> [sweep(phase) for phase in (0.0, 0.5, 1.0, 1.5, 2.0)]
    [-1.0, 0.0, 1.0, 0.0, -1.0]
    """
    return 1.0 - 2.0 * abs(phase % 2.0 - 1.0)


def rings(places: Sequence[float], y: float, radius: float, mark: int | None) -> list[Item]:
    """Draw a ring at each position of a line, one of them marked."""
    line = Box(0, y, places[-1] - places[0], 0.004, fill=EDGE)
    discs = [Disc(x, y, radius, fill=PAPER, line=INK) for x in places]
    dot = [] if mark is None else [Disc(places[mark], y, 0.7 * radius, fill=GOOD)]
    return [line, *discs, *dot]


def confirm_box(button: Button, *, ready: bool = True) -> tuple[Item, Item]:
    """Draw the confirmation box, faint while nothing can be confirmed."""
    ink = INK if ready else EDGE
    return button.outline(ink), Text("OK", button.x, button.y, BODY, ink)


def adjust_page(words: str, hint: str, aspect: float) -> Page:
    """Return a page with two arrows and a confirmation. The level is hidden."""
    up = Button(UP, ("up", "right"), 0.14, 0.02, 0.2, 0.16)
    down = Button(DOWN, ("down", "left"), -0.14, 0.02, 0.2, 0.16)
    items = (
        heading(words, 0.26, aspect),
        up.outline(INK),
        down.outline(INK),
        Text("+", up.x, up.y, 0.1),
        Text("−", down.x, down.y, 0.1),
        *confirm_box(CONFIRM_BUTTON),
        hint_line(hint, aspect),
    )
    return Page(items, (up, down, CONFIRM_BUTTON))


def steps_after(request: Adjust, n_steps: int, answer: Answer) -> tuple[int, bool]:
    """Return the clipped steps from the start, and whether they are confirmed.

    >>> request = Adjust("tone", start=5.0, step=2.0, low=0.0, high=6.0)
    >>> steps_after(request, 0, DOWN), steps_after(request, 0, UP), steps_after(request, -1, CONFIRM)
    ((-1, False), (0, False), (-1, True))
    """
    if answer == CONFIRM:
        return n_steps, True
    moved = n_steps + (1 if answer == UP else -1)
    return (moved if request.low <= request.level(moved) <= request.high else n_steps), False


SCALE: Final = 0.55
"""Scale of the picture. It is small, so that its circle is not mistaken for that of a real touch."""
PLACES: Final[Mapping[str, tuple[float, float]]] = {
    "circle": (-0.2, 0.13),
    "bar": (0.4, 0.33),
    "dot": (0.1, -0.31),
    "ring": (-0.07, -0.31),
}
"""Position of the number of each part, on the page at full size."""
LENGTH, CUE, FINGER = 0.42, 0.5, -0.33


def parts_of(*, slides: bool, force: bool, place: bool) -> tuple[str, ...]:
    """Return the parts of the screen that are visible during a touch.

    >>> parts_of(slides=True, force=False, place=True)
    ('circle', 'dot', 'ring')
    """
    shown = {"circle": True, "bar": force, "dot": slides, "ring": slides and place}
    return tuple(part for part in PLACES if shown[part])


def picture_page(words: str, meanings: Mapping[str, str], hint: str, aspect: float) -> Page:
    """Return a page with the picture on the left and its legend on the right."""
    message = message_page("", hint, aspect)
    numbers = [Text(str(n), *PLACES[part], BODY / SCALE) for n, part in enumerate(meanings, 1)]
    page = marker_page(None, playing=True)
    if "bar" in meanings:
        page = force_page(page, 1.0, 1.0, 0.2)
    if "dot" in meanings:
        page = track_page(page, CUE, LENGTH, FINGER if "ring" in meanings else None)
    x = -0.25 * MARGIN * aspect - 0.09
    moved = [replace(item, x=x + SCALE * item.x, y=SCALE * item.y) for item in (*page.items, *numbers)]
    picture = map(_scaled, moved)
    items = (heading(words, 0.39, aspect), *picture, *_legend(tuple(meanings.values()), aspect))
    return Page((*items, message.items[-1]), message.buttons)


def _scaled(item: Item) -> Item:
    if isinstance(item, Text):
        return replace(item, height=SCALE * item.height)
    if isinstance(item, Disc):
        return replace(item, radius=SCALE * item.radius)
    return replace(item, width=SCALE * item.width, height=SCALE * item.height)


def _legend(meanings: Sequence[str], aspect: float) -> list[Item]:
    left, right = -0.02, MARGIN * aspect / 2
    pitch = 0.64 / len(meanings)
    rows: list[Item] = []
    for n, words in enumerate(meanings, 1):
        y = 0.31 - (n - 0.5) * pitch
        rows += [
            Text(str(n), left, y, BODY, GOOD),
            Text(words, left + 0.05, y, BODY, wrap_width=right - left - 0.05, align="left"),
        ]
    return rows
