"""A page of the participant's screen as a value: items, buttons, and answers to events.

Lengths are in heights of the screen, with the origin in its middle and y upwards, so that a page looks the same on
every sufficiently wide screen.
"""

import time
from dataclasses import dataclass
from typing import Literal

from ...session.request import Facts
from ..frame_timing import PERIOD_WITHOUT_BLANK_S

Answer = int | str | tuple[int, int]
"""Answer of a button: an option or a place, a name, or (row, place)."""

PAPER = "#0E1116"
INK = "#F5F7FA"
QUIET = "#A7B1BD"
EDGE = "#6B7683"
ACCENT = "#56B4E9"
GOOD = "#F0E442"


@dataclass(frozen=True)
class Text:
    """Words around (x, y), `height` high, wrapped at `wrap_width`."""

    words: str
    x: float
    y: float
    height: float
    colour: str = INK
    wrap_width: float = 1.2
    align: Literal["left", "center", "right"] = "center"


@dataclass(frozen=True)
class Box:
    """A rectangle around (x, y); `fill` or `line` None is not drawn."""

    x: float
    y: float
    width: float
    height: float
    fill: str | None = None
    line: str | None = None


@dataclass(frozen=True)
class Disc:
    """A circle around (x, y); `fill` or `line` None is not drawn."""

    x: float
    y: float
    radius: float
    fill: str | None = None
    line: str | None = None


@dataclass(frozen=True)
class Picture:
    """The image of a file around (x, y)."""

    path: str
    x: float
    y: float
    width: float
    height: float


Item = Text | Box | Disc | Picture


@dataclass(frozen=True)
class KeyDown:
    """A key that went down at `at_s` on `time.perf_counter`; `repeated` while it is held."""

    name: str
    at_s: float
    repeated: bool = False


@dataclass(frozen=True)
class Click:
    """A press of mouse button or finger at (x, y).

    While it is held and moves it is `dragged`; y stays, so that it answers one row only.
    """

    x: float
    y: float
    at_s: float
    dragged: bool = False


@dataclass(frozen=True)
class Closed:
    """The window was closed."""

    at_s: float


Input = KeyDown | Click | Closed


@dataclass(frozen=True)
class Button:
    """Answers `answer` to one of the `keys`, or a click into the rectangle around (x, y).

    If it `repeats`, a held key answers again and again.
    """

    answer: Answer
    keys: tuple[str, ...] = ()
    x: float = 0.0
    y: float = 0.0
    width: float = 0.0
    height: float = 0.0
    repeats: bool = False

    def outline(self, line: str) -> Box:
        return Box(self.x, self.y, self.width, self.height, line=line)

    def answer_to(self, event: Input) -> Answer | None:
        """Return the answer if this event presses the button."""
        if isinstance(event, KeyDown):
            is_pressed = event.name in self.keys and (self.repeats or not event.repeated)
        elif isinstance(event, Closed) or event.dragged:
            is_pressed = False
        else:
            is_pressed = abs(event.x - self.x) < self.width / 2 and abs(event.y - self.y) < self.height / 2
        return self.answer if is_pressed else None


@dataclass(frozen=True)
class Slider:
    """Row of `n_places` in the rectangle around (x, y): a click or drag answers with the place that it hits.

    A drag may leave the rectangle; beyond an end it gives the last place.

    >>> slider = Slider(2, 4, x=0.0, y=0.0, width=1.0, height=0.2)
    >>> slider.answer_to(Click(0.3, 0.0, at_s=0.0)), slider.answer_to(Click(0.8, 0.0, at_s=0.0, dragged=True))
    ((2, 3), (2, 3))
    """

    row: int
    n_places: int
    x: float
    y: float
    width: float
    height: float

    def answer_to(self, event: Input) -> Answer | None:
        """Return the row and the place that an event answers."""
        if not isinstance(event, Click) or abs(event.y - self.y) >= self.height / 2:
            return None
        part = (event.x - self.x) / self.width + 0.5
        if not event.dragged and not 0 <= part < 1:
            return None
        return self.row, min(max(int(part * self.n_places), 0), self.n_places - 1)


@dataclass(frozen=True)
class Page:
    """Items in drawing order, and buttons; the pointer is shown if there are buttons."""

    items: tuple[Item, ...] = ()
    buttons: tuple[Button | Slider, ...] = ()

    def answer(self, event: Input) -> Answer | None:
        """Return the answer of the first button that takes `event`, or None."""
        answers = (button.answer_to(event) for button in self.buttons)
        return next((answer for answer in answers if answer is not None), None)


class Display:
    """Interface of a display with a keyboard; all times are on `time.perf_counter`, s.

    This base class shows nothing and reports no input, as a console requires.
    """

    @property
    def aspect(self) -> float:
        """Width over height."""
        return 1.0

    def prepare(self, page: Page) -> None:
        """Build what the page needs, so that its first frame is not delayed."""

    def present(self, page: Page) -> float:
        """Show a page for the first time; return the time of the flip."""
        del page
        return time.perf_counter()

    @property
    def offered_s(self) -> float:
        """Time just before the current page became visible; later presses may answer it."""
        return 0.0

    def refresh(self, page: Page) -> float:
        time.sleep(self.period_s)
        return self.present(page)

    def events(self) -> tuple[Input, ...]:
        """Return new inputs since the last call, in order."""
        return ()

    def give_back(self) -> None:
        """Return a borrowed screen until the next page."""

    def facts(self) -> Facts:
        """Return facts for the head of the journal."""
        return {}

    @property
    def period_s(self) -> float:
        return PERIOD_WITHOUT_BLANK_S

    def frame_intervals_s(self) -> list[float]:
        """Return the frame intervals since the last call."""
        return []

    def clock_offset_s(self) -> float:
        """Return our clock minus that of the keyboard."""
        return 0.0

    def close(self) -> None:
        """Close the display. May be called more than once."""
