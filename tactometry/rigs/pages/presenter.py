"""Presentation of pages: frames, and answers that change the page."""

import time
from collections.abc import Callable
from typing import TypeVar

from .page import Answer, Closed, Display, Input, KeyDown, Page

S = TypeVar("S")
Dress = Callable[[Page, float], Page]
"""Function that adds items to a page at a time (s on `time.perf_counter`)."""
Attend = Callable[[tuple[Input, ...]], bool]
"""Handler of the inputs of a frame and of orders. Returns True if the session was paused."""


CLOSED = "the window was closed"


def as_it_is(page: Page, now_s: float) -> Page:
    del now_s
    return page


def reason_to_end(events: tuple[Input, ...]) -> str | None:
    """Return why events end a session: Escape or a closed window.

    >>> reason_to_end((KeyDown("y", 1.0), Closed(2.0))), reason_to_end((KeyDown("escape", 1.0),)), reason_to_end(())
    ('the window was closed', 'Escape was pressed', None)
    """
    for event in events:
        if isinstance(event, Closed):
            return CLOSED
        if isinstance(event, KeyDown) and event.name == "escape":
            return "Escape was pressed"
    return None


def linger(screen: Display, page: Page, longest_s: float) -> None:
    """Show a final page until an input, or for `longest_s`."""
    shown_s = screen.present(page)
    while time.perf_counter() < shown_s + longest_s and not any(
        event.at_s > screen.offered_s for event in screen.events()
    ):
        screen.refresh(page)


class Presenter:
    """Presenter of pages. In each frame `attend` may stop or pause the session.

    `paused_until_s` is the end of the last pause on `time.perf_counter`.
    """

    def __init__(self, screen: Display, attend: Attend) -> None:
        self.screen = screen
        self.paused_until_s = -float("inf")
        self._attend = attend

    def frame(self, page: Page) -> None:
        """Show one frame. Inputs other than Escape are discarded."""
        self.screen.refresh(page)
        self._events()

    def hold(
        self, end_s: float, page: Page, dress: Dress = as_it_is, each_frame: Callable[[], None] = lambda: None
    ) -> None:
        """Show frames until `end_s`. A pause extends the time."""
        while (now_s := time.perf_counter()) < end_s:
            each_frame()
            self.frame(dress(page, now_s))
            if self.paused_until_s > now_s:
                end_s += self.paused_until_s - now_s

    def converse(
        self,
        state: S,
        view: Callable[[S], Page],
        after: Callable[[S, Answer], tuple[S, bool]],
        each_frame: Callable[[S], None] = lambda state: None,
    ) -> tuple[S, float, float]:
        """Show a page until it is confirmed; return state, onset and end.

        Answers change the state, and `view` returns its page. Presses before the page is visible are ignored. A
        press between its first visibility and the onset stamp counts at the onset. After a pause the page is shown
        again, with a new onset.
        """
        page = view(state)
        onset_s = self.screen.present(page)
        while True:
            each_frame(state)
            for event in self._events():
                answer = page.answer(event) if event.at_s >= self.screen.offered_s else None
                if answer is not None:
                    state, settled = after(state, answer)
                    if settled:
                        return state, onset_s, max(event.at_s, onset_s)
                    page = view(state)
            if self.paused_until_s > onset_s:  # discard answers from before the pause, and exclude its duration
                onset_s = self.screen.present(page)
            self.screen.refresh(page)

    def _events(self) -> tuple[Input, ...]:
        events = self.screen.events()
        if not self._attend(events):
            return events
        self.end_pause()
        return ()

    def end_pause(self) -> None:
        self.paused_until_s = time.perf_counter()
