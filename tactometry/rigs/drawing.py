"""Drawing of pages with PsychoPy shapes and texts.

In PsychoPy 2026.2.5, setting an attribute of a shape takes longer than drawing it, and most of the time of `draw` is
spent in Python. So each text and each kind of shape is compiled once into an OpenGL display list.
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
"""Largest deviation of a polygon from its circle, in pixels. Outlines with many edges are slow in software
rendering."""
Look = tuple[int, str | None, str | None]
"""Number of edges, fill and line colour of a shape."""


def n_edges(radius: float) -> int:
    """Return the number of edges of a polygon that stands for a circle.

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
        """PsychoPy stimuli that were compiled into lists. OpenGL discards the letters of a text when its font is
        deleted."""

    def draw(self, page: Page) -> None:
        """Draw the items of a page in order."""
        gl, (width, height) = self._gl, self._window.size
        self._window._setCurrent()  # display lists belong to one OpenGL context; another window may be current
        for item in page.items:
            if isinstance(item, Text):  # PsychoPy ignores the matrix when it draws text
                gl.glCallList(self._list(item))
                continue
            if isinstance(item, Picture):  # a display list cannot contain the texture
                self._picture(item).draw()
                continue
            look, size = self._look(item)
            drawing = self._list(look)
            gl.glPushMatrix()
            # PsychoPy's matrix uses half widths and heights of the window
            gl.glTranslatef(2 * item.x * height / width, 2 * item.y, 0)
            gl.glScalef(*size, 1)
            gl.glCallList(drawing)
            gl.glPopMatrix()

    def _look(self, item: Box | Disc) -> tuple[Look, tuple[float, float]]:
        """Return the kind of shape, and its size relative to the compiled one."""
        if isinstance(item, Box):
            return (N_EDGES_BOX, item.fill, item.line), (item.width, item.height)
        return (n_edges(item.radius * self._window.size[1]), item.fill, item.line), (item.radius, item.radius)

    def _recorded(self, look: Text | Look) -> int:
        """Compile a text, or a shape of size 1 in the middle of the window."""
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
        """Create a box or circle of size 1 whose line width does not scale."""
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
"""Attributes of a window that Tactometry's pages need."""
EMPTY = ("_toDraw", "_toDrawDepths", "_toCall", "_toLog", "_editableChildren")
"""Lists of a window that are emptied while pages are shown: autoDraw stimuli, calls on flip, editable stimuli."""


class BorrowedWindow:
    """Window of a PsychoPy script, borrowed while a page is shown.

    - `keyboard`: Keyboard of the script. Waiting key presses stay with the script.
    - `handlers`: Handlers of window events while the page is shown.
    """

    def __init__(
        self, psychopy: SimpleNamespace, window: Any, keyboard: Any, handlers: Mapping[str, Callable[..., Any]]
    ) -> None:
        self._psychopy, self._window, self._keyboard, self._handlers = psychopy, window, keyboard, handlers
        self._theirs: dict[str, Any] | None = None

    def take(self) -> None:
        """Take over the window: set the background and hide the script's stimuli."""
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
        """Restore the window. The page stays visible until the script's next flip."""
        if self._theirs is None:
            return
        window, theirs = self._window, self._theirs
        self._theirs = None
        window._setCurrent()
        window.winHandle.pop_handlers()
        self._exchange(self._typed, self._pressed)
        self._keyboard._keysStillDown.clear()  # otherwise the release of a held key would be reported as a new press
        # exclude the frame intervals of these pages from the script's
        restarted = {"recordFrameIntervalsJustTurnedOn": bool(theirs["recordFrameIntervals"])}
        vars(window).update(theirs, _viewMatrixNeedsUpdate=True, **restarted)
        self._rewind(push=False)
        window.blendMode, window.color, window.mouseVisible, window.viewport, window.scissor = self._looks
        window.clearBuffer()
        if window.backgroundImage is not None:  # PsychoPy draws it as part of the previous flip
            window.backgroundImage.draw()

    def _rewind(self, *, push: bool) -> None:
        """Save or restore the OpenGL view transform of the script."""
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
