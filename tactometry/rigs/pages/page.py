"""A page of the participant's screen as a value: what is drawn, what can be answered, how events answer it.

Lengths are in heights of the screen, with the origin in its middle and y upwards; so a page looks the same on
every screen that is wide enough.
"""

import time
from dataclasses import dataclass
from typing import Literal

from ...session.request import Facts
from ..frame_timing import PERIOD_WITHOUT_BLANK_S

Answer = int | str | tuple[int, int]
"""What a button stands for: an option or a place, a name, or (row, place)."""

PAPER = "#0E1116"
INK = "#F5F7FA"
QUIET = "#A7B1BD"
EDGE = "#6B7683"
ACCENT = "#56B4E9"
GOOD = "#F0E442"


@dataclass(frozen=True)
class Text:
    """Words around (x, y), `height` high, broken at `wrap_width`."""

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
    """A key that went down at `at_s` on `time.perf_counter`; `repeated`: that has been held down since."""

    name: str
    at_s: float
    repeated: bool = False


@dataclass(frozen=True)
class Click:
    """A press of the mouse button, or of a finger on a touch screen, at (x, y).

    While it is held and moves it is `dragged`: y stays where it began, so that it answers one row alone.
    """

    x: float
    y: float
    at_s: float
    dragged: bool = False


@dataclass(frozen=True)
class Closed:
    """The window was closed, by its frame or by the system."""

    at_s: float


Input = KeyDown | Click | Closed


@dataclass(frozen=True)
class Button:
    """What answers `answer`: one of the `keys`, or a click into the rectangle around (x, y).

    A key that is held down answers again and again if it `repeats`.
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

    def takes(self, event: Input) -> bool:
        """Whether this event presses the button.

        >>> Button(1, keys=("y",)).takes(KeyDown("y", at_s=0.0))
        True
        """
        if isinstance(event, KeyDown):
            return event.name in self.keys and (self.repeats or not event.repeated)
        if isinstance(event, Closed) or event.dragged:
            return False
        return abs(event.x - self.x) < self.width / 2 and abs(event.y - self.y) < self.height / 2

    def answer_to(self, event: Input) -> Answer | None:
        return self.answer if self.takes(event) else None


@dataclass(frozen=True)
class Slider:
    """`n_places` side by side in the rectangle around (x, y): a click answers the `row` with the place that it hits, a
    drag that began there with the one above or below it, beyond an end with the last.

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
        """The row and the place that an event answers."""
        if not isinstance(event, Click) or abs(event.y - self.y) >= self.height / 2:
            return None
        part = (event.x - self.x) / self.width + 0.5
        if not event.dragged and not 0 <= part < 1:
            return None
        return self.row, min(max(int(part * self.n_places), 0), self.n_places - 1)


@dataclass(frozen=True)
class Page:
    """Items, drawn in their order, and buttons; the pointer is shown where there is something to click."""

    items: tuple[Item, ...] = ()
    buttons: tuple[Button | Slider, ...] = ()

    def answer(self, event: Input) -> Answer | None:
        """What the first button that takes `event` answers; None for an event that answers nothing."""
        answers = (button.answer_to(event) for button in self.buttons)
        return next((answer for answer in answers if answer is not None), None)


class Display:
    """What a rig needs of a display and a keyboard. All times are on `time.perf_counter`, in seconds.

    As it stands here nothing is shown on it and nothing can be pressed: that of a console.
    """

    @property
    def aspect(self) -> float:
        """Width over height."""
        return 1.0

    def prepare(self, page: Page) -> None:
        """Build what the page needs, so that its first frame comes without delay."""

    def present(self, page: Page) -> float:
        """Show a page for the first time: the time of the flip."""
        del page
        return time.perf_counter()

    @property
    def offered_s(self) -> float:
        """When the page that stands was ready to be shown, just before it could be seen: what is pressed later may
        answer it. Its flip is stamped behind that, by how much only the system knows."""
        return 0.0

    def refresh(self, page: Page) -> float:
        time.sleep(self.period_s)
        return self.present(page)

    def events(self) -> tuple[Input, ...]:
        """What was pressed or closed since the last call, in order; each once."""
        return ()

    def give_back(self) -> None:
        """What was asked is answered: a screen that is somebody else's is theirs until the next page."""

    def facts(self) -> Facts:
        """What the head of the journal says of it."""
        return {}

    @property
    def period_s(self) -> float:
        return PERIOD_WITHOUT_BLANK_S

    def frame_intervals_s(self) -> list[float]:
        """Those since the last call."""
        return []

    def clock_offset_s(self) -> float:
        """Our clock minus that of the keyboard."""
        return 0.0

    def close(self) -> None:
        """May be called more than once."""
