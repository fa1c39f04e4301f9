"""Page of the participant's screen: items, buttons and answers to events.

Lengths are in screen heights, with the origin in the middle and y upwards. A page looks the same on every
sufficiently wide screen.
"""

import time
from dataclasses import dataclass
from typing import Literal

from ...session.request import Facts
from ..frame_timing import PERIOD_WITHOUT_BLANK_S

Answer = int | str | tuple[int, int]
"""Answer of a button: an option or position, a name, or (row, position)."""

PAPER = "#0E1116"
INK = "#F5F7FA"
QUIET = "#A7B1BD"
EDGE = "#6B7683"
ACCENT = "#56B4E9"
GOOD = "#F0E442"


@dataclass(frozen=True)
class Text:
    """Text centred at (x, y), with letters of `height`, wrapped at `wrap_width`."""

    words: str
    x: float
    y: float
    height: float
    colour: str = INK
    wrap_width: float = 1.2
    align: Literal["left", "center", "right"] = "center"


@dataclass(frozen=True)
class Box:
    """Rectangle centred at (x, y). `fill` or `line` None is not drawn."""

    x: float
    y: float
    width: float
    height: float
    fill: str | None = None
    line: str | None = None


@dataclass(frozen=True)
class Disc:
    """Circle centred at (x, y). `fill` or `line` None is not drawn."""

    x: float
    y: float
    radius: float
    fill: str | None = None
    line: str | None = None


@dataclass(frozen=True)
class Picture:
    """Image of a file, centred at (x, y)."""

    path: str
    x: float
    y: float
    width: float
    height: float


Item = Text | Box | Disc | Picture


@dataclass(frozen=True)
class KeyDown:
    """Key press at `at_s` (`time.perf_counter`); `repeated` while it is held."""

    name: str
    at_s: float
    repeated: bool = False


@dataclass(frozen=True)
class Click:
    """Press of the mouse button or a finger at (x, y).

    It is `dragged` if it moves while held. Then y does not change, so that it answers one row only.
    """

    x: float
    y: float
    at_s: float
    dragged: bool = False


@dataclass(frozen=True)
class Closed:
    """Closing of the window."""

    at_s: float


Input = KeyDown | Click | Closed


@dataclass(frozen=True)
class Button:
    """Button that returns `answer` for any of its `keys`, or for a click.

    The click must be within the rectangle centred at (x, y). If it `repeats`, holding the key answers repeatedly.
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
    """Row of `n_places` that answers a click or drag with the position hit.

    The row fills the rectangle centred at (x, y). A drag may leave the rectangle: beyond an end it selects the last
    position.

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
        """Return the row and the position that an event selects."""
        if not isinstance(event, Click) or abs(event.y - self.y) >= self.height / 2:
            return None
        part = (event.x - self.x) / self.width + 0.5
        if not event.dragged and not 0 <= part < 1:
            return None
        return self.row, min(max(int(part * self.n_places), 0), self.n_places - 1)


@dataclass(frozen=True)
class Page:
    """Items in drawing order, and buttons. The pointer is shown if there are any."""

    items: tuple[Item, ...] = ()
    buttons: tuple[Button | Slider, ...] = ()

    def answer(self, event: Input) -> Answer | None:
        """Return the answer of the first button that `event` presses, or None."""
        answers = (button.answer_to(event) for button in self.buttons)
        return next((answer for answer in answers if answer is not None), None)


class Display:
    """Interface of a display with keyboard. Times are on `time.perf_counter`, s.

    This base class shows nothing and reports no input, as the console needs.
    """

    @property
    def aspect(self) -> float:
        """Ratio of width to height."""
        return 1.0

    def prepare(self, page: Page) -> None:
        """Prepare what the page needs, so that its first frame is not delayed."""

    def present(self, page: Page) -> float:
        """Show a page for the first time and return the time of the flip."""
        del page
        return time.perf_counter()

    @property
    def offered_s(self) -> float:
        """Return the time from which presses may answer the current page.

        It is just before the page became visible.
        """
        return 0.0

    def refresh(self, page: Page) -> float:
        time.sleep(self.period_s)
        return self.present(page)

    def events(self) -> tuple[Input, ...]:
        """Return the inputs since the last call, in order."""
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
        """Return our clock minus the clock of the keyboard."""
        return 0.0

    def close(self) -> None:
        """Close the display. May be called more than once."""
