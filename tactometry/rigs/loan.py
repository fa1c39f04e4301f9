"""A PsychoPy window of somebody else's script while our pages are on it; before and after it is as that script left it.

What PsychoPy keeps in the dictionary of a window is put back there, not assigned: its setters compute more.
"""

from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

from .pages.page import PAPER

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
"""What our pages are drawn with."""
EMPTY = ("_toDraw", "_toDrawDepths", "_toCall", "_toLog", "_editableChildren")
"""Lists that are empty meanwhile: stimuli with autoDraw, what waits for a flip, what a click may write in."""


class Loan:
    """Takes a window when a page is drawn, and gives it back.

    Parameters
    ----------
    psychopy : namespace
        The parts of PsychoPy that `tactometry.rigs.window` loads.
    window : psychopy.visual.Window
    keyboard : psychopy.hardware.keyboard.KeyboardDevice
        Its presses meanwhile are ours, those that wait are the script's.
    handlers : mapping of str to callable
        What hears the events of the window meanwhile.
    """

    def __init__(
        self, psychopy: SimpleNamespace, window: Any, keyboard: Any, handlers: Mapping[str, Callable[..., Any]]
    ) -> None:
        self._psychopy, self._window, self._keyboard, self._handlers = psychopy, window, keyboard, handlers
        self._theirs: dict[str, Any] | None = None

    def take(self) -> None:
        """From now on the window is ours, its ground is ours too, and nothing else is drawn on it."""
        if self._theirs is not None:
            return
        window = self._window
        window._setCurrent()  # the script may have several
        ours = {name: value for name, value in self._ours().items() if name in vars(window)}
        self._theirs = {name: vars(window)[name] for name in ours}
        self._looks = window.blendMode, window._color, window.mouseVisible, window.viewport, window.scissor
        vars(window).update(ours)
        self._rewind(push=True)
        window.blendMode, window.color = "avg", PAPER
        window.resetViewport()
        window.clearBuffer()
        self._typed, self._pressed = self._exchange([], [])
        window.winHandle.push_handlers(**self._handlers)

    def _ours(self) -> dict[str, Any]:
        return {**OURS, **{name: [] for name in EMPTY}, "_viewMatrixNeedsUpdate": True}

    def give_back(self) -> None:
        """The window is as it was; what is on the screen stays there until the script's own flip."""
        if self._theirs is None:
            return
        window, theirs = self._window, self._theirs
        self._theirs = None
        window._setCurrent()
        window.winHandle.pop_handlers()
        self._exchange(self._typed, self._pressed)
        self._keyboard._keysStillDown.clear()  # of a key that is down now, the release would tell as of a new press
        # an interval over our pages is none of the script's
        restarted = {"recordFrameIntervalsJustTurnedOn": bool(theirs["recordFrameIntervals"])}
        vars(window).update(theirs, _viewMatrixNeedsUpdate=True, **restarted)
        self._rewind(push=False)
        window.blendMode, window.color, window.mouseVisible, window.viewport, window.scissor = self._looks
        window.clearBuffer()
        if window.backgroundImage is not None:  # drawn by the flip before, in PsychoPy's order
            window.backgroundImage.draw()

    def _rewind(self, *, push: bool) -> None:
        """Put the script's transform of the view aside, or take it up again, where OpenGL itself keeps it."""
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
        """Of both keyboards of PsychoPy what waits to be read, for what shall wait there."""
        event, device = self._psychopy.event, self._keyboard
        self._window.winHandle.dispatch_events()
        device.dispatchMessages()
        waiting = event._keyBuffer, device.responses
        event._keyBuffer, device.responses = typed, pressed
        return waiting
