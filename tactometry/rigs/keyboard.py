"""PsychoPy's keyboard, and the connected screens."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

from ..arguments.require import expect
from ..errors import DeviceFailed, ended_by_signal

N_WAITING_PRESSES = 50_000
"""Size of the key queue. A full queue crashes the process, because psychtoolbox 3.0.22 then prints from a thread
without Python's lock (observed at PsychoPy's default of 5 000)."""


@contextmanager
def failing_as(what: str, cure: str) -> Iterator[None]:
    """Convert PsychoPy's exceptions in the body to one `DeviceFailed`.

    Its message states the cause between `what` and `cure`. This also applies if the body ends the program without a
    signal.
    """
    try:
        yield
    except (Exception, SystemExit) as error:
        if ended_by_signal(error) or isinstance(error, DeviceFailed):
            raise
        raise DeviceFailed(f"{what} ({type(error).__name__}: {error}){cure}") from error


def open_keyboard(psychopy: SimpleNamespace) -> Any:
    cure = "; on macOS allow the terminal 'Input Monitoring' in the privacy settings"
    with failing_as("keyboard: PsychoPy could not open a keyboard", cure):
        keyboard = psychopy.keyboard.Keyboard(backend="ptb", bufferSize=2 * N_WAITING_PRESSES).device
        keyboard.start()
        keyboard.clearEvents()
    if keyboard.getBackend() != "ptb":
        raise _lossy(keyboard, "install psychtoolbox and, on Debian, apt-get install libportaudio2")
    return keyboard


def keyboard_of_script(psychopy: SimpleNamespace) -> Any:
    """Return PsychoPy's keyboard of the process, which keeps the script's clock."""
    device = psychopy.keyboard.KeyboardDevice._instance
    if device is None:
        return open_keyboard(psychopy)
    if device.getBackend() != "ptb":
        cure = "create it with keyboard.Keyboard(backend='ptb'), in Builder: settings, Input, PsychToolbox"
        raise _lossy(device, cure)
    device.start()
    return device


def _lossy(keyboard: Any, cure: str) -> DeviceFailed:
    result = f"found the back end {keyboard.getBackend()!r}, which loses answers, expected 'ptb'"
    return DeviceFailed(f"keyboard: {result}; {cure}")


N_REMEMBERED = 256


class FreshPresses:
    """Filter that reports each press, a (name, time) pair, once.

    PsychoPy reports a held key when it is pressed and again, with the old time, when it is released. It reports a
    short press only at its release. Querying both reports every press, some of them twice.
    """

    def __init__(self) -> None:
        self._seen: deque[tuple[str, float]] = deque(maxlen=N_REMEMBERED)

    def of(self, reported: Iterable[tuple[str, float]]) -> list[tuple[str, float]]:
        """Return the presses that were not reported before, in order of time."""
        fresh = sorted(set(reported) - set(self._seen), key=lambda press: press[1])
        self._seen.extend(fresh)
        return fresh


REPEATING = ("left", "right", "up", "down")
REPEAT_AFTER_S, REPEAT_EVERY_S = 0.4, 0.03
"""Delay and interval of key repeats, as on a desktop."""


class HeldKeys:
    """Repetition of the arrow key that was pressed last, while it is held."""

    def __init__(self, state_of: Callable[[str], bool]) -> None:
        self._state_of, self._name, self._next_s = state_of, "", 0.0

    def repeats(self, fresh: Iterable[tuple[str, float]], now_s: float) -> list[str]:
        """Return the repetitions that are due after these new presses."""
        for name, down_s in fresh:
            self._name, self._next_s = name, down_s + REPEAT_AFTER_S
        if self._name not in REPEATING or now_s < self._next_s:
            return []
        if not self._state_of(self._name):
            self._name = ""
            return []
        n_due = 1 + int((now_s - self._next_s) / REPEAT_EVERY_S)  # independent of the frame duration
        self._next_s += n_due * REPEAT_EVERY_S
        return [self._name] * n_due


@dataclass(frozen=True)
class ConnectedScreen:
    """Connected screen, numbered from 0, with its size in pixels."""

    number: int
    width_px: int
    height_px: int

    def __str__(self) -> str:
        return f"screen {self.number}: {self.width_px} x {self.height_px} px"


def check_screen(number: int, there: Sequence[ConnectedScreen]) -> None:
    """Raise an error if no screen has this number."""
    known = ", ".join(map(str, there))
    expect(0 <= number < len(there), "[screen] screen", number, f"a connected screen ({known})")
