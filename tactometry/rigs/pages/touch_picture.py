"""Small, numbered picture of the screen during a touch, with a legend."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

from . import layout
from .page import GOOD, Disc, Item, Page, Text

SCALE: Final = 0.55
"""Scale of the picture. It is small, so that nobody mistakes its circle for the circle of a real touch."""
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
    message = layout.message_page("", hint, aspect)
    numbers = [Text(str(n), *PLACES[part], layout.BODY / SCALE) for n, part in enumerate(meanings, 1)]
    page = layout.marker_page(None, playing=True)
    if "bar" in meanings:
        page = layout.force_page(page, 1.0, 1.0, 0.2)
    if "dot" in meanings:
        page = layout.track_page(page, CUE, LENGTH, FINGER if "ring" in meanings else None)
    x = -0.25 * layout.MARGIN * aspect - 0.09
    moved = [replace(item, x=x + SCALE * item.x, y=SCALE * item.y) for item in (*page.items, *numbers)]
    picture = map(_scaled, moved)
    items = (layout.heading(words, 0.39, aspect), *picture, *_legend(tuple(meanings.values()), aspect))
    return Page((*items, message.items[-1]), message.buttons)


def _scaled(item: Item) -> Item:
    if isinstance(item, Text):
        return replace(item, height=SCALE * item.height)
    if isinstance(item, Disc):
        return replace(item, radius=SCALE * item.radius)
    return replace(item, width=SCALE * item.width, height=SCALE * item.height)


def _legend(meanings: Sequence[str], aspect: float) -> list[Item]:
    left, right = -0.02, layout.MARGIN * aspect / 2
    pitch = 0.64 / len(meanings)
    rows: list[Item] = []
    for n, words in enumerate(meanings, 1):
        y = 0.31 - (n - 0.5) * pitch
        rows += [
            Text(str(n), left, y, layout.BODY, GOOD),
            Text(words, left + 0.05, y, layout.BODY, wrap_width=right - left - 0.05, align="left"),
        ]
    return rows
