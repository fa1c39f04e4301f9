"""Recognition of what a screen shows, from its pixels alone."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy import ndimage

PAPER, INK, BLUE, YELLOW = ((14, 17, 22), (245, 247, 250), (86, 180, 233), (240, 228, 66))
"""Ground and colours, as red, green, blue; greys are parts of the way from ground to ink."""
EDGE_FROM, QUIET_FROM, INK_FROM, COLOUR_FROM = 0.3, 0.5, 0.72, 0.5
"""Smallest part of the way at which a pixel counts as grey or coloured: edges are smoothed."""
NOTHING, EDGE_LIKE, QUIET_LIKE, INK_LIKE, BLUE_LIKE, YELLOW_LIKE = range(6)
GREYS = (EDGE_LIKE, QUIET_LIKE, INK_LIKE)
ROUND, EDGE_PX, ROW_PX = 0.03, 4, 2


@dataclass(frozen=True)
class Body:
    """Connected pixels of one colour: their bounding box (px, y downwards, ends not in it) and their number."""

    x0: int
    x1: int
    y0: int
    y1: int
    n: int

    @property
    def width(self):
        return self.x1 - self.x0

    @property
    def height(self):
        return self.y1 - self.y0

    @property
    def middle(self):
        return (self.x0 + self.x1) / 2, (self.y0 + self.y1) / 2

    @property
    def filled(self):
        """Share of the bounding box that has the colour: pi/4 for a disc."""
        return self.n / (self.width * self.height)

    def is_square(self, within_px):
        return abs(self.width - self.height) <= within_px


@dataclass(frozen=True)
class Bar:
    """A force bar: its height and those of the lines that it should be between, px above its lower end; `held` is its
    colour there."""

    height: int
    low: float
    high: float
    held: bool

    @property
    def wanted(self):
        return (self.low + self.high) / 2


@dataclass(frozen=True)
class Seen:
    """All that matters on one picture; None or nothing where it is not there."""

    height_px: int
    marker: str | None = None
    bar: Bar | None = None
    dot_px: float | None = None
    ring_px: float | None = None
    choices: tuple[Body, ...] = ()
    boxes: tuple[Body, ...] = ()
    typed: bool = False
    rows: tuple[tuple[Body, ...], ...] = ()
    marked: tuple[int | None, ...] = ()
    words: bool = False
    asks: bool = False

    @property
    def kind(self):
        if self.marker is not None:
            return "touch"
        if self.rows:
            return "form"
        if len(self.boxes) >= 12:
            return "number"
        if self.choices:
            return "question"
        if self.boxes:
            return "adjust"
        return "words" if self.words else "nothing"


def colours(picture):
    """Classify each pixel of a picture: `NOTHING` to `YELLOW_LIKE`."""
    found = np.zeros(picture.shape[:2], np.uint8)
    lit = (picture != np.array(PAPER, np.uint8)).any(axis=2)
    away = picture[lit].astype(np.float32) - np.array(PAPER, np.float32)
    ways = [np.subtract(colour, PAPER).astype(np.float32) for colour in (INK, BLUE, YELLOW)]
    parts = np.stack([away @ way / (way @ way) for way in ways])
    beside = np.stack([((away - np.outer(part, way)) ** 2).sum(axis=1) for part, way in zip(parts, ways, strict=True)])
    nearest = beside.argmin(axis=0)
    part = np.take_along_axis(parts, nearest[None], axis=0)[0]
    grey = np.searchsorted([EDGE_FROM, QUIET_FROM, INK_FROM], part, side="right")
    found[lit] = np.where(nearest == 0, grey, np.where(part >= COLOUR_FROM, BLUE_LIKE - 1 + nearest, NOTHING))
    return found


def bodies(mask, least_px=4, corners=1):
    """The connected pixels of a mask, in the order of their first rows; by corners too, unless `corners` is 0."""
    cross = [[corners, 1, corners], [1, 1, 1], [corners, 1, corners]]
    labels, _ = ndimage.label(mask, structure=cross)
    counts = np.bincount(labels.ravel())
    return [
        Body(place[1].start, place[1].stop, place[0].start, place[0].stop, int(counts[k]))
        for k, place in enumerate(ndimage.find_objects(labels), 1)
        if counts[k] >= least_px
    ]


def see(picture):
    pixels = colours(np.asarray(picture, np.uint8))
    height_px = len(pixels)
    blue = bodies(pixels == BLUE_LIKE)
    marker = _marker(blue, height_px)
    if marker is not None:
        return Seen(height_px, marker, _bar(pixels, blue, height_px), *_track(pixels, blue, height_px))
    rows = _rows(pixels, height_px)
    boxes = [] if rows else [body for body in bodies(np.isin(pixels, GREYS)) if _is_outline(body, height_px)]
    choices = tuple(body for body in boxes if body.height > 0.2 * height_px)
    return Seen(
        height_px,
        choices=choices,
        boxes=tuple(body for body in boxes if body not in choices),
        typed=_typed(pixels, boxes),
        rows=rows,
        marked=_marked(pixels, rows),
        words=any(body.height < 0.06 * height_px for body in bodies(pixels == INK_LIKE)),
        asks=bool((pixels[round(0.88 * height_px) :] >= QUIET_LIKE).any()),
    )


def _is_outline(body, height_px):
    """Return True for a box of edges that is larger than a letter."""
    edges = 2 * (body.width + body.height)
    return body.width > 0.1 * height_px and body.height > 0.05 * height_px and 0.6 * edges < body.n < 4 * edges


def _marker(blue, height_px):
    for body in blue:
        if 0.2 * height_px < body.width < 0.4 * height_px and body.is_square(ROUND * height_px):
            return "playing" if body.filled > 0.5 else "ready"
    return None


def _bar(pixels, blue, height_px):
    """Two blue lines of one width above each other, and the bar that rises behind them from its foot, an edge."""
    lines = [
        body for body in blue if body.height < 0.02 * height_px and 0.12 * height_px < body.width < 0.3 * height_px
    ]
    pairs = [(a, b) for a in lines for b in lines if a.y0 < b.y0 and abs(a.x0 - b.x0) + abs(a.x1 - b.x1) <= 4]
    if not pairs:
        return None
    high, low = pairs[0]
    column = pixels[:, round(low.middle[0])]
    foot = low.y1 + int(np.flatnonzero(column[low.y1 :])[-1])
    of_bar = np.isin(column[: foot - EDGE_PX][::-1], (INK_LIKE, BLUE_LIKE, YELLOW_LIKE))
    height = int(of_bar.argmin())
    return Bar(
        height + EDGE_PX if height else 0,
        foot - low.middle[1],
        foot - high.middle[1],
        bool((column == YELLOW_LIKE).any()),
    )


def _track(pixels, blue, height_px):
    """Return places of the track's dot and the finger's ring, px."""
    small = [body for body in blue if 0.01 * height_px < body.height < 0.08 * height_px]
    dots = [body for body in small if body.is_square(0.035 * height_px)]
    rings = [
        body
        for body in bodies(pixels == YELLOW_LIKE)
        if 0.05 * height_px < body.width < 0.1 * height_px and body.filled < 0.4
    ]
    dot_px = None if not dots else float(np.average([dot.middle[0] for dot in dots], weights=[dot.n for dot in dots]))
    return dot_px, rings[0].middle[0] if rings else None


def _rows(pixels, height_px):
    """Rows of rings of one size at one height, five at least, by what they enclose; a mark is yellow."""
    rings = [
        body
        for body in bodies(np.isin(pixels, (NOTHING, YELLOW_LIKE)), 30, corners=0)
        if body.width < 0.12 * height_px and body.is_square(3) and 0.6 < body.filled < 0.95
    ]
    rings.sort(key=lambda ring: ring.middle[1])
    starts = [k for k, ring in enumerate(rings) if not k or ring.middle[1] - rings[k - 1].middle[1] > ROW_PX]
    rows = (_of_one_size(rings[first:last]) for first, last in pairwise([*starts, len(rings)]))
    return tuple(tuple(row) for row in rows if len(row) >= 5 and np.ptp(np.diff([ring.x0 for ring in row])) <= ROW_PX)


def _of_one_size(rings):
    usual_px = np.median([ring.width for ring in rings])
    return sorted((ring for ring in rings if abs(ring.width - usual_px) <= ROW_PX), key=lambda ring: ring.x0)


def _marked(pixels, rows):
    def dotted(ring):
        x, y = (int(place) for place in ring.middle)
        return pixels[y, x] == YELLOW_LIKE

    return tuple(next((k for k, ring in enumerate(row) if dotted(ring)), None) for row in rows)


def _typed(pixels, boxes):
    """Return True if the number's box, the widest one, contains text."""
    if not boxes:
        return False
    box = max(boxes, key=lambda body: body.width)
    return bool((pixels[box.y0 + EDGE_PX : box.y1 - EDGE_PX, box.x0 + EDGE_PX : box.x1 - EDGE_PX] == INK_LIKE).any())
