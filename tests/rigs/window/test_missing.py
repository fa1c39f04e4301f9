"""Errors for a missing display, PsychoPy or keyboard, and the lifetime of the key queue."""

import os
import sys
from importlib.util import find_spec

import pytest
from places import ROOT
from window_sitting import python

OPEN = """
from tactometry.errors import DeviceFailed
from tactometry.rigs.window import Window
try:
    Window(fullscreen=False, size=(320, 200))
except DeviceFailed as error:
    print(error, error.exit_status)
"""


def said(script, **environment):
    kept = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    done = python("-c", script, env=kept | environment, check=True)
    [line] = [line for line in done.stdout.splitlines() if line]
    return line


@pytest.fixture
def home(tmp_path):
    return str(tmp_path)


@pytest.mark.skipif(find_spec("psychopy") is None, reason="no psychopy: pip install 'tactometry[window]'")
@pytest.mark.parametrize("display_name", [{}, {"DISPLAY": ":987"}], ids=["unset", "nobody there"])
def test_window_reports_missing_display(home, display_name):
    line = said(OPEN, HOME=home, **display_name)
    assert line.startswith("window: found no display (")
    assert line.endswith("expected a screen; start it from a desktop session, or set DISPLAY 3")


def test_window_reports_missing_psychopy(home):
    line = said("import sys; sys.modules['psychopy'] = None" + OPEN, HOME=home)
    assert line.startswith("window: found no module 'psychopy', expected PsychoPy; install it with pip install")
    assert line.endswith("3")


@pytest.mark.parametrize(
    ("before", "words"),
    [
        # regression: pyglet creates no context when sphinx is loaded
        ("import sys; sys.modules['sphinx'] = sys", "window: found sphinx in this process"),
        (
            "from psychopy.hardware.keyboard import KeyboardDevice; KeyboardDevice.setBackend('event')",
            "keyboard: found the back end 'event', which loses answers, expected 'ptb'",
        ),
    ],
    ids=["sphinx", "event"],
)
def test_window_refuses_unsuitable_process(display, home, before, words):
    line = said(before + OPEN, HOME=home, DISPLAY=os.environ["DISPLAY"])
    assert line.startswith(words)
    assert line.endswith("3")


def test_adopt_explains_how_to_change_keyboard_backend(display, home):
    adopt = """
from psychopy import visual
from psychopy.hardware.keyboard import Keyboard
from tactometry.errors import DeviceFailed
from tactometry.rigs.window import Window
keys = Keyboard(backend="event")
window = visual.Window((320, 200), checkTiming=False)
try:
    Window.adopt(window)
except DeviceFailed as error:
    print(error, error.exit_status, window._closed)
"""
    line = said(adopt, HOME=home, DISPLAY=os.environ["DISPLAY"])
    assert line.startswith("keyboard: found the back end 'event', which loses answers, expected 'ptb'; create it")
    assert line.endswith("3 False")


@pytest.mark.parametrize(
    ("status", "told"), [(143, "SystemExit 143"), (0, "window: PsychoPy could not open a window (S")]
)
def test_only_signals_end_process_while_window_opens(display, home, status, told):
    quits = f"import sys\nfrom psychopy import visual\nvisual.Window = lambda **more: sys.exit({status})\n"
    ends = OPEN + "except SystemExit as end:\n    print('SystemExit', end.code)\n"
    assert said(quits + ends, HOME=home, DISPLAY=os.environ["DISPLAY"]).startswith(told)


def test_bench_imports_without_psychopy(home):
    script = "import sys, tactometry.rigs.bench; print([name for name in sys.modules if name.startswith('psychopy')])"
    assert said(script, HOME=home) == "[]"


SCRIPT = """
import os, time
from hands import Hands
from tactometry.rigs.window import Window

def n_threads():
    return len(os.listdir("/proc/self/task"))

def n_heard(window, n):
    found, deadline_s = [], time.perf_counter() + 20
    while len(found) < n and time.perf_counter() < deadline_s:
        time.sleep(0.05)
        found += window.events()
    return len(found)

hands = Hands(None)
window = Window(fullscreen=False, size=(320, 200))
for _ in range(5200):
    hands.tap("y", 0)
print(n_heard(window, 5200))
n_open = n_threads()
window.close()
window.close()
print(n_open - n_threads())
hands.tap("y", 0)
window = Window(fullscreen=False, size=(320, 200))
hands.tap("n", 0)
print(n_heard(window, 1), window.events())
window.close()
"""


def test_key_queue_survives_many_presses(display, tmp_path):
    """PsychoPy's default queue crashes after 5000 unread presses."""
    paths = os.pathsep.join([str(ROOT / "tests" / "support"), *sys.path])
    environment = {**os.environ, "HOME": str(tmp_path), "PYTHONPATH": paths}
    ran = python("-c", SCRIPT, env=environment)
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.split("\n")[:3] == ["5200", "1", "1 ()"]
