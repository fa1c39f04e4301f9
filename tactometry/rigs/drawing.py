"""Draw pages with PsychoPy's shapes and texts.

In PsychoPy 2026.2.5 writing an attribute of a shape costs more than drawing it, and `draw` costs more in Python than in
OpenGL. So each text and each look of a shape is recorded once in an OpenGL list.
"""

import functools
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from .pages.page import PAPER, Box, Disc, Page, Picture, Text

FONT = "Noto Sans"
PIXELS_PER_LINE = 300
N_EDGES_BOX = 4
FLAT_PX = 0.1
"""Largest distance of a polygon from its circle, as lines of many short edges are slow in software rendering."""
Look = tuple[int, str | None, str | None]
"""Edges, fill and line of a shape, without its position."""


def n_edges(radius: float) -> int:
    """Return the edges of a polygon (radius in pixels) whose middles lie at most `FLAT_PX` inside of its circle.

    >>> n_edges(26.0), n_edges(160.0)
    (36, 89)
    """
    return math.ceil(math.pi / math.acos(1 - min(FLAT_PX / radius, 0.1)))


class Canvas:
    """Draws pages into the back buffer of a PsychoPy window with ``units="height"``.

    - `psychopy`: `visual` and `pyglet`, as loaded by the window module.
    """

    def __init__(self, psychopy: SimpleNamespace, window: Any) -> None:
        self._visual, self._gl, self._window = psychopy.visual, psychopy.pyglet.gl, window
        assets = Path(psychopy.visual.__file__).parents[1] / "assets" / "fonts"
        with (assets / "NotoSans-Regular.ttf").open("rb") as face:
            psychopy.pyglet.font.add_file(face)
        self._list, self._picture = functools.cache(self._recorded), functools.cache(self._image)
        self._stimuli: list[Any] = []
        """Recorded stimuli, kept because OpenGL discards the letters of a text when its font is deleted."""

    def draw(self, page: Page) -> None:
        """Draw the items of a page in order."""
        gl, (width, height) = self._gl, self._window.size
        self._window._setCurrent()  # lists belong to one context, and another window may have been drawn meanwhile
        for item in page.items:
            if isinstance(item, Text):  # PsychoPy draws text at its position regardless of the matrix
                gl.glCallList(self._list(item))
                continue
            if isinstance(item, Picture):  # a list cannot contain its texture
                self._picture(item).draw()
                continue
            look, size = self._look(item)
            drawing = self._list(look)
            gl.glPushMatrix()
            # in half widths and heights of the window, as PsychoPy leaves the matrix
            gl.glTranslatef(2 * item.x * height / width, 2 * item.y, 0)
            gl.glScalef(*size, 1)
            gl.glCallList(drawing)
            gl.glPopMatrix()

    def _look(self, item: Box | Disc) -> tuple[Look, tuple[float, float]]:
        """Return the look of an item, and its size relative to the recorded one."""
        if isinstance(item, Box):
            return (N_EDGES_BOX, item.fill, item.line), (item.width, item.height)
        return (n_edges(item.radius * self._window.size[1]), item.fill, item.line), (item.radius, item.radius)

    def _recorded(self, look: Text | Look) -> int:
        """Record the list that draws a text, or a shape in the middle of the window."""
        stimulus = self._text(look) if isinstance(look, Text) else self._shape(*look)
        self._stimuli.append(stimulus)
        drawing = int(self._gl.glGenLists(1))
        self._gl.glNewList(drawing, self._gl.GL_COMPILE)
        try:
            stimulus.draw()
        finally:
            self._gl.glEndList()
        return drawing

    def _shape(self, edges: int, fill: str | None, line: str | None) -> Any:
        """Make a box or a circle of size 1; its line is as wide at any size."""
        width = max(2, round(self._window.size[1] / PIXELS_PER_LINE)) if line else 0
        look = {"fillColor": fill, "lineColor": line, "lineWidth": width, "autoLog": False}
        if edges == N_EDGES_BOX:
            return self._visual.Rect(self._window, width=1, height=1, **look)
        return self._visual.Circle(self._window, radius=1, edges=edges, **look)

    def _image(self, item: Picture) -> Any:
        size = item.width, item.height
        return self._visual.ImageStim(self._window, item.path, pos=(item.x, item.y), size=size, autoLog=False)

    def _text(self, item: Text) -> Any:
        return self._visual.TextStim(
            self._window,
            text=item.words,
            font=FONT,
            pos=(item.x, item.y),
            height=item.height,
            color=item.colour,
            wrapWidth=item.wrap_width,
            anchorHoriz=item.align,
            alignText=item.align,
            autoLog=False,
        )


OURS: Mapping[str, Any] = {
    "units": "height",
    "viewPos": None,
    "viewScale": None,
    "viewOri": 0.0,
    "waitBlanking": True,
    "backgroundImage": None,
    "recordFrameIntervals": False,
    "_showSplash": False,
}
"""Window settings for the pages of Tactometry."""
EMPTY = ("_toDraw", "_toDrawDepths", "_toCall", "_toLog", "_editableChildren")
"""Window lists that are empty meanwhile: autoDraw stimuli, calls on flip, editable stimuli."""


class BorrowedWindow:
    """Takes a window of a PsychoPy script when a page is drawn, and gives it back.

    - `keyboard`: New key presses are ours, waiting ones are the script's.
    - `handlers`: Handlers of window events meanwhile.
    """

    def __init__(
        self, psychopy: SimpleNamespace, window: Any, keyboard: Any, handlers: Mapping[str, Callable[..., Any]]
    ) -> None:
        self._psychopy, self._window, self._keyboard, self._handlers = psychopy, window, keyboard, handlers
        self._theirs: dict[str, Any] | None = None

    def take(self) -> None:
        """Take the window: our background, and nothing else is drawn on it."""
        if self._theirs is not None:
            return
        window = self._window
        window._setCurrent()  # the script may have several windows
        page_state = {**OURS, **{name: [] for name in EMPTY}, "_viewMatrixNeedsUpdate": True}
        ours = {name: value for name, value in page_state.items() if name in vars(window)}
        self._theirs = {name: vars(window)[name] for name in ours}
        self._looks = window.blendMode, window._color, window.mouseVisible, window.viewport, window.scissor
        vars(window).update(ours)
        self._rewind(push=True)
        window.blendMode, window.color = "avg", PAPER
        window.resetViewport()
        window.clearBuffer()
        self._typed, self._pressed = self._exchange([], [])
        window.winHandle.push_handlers(**self._handlers)

    def give_back(self) -> None:
        """Restore the window; its picture stays until the script's next flip."""
        if self._theirs is None:
            return
        window, theirs = self._window, self._theirs
        self._theirs = None
        window._setCurrent()
        window.winHandle.pop_handlers()
        self._exchange(self._typed, self._pressed)
        self._keyboard._keysStillDown.clear()  # otherwise releasing a held key would report a new press
        # frame intervals of these pages do not belong to the script
        restarted = {"recordFrameIntervalsJustTurnedOn": bool(theirs["recordFrameIntervals"])}
        vars(window).update(theirs, _viewMatrixNeedsUpdate=True, **restarted)
        self._rewind(push=False)
        window.blendMode, window.color, window.mouseVisible, window.viewport, window.scissor = self._looks
        window.clearBuffer()
        if window.backgroundImage is not None:  # the previous flip draws it, in PsychoPy's order
            window.backgroundImage.draw()

    def _rewind(self, *, push: bool) -> None:
        """Save or restore the script's view transform in OpenGL."""
        if not self._window.USE_LEGACY_GL:
            return
        gl = self._psychopy.pyglet.gl
        gl.glMatrixMode(gl.GL_MODELVIEW)
        if push:
            gl.glPushMatrix()
            gl.glLoadIdentity()
        else:
            gl.glPopMatrix()

    def _exchange(self, typed: list[Any], pressed: list[Any]) -> tuple[list[Any], list[Any]]:
        """Exchange the waiting events of both PsychoPy keyboards."""
        event, device = self._psychopy.event, self._keyboard
        self._window.winHandle.dispatch_events()
        device.dispatchMessages()
        waiting = event._keyBuffer, device.responses
        event._keyBuffer, device.responses = typed, pressed
        return waiting
