"""Participant's screen and keyboard with PsychoPy, imported only here.

Measured with PsychoPy 2026.2.5: text and plain shapes are fast to draw. Only the `ptb` back end reports all keys,
its clock is the wall clock on Linux, and polling misses short presses.
"""

import ctypes
import sys
import time
import warnings
from collections.abc import Callable
from contextlib import ExitStack
from importlib.metadata import version
from types import SimpleNamespace
from typing import Any, Self

import numpy as np

from ..arguments.require import expect
from ..devices.clock_map import clock_offset_s
from ..errors import DeviceFailed
from ..session.request import Facts
from .drawing import BorrowedWindow, Canvas
from .frame_timing import Pacer, Rhythm, nominal_rate_hz, rhythm_of
from .keyboard import (
    ConnectedScreen,
    FreshPresses,
    HeldKeys,
    check_screen,
    failing_as,
    keyboard_of_script,
    open_keyboard,
)
from .pages.page import PAPER, Click, Closed, Display, Input, KeyDown, Page

N_MEASURED_FRAMES, N_MEASUREMENTS = 20, 3
VIEWING_DISTANCE_CM = 60.0
UNSTATED_WIDTH_CM = 50.0
NO_DISPLAY = "window: found no display", ", expected a screen; start it from a desktop session, or set DISPLAY"


def _psychopy() -> SimpleNamespace:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from psychopy import logging

        logging.console.setLevel(logging.ERROR)
        import pyglet

        if getattr(sys, "is_pyglet_doc_run", False):
            raise DeviceFailed(
                "window: found sphinx in this process, which stops pyglet from drawing, expected a process without it"
                "; start the session in another process, or import tactometry.rigs.window and call load_psychopy first"
            )
        from psychopy import event, monitors, visual
        from psychopy.hardware import keyboard
    parts = {"pyglet": pyglet, "event": event, "monitors": monitors, "visual": visual, "keyboard": keyboard}
    return SimpleNamespace(logging=logging, **parts)


def load_psychopy() -> SimpleNamespace:
    """Import PsychoPy.

    Raises `DeviceFailed` if PsychoPy or a system library is missing, if there is no display, or if sphinx is
    imported.
    """
    with failing_as(*NO_DISPLAY):
        try:
            return _psychopy()
        except ModuleNotFoundError as error:
            raise DeviceFailed(
                f"window: found no module {error.name!r}, expected PsychoPy; install it with "
                "pip install 'tactometry[window]' on Python 3.11 or 3.12"
            ) from error
        except ImportError as error:
            raise DeviceFailed(
                f"window: a system library is missing ({error}); on Debian: "
                "apt-get install libgl1 libglu1-mesa libfontconfig1 libportaudio2"
            ) from error


class Window(Display):
    """A `Display` with PsychoPy.

    - `fullscreen`: True fills the whole screen, else the window has `size` (pixels).
    - `screen`: Number of the display, from 0.

    Raises `InvalidParameter` if no display has this number. Raises `DeviceFailed` if there is no display, or no
    keyboard that reports all presses.
    """

    def __init__(self, *, fullscreen: bool, size: tuple[int, int] | None = None, screen: int = 0) -> None:
        self._psychopy = load_psychopy()
        check_screen(screen, self.screens())
        self._begin(_open_window(self._psychopy, fullscreen=fullscreen, size=size, screen=screen), adopted=False)

    def screens(self) -> tuple[ConnectedScreen, ...]:
        """Return the connected displays."""
        with failing_as(*NO_DISPLAY):
            screens = self._psychopy.pyglet.canvas.get_display().get_screens()
            return tuple(ConnectedScreen(n, int(each.width), int(each.height)) for n, each in enumerate(screens))

    @classmethod
    def adopt(cls, window: Any) -> Self:
        """Use the window of a PsychoPy script to show pages.

        From the first page until `give_back` the pages set the background and receive all input, and the script's
        stimuli are hidden. Then everything is restored. The window is never closed here.

        Raises `InvalidParameter` if the window is not open, `DeviceFailed` if the script's keyboard loses key
        presses.
        """
        psychopy = load_psychopy()
        is_window = isinstance(window, psychopy.visual.Window)
        found = "a closed window" if is_window else f"{type(window).__name__}"
        is_open = is_window and not window._closed
        expect(is_open, "Window.adopt", found, "an open psychopy.visual.Window")
        adopted = cls.__new__(cls)
        adopted._psychopy = psychopy
        adopted._begin(window, adopted=True)
        return adopted

    def _begin(self, window: Any, *, adopted: bool) -> None:
        self._window, self._adopted, self._opened = window, adopted, ExitStack()
        if not adopted:
            self._opened.callback(window.close)
        try:
            self._keyboard = (keyboard_of_script if adopted else open_keyboard)(self._psychopy)
            handlers: dict[str, Callable[..., Any]] = {
                "on_mouse_press": self._on_mouse_press,
                "on_mouse_drag": self._on_mouse_drag,
                "on_close": self._on_close,
            }
            self._borrowed = BorrowedWindow(self._psychopy, window, self._keyboard, handlers)
            self._opened.callback(self._borrowed.give_back if adopted else self._keyboard.stop)
            self._canvas = Canvas(self._psychopy, self._window)
            self._fresh, self._held = FreshPresses(), HeldKeys(self._keyboard.getState)
            self._pressed: list[Input] = []
            self._begun_y = 0.0
            self._intervals_s: list[float] = []
            self._offered_s = self._flipped_s = time.perf_counter()
            self._pacer = Pacer(self._rhythm())
        except BaseException:
            self.close()
            raise

    def give_back(self) -> None:
        if self._adopted:
            self._borrowed.give_back()

    def _rhythm(self) -> Rhythm:
        """Measure the frame period again if opening the window disturbed it."""
        self._borrowed.take()
        nominal_hz = nominal_rate_hz(_mode_of(self._window.winHandle.screen))
        for _ in range(N_MEASUREMENTS):
            flips_s = [self._flip() for _ in range(N_MEASURED_FRAMES + 1)]
            rhythm = rhythm_of(np.diff(flips_s).tolist(), nominal_hz)
            if rhythm.trusted or rhythm.in_software:
                break
        self.give_back()
        return rhythm

    def _on_mouse_press(self, x: float, y: float, *how: int) -> None:
        del how
        x, self._begun_y = self._in_heights(x, y)
        self._pressed.append(Click(x, self._begun_y, at_s=time.perf_counter()))

    def _on_mouse_drag(self, x: float, y: float, *how: float) -> None:
        del how
        x, _ = self._in_heights(x, y)
        self._pressed.append(Click(x, self._begun_y, at_s=time.perf_counter(), dragged=True))

    def _in_heights(self, x: float, y: float) -> tuple[float, float]:
        width, height = self._window.winHandle.get_size()
        return (x - width / 2) / height, (y - height / 2) / height

    def _on_close(self) -> bool:
        self._pressed.append(Closed(at_s=time.perf_counter()))
        return True

    @property
    def aspect(self) -> float:
        width, height = self._window.size
        return float(width / height)

    def prepare(self, page: Page) -> None:
        self._draw(page)
        self._window.clearBuffer()

    def present(self, page: Page) -> float:
        self._draw(page)
        self._window.mouseVisible = bool(page.buttons)
        self._psychopy.pyglet.gl.glFinish()  # wait for slow software rendering
        self._window.winHandle.dispatch_events()  # clicks get their time stamp when they are dispatched
        self._offered_s = time.perf_counter()
        self._flipped_s = self._flip()
        return self._flipped_s

    @property
    def offered_s(self) -> float:
        return self._offered_s

    def refresh(self, page: Page) -> float:
        self._draw(page)
        self._pacer.wait()
        before_s, self._flipped_s = self._flipped_s, self._flip()
        self._pacer.after(self._flipped_s - before_s)
        self._intervals_s.append(self._flipped_s - before_s)
        return self._flipped_s

    def _flip(self) -> float:
        self._window.flip()
        return time.perf_counter()

    def events(self) -> tuple[Input, ...]:
        self._window.winHandle.dispatch_events()
        clicks, self._pressed = self._pressed, []
        ask: Callable[..., list[Any]] = self._keyboard.getKeys
        reported = [(key.name, key.tDown) for released in (False, True) for key in ask(waitRelease=released)]
        now_s = time.perf_counter()
        ahead_s = self.clock_offset_s()
        fresh = [(name, min(down_s + ahead_s, now_s)) for name, down_s in self._fresh.of(reported)]
        again = self._held.repeats(fresh, now_s)
        keys = [*(KeyDown(*press) for press in fresh), *(KeyDown(name, now_s, repeated=True) for name in again)]
        return tuple(sorted([*clicks, *keys], key=lambda event: event.at_s))

    def facts(self) -> Facts:
        width, height = (int(pixels) for pixels in self._window.size)
        rhythm = self._pacer.rhythm
        return {
            "display_width_px": width,
            "display_height_px": height,
            "fullscreen": bool(self._window._isFullScr),
            "window_adopted": self._adopted,
            "frame_period_measured_s": round(rhythm.measured_s, 6),
            "frame_period_nominal_s": None if rhythm.nominal_s is None else round(rhythm.nominal_s, 6),
            "frame_period_trusted": rhythm.trusted,
            "frame_period_s": round(rhythm.period_s, 6),
            "frames_paced_in_software": self._pacer.in_software,
            "psychopy": version("psychopy"),
            "psychtoolbox": version("psychtoolbox"),
            "keyboard": str(self._keyboard.getBackend()),
        }

    @property
    def period_s(self) -> float:
        return self._pacer.rhythm.period_s

    @property
    def caution(self) -> str | None:
        return self._pacer.rhythm.caution

    def frame_intervals_s(self) -> list[float]:
        intervals_s, self._intervals_s = self._intervals_s, []
        return intervals_s

    def clock_offset_s(self) -> float:
        return clock_offset_s(self._psychopy.logging.defaultClock.getTime)

    def close(self) -> None:
        self._opened.close()

    def picture(self, page: Page) -> Any:
        """Draw the page and return it as a PIL image without showing it."""
        self._draw(page)
        image = self._window.getMovieFrame(buffer="back").copy()
        self._window.movieFrames = []
        self._window.clearBuffer()
        return image

    def _draw(self, page: Page) -> None:
        self._borrowed.take()
        self._canvas.draw(page)


def _mode_of(screen: Any) -> Any:
    """Return the mode of a screen, or None.

    None if the X server does not support modes, because Xlib would print an error.
    """
    server = getattr(screen.display, "_display", None)
    if server is not None:
        from pyglet.libs.x11 import xlib

        unused = [ctypes.byref(ctypes.c_int()) for _ in range(3)]
        if not xlib.XQueryExtension(server, b"XFree86-VidModeExtension", *unused):
            return None
    return screen.get_mode()


def _open_window(psychopy: SimpleNamespace, *, fullscreen: bool, size: tuple[int, int] | None, screen: int) -> Any:
    monitor = psychopy.monitors.Monitor("tactometry", width=UNSTATED_WIDTH_CM, distance=VIEWING_DISTANCE_CM)
    monitor.setSizePix(size or (1280, 800))
    cure = "; check that DISPLAY names a screen with 24-bit colour and OpenGL"
    with failing_as("window: PsychoPy could not open a window", cure):
        return psychopy.visual.Window(
            size=size or (1280, 800),
            fullscr=fullscreen,
            screen=screen,
            monitor=monitor,
            units="height",
            color=PAPER,
            checkTiming=False,
            allowGUI=not fullscreen,
            gammaErrorPolicy="ignore",
            autoLog=False,
        )
