"""Plots and sections of the page, redrawn only after changes."""

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from tactometry.session.progress import AnsweredTouch, Progress

from .watcher import Drawn, Sight, TouchDrawn, Watcher

if TYPE_CHECKING:  # The analysis libraries take seconds to load. The address is printed before that.
    from .curve import Answers

CURVE_EVERY_S = 8.0
"""Shortest interval (s) between fits. A fit takes 40 ms, so this limits it to 0.5 % of a core."""


class Scenery:
    """Page of a watched data set. `clock` returns monotonic time (s)."""

    def __init__(self, watcher: Watcher, clock: Callable[[], float] = time.monotonic) -> None:
        self._watcher, self._clock = watcher, clock
        self._sight, self._drawn = Sight(), Drawn()
        self._curve_of: Progress | None = None
        self._touch: AnsweredTouch | None = None
        self._answers: Answers | None = None
        self._due_s = -float("inf")
        self._shown: tuple[Sight, Drawn, Mapping[str, str]] | None = None

    def page(self) -> str:
        """Return the HTML of the page in its current state."""
        from .page import page

        self._look()
        return page(self._sight, self._drawn)

    def sections(self) -> Mapping[str, str]:
        """Return the HTML of each section. Redraws sections that changed."""
        from .page import sections

        self._look()
        if self._shown is None or self._shown[0] is not self._sight or self._shown[1] is not self._drawn:
            self._shown = self._sight, self._drawn, sections(self._sight, self._drawn)
        return self._shown[2]

    def _look(self) -> None:
        self._sight = self._watcher.look()
        now_s, progress = self._clock(), self._sight.progress
        touch = next(reversed(progress.touches), None)
        if touch is not self._touch:
            self._touch = touch
            from .traces import draw_touch

            drawn = TouchDrawn() if touch is None else draw_touch(self._watcher.root, touch)
            self._drawn = replace(self._drawn, touch=drawn)
        if progress is not self._curve_of and now_s >= self._due_s:
            self._curve_of = progress
            from .curve import answers_of, curve_plot

            answers = answers_of(progress)
            if answers != self._answers:
                self._answers, self._due_s = answers, now_s + CURVE_EVERY_S
                self._drawn = replace(self._drawn, curve=None if answers is None else curve_plot(answers))
