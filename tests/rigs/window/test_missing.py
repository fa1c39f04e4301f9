"""Errors for a missing display, PsychoPy or keyboard."""

import os
import subprocess
import sys
from importlib.util import find_spec

import pytest
from patience import LONGEST_PROGRAM_S

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
    pipes = {"capture_output": True, "text": True, "timeout": LONGEST_PROGRAM_S}
    process = subprocess.run([sys.executable, "-c", script], env=kept | environment, check=True, **pipes)
    [line] = [line for line in process.stdout.splitlines() if line]
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
