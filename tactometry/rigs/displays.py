"""Which screens the computer has, by the numbers that PsychoPy gives them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ..arguments.require import expect


@dataclass(frozen=True)
class ConnectedScreen:
    """One of them, from 0, with its size and its place among the others (pixels).

    >>> str(ConnectedScreen(1, 1920, 1080, 1280, 0))
    'screen 1: 1920 x 1080 px'
    """

    number: int
    width_px: int
    height_px: int
    x_px: int = 0
    y_px: int = 0

    def __str__(self) -> str:
        return f"screen {self.number}: {self.width_px} x {self.height_px} px"


def connected_screens(pyglet: Any) -> tuple[ConnectedScreen, ...]:
    """All screens of the desktop; pyglet is handed in, as one module alone imports PsychoPy and what comes with it."""
    return tuple(
        ConnectedScreen(number, int(screen.width), int(screen.height), int(screen.x), int(screen.y))
        for number, screen in enumerate(pyglet.canvas.get_display().get_screens())
    )


def check_screen(number: int, there: Sequence[ConnectedScreen]) -> None:
    """Whether there is a screen of this number.

    Raises `InvalidParameter` if there is none.
    """
    known = ", ".join(map(str, there))
    expect(0 <= number < len(there), "[screen] screen", number, f"one that is connected ({known})")
