"""A display of its own for the tests that need one, and hands that press its keys and touch it."""

import os
import shutil
import subprocess
import threading
import time
from pathlib import Path

import pytest

SCREEN_PX = (1920, 1080)
ARTEFACTS = Path(__file__).resolve().parents[1] / "artefacts"
LONGEST_WAIT_S = 30.0


class Hands:
    """Presses keys and touches the screen by real X events, from a connection of its own."""

    def __init__(self, name):
        from Xlib import XK, X, display
        from Xlib.ext import xtest

        self._X, self._XK, self._xtest = X, XK, xtest
        self._display = display.Display(name)

    def _send(self, kind, detail=0, x=0, y=0):
        self._xtest.fake_input(self._display, kind, detail, x=x, y=y)
        self._display.sync()

    def tap(self, key, hold_s=0.03):
        """Press and release a key, named by its X keysym: when it went down and up on time.perf_counter."""
        code = self._display.keysym_to_keycode(self._XK.string_to_keysym(key))
        down_s = time.perf_counter()
        self._send(self._X.KeyPress, code)
        time.sleep(hold_s)
        self._send(self._X.KeyRelease, code)
        return down_s, time.perf_counter()

    def touch(self, x, y, window_px):
        """A click of no duration at (x, y) in heights of a window that lies in the corner of the screen."""
        width, height = window_px
        self._send(self._X.MotionNotify, x=round(width / 2 + x * height), y=round(height / 2 - y * height))
        self._send(self._X.ButtonPress, 1)
        self._send(self._X.ButtonRelease, 1)


@pytest.fixture(scope="session")
def display(tmp_path_factory):
    """A 24-bit X server that ends with its last client, and with this process at the latest.

    It must not be ended earlier: a client whose server goes takes the whole process with it. This connection
    is its first client and keeps it from ending between two windows.
    """
    missing = [name for name in ("Xvfb", "setpriv") if shutil.which(name) is None]
    if missing:
        pytest.skip(f"no {' and no '.join(missing)}: apt-get install xvfb util-linux")
    read_end, write_end = os.pipe()
    size = "{}x{}x24".format(*SCREEN_PX)
    command = ["setpriv", "--pdeathsig", "KILL", "Xvfb", "-displayfd", str(write_end), "-screen", "0", size]
    server = subprocess.Popen(
        [*command, "-terminate", "-nolisten", "tcp"],
        pass_fds=[write_end],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.close(write_end)
    with os.fdopen(read_end) as answer:
        number = answer.readline().strip()
    assert number, f"Xvfb ended with {server.poll()}"
    os.environ["DISPLAY"] = f":{number}"
    os.environ["HOME"] = str(tmp_path_factory.mktemp("home"))
    return Hands(f":{number}"), server


@pytest.fixture
def hands(display):
    return display[0]


@pytest.fixture(scope="session")
def window_px():
    return (1280, 800)


@pytest.fixture(scope="session")
def screen(display, window_px):
    """The one window of all tests in this process."""
    from tactometry.rigs.window import Window

    return Window(fullscreen=False, size=window_px)


@pytest.fixture(scope="session")
def artefacts():
    ARTEFACTS.mkdir(exist_ok=True)
    return ARTEFACTS


@pytest.fixture
def in_background():
    """Runs functions in threads, and lets their errors fail the test."""
    threads, errors = [], []

    def start(work, *args):
        def guarded():
            try:
                work(*args)
            except BaseException as error:
                errors.append(error)

        threads.append(threading.Thread(target=guarded, daemon=True))
        threads[-1].start()

    yield start
    for thread in threads:
        thread.join(LONGEST_WAIT_S)
        assert not thread.is_alive(), "a thread of the test did not end"
    if errors:
        raise errors[0]
