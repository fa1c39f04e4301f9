"""Selection of the participant's screen on an X server with two monitors."""

import os
import shutil
import subprocess
from importlib.util import find_spec

import pytest
from window_sitting import python

from tactometry.errors import InvalidParameter
from tactometry.rigs.keyboard import ConnectedScreen, check_screen

BENCH = "[screen]\nfullscreen = false\nwidth_px = 400\nheight_px = 320\nscreen = {}\n"
HALVES = """
import sys
from Xlib import display
from Xlib.ext import randr
from Xlib.protocol import rq

class SetMonitor(rq.Request):  # python-xlib 0.33 cannot pack its own request, which nests a list
    _request = rq.Struct(
        rq.Card8("opcode"), rq.Opcode(43), rq.RequestLength(), rq.Window("window"), *randr.MonitorInfo.fields
    )

server = display.Display(sys.argv[1])
root = server.screen().root
[output] = root.xrandr_get_screen_resources().outputs
for name, x, width, outputs in (("left", 0, 640, [output]), ("right", 640, 800, [])):
    place = {"x": x, "y": 0, "width_in_pixels": width, "height_in_pixels": 600}
    size = {"width_in_millimeters": 300, "height_in_millimeters": 200}
    named = {"name": server.intern_atom(name), "primary": x == 0, "automatic": False}
    opcode = server.display.get_extension_major(randr.extname)
    SetMonitor(display=server.display, opcode=opcode, window=root, **named, **place, **size, crtcs=outputs)
server.sync()
"""
"""A script that splits the desktop into two monitors side by side."""
LOOK = """
import sys
from tactometry.rigs.pages.layout import marker_page
from tactometry.rigs.window import Window
from Xlib import X, display

window = Window(fullscreen=False, size=(400, 320), screen=int(sys.argv[1]))
for _ in range(5):
    window.present(marker_page(None, playing=False))
root = display.Display().screen().root
for x, width in ((0, 640), (640, 800)):
    data = root.get_image(x, 0, width, 600, X.ZPixmap, 0xFFFFFF).data
    print(x, any(data))
print("; ".join(map(str, window.screens())))
window.close()
"""


@pytest.fixture(scope="module")
def two_screens(tmp_path_factory):
    if find_spec("psychopy") is None or shutil.which("Xvfb") is None:
        pytest.skip("no psychopy or no Xvfb")
    read_end, write_end = os.pipe()
    command = ["Xvfb", "-displayfd", str(write_end), "-screen", "0", "1440x600x24", "-noreset", "-nolisten", "tcp"]
    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    server = subprocess.Popen(command, pass_fds=[write_end], **silent)
    os.close(write_end)
    with os.fdopen(read_end) as answer:
        number = answer.readline().strip()
    python("-c", HALVES, f":{number}", check=True)
    home = tmp_path_factory.mktemp("home")
    yield {**os.environ, "DISPLAY": f":{number}", "HOME": str(home)}
    server.terminate()
    server.wait()


@pytest.mark.parametrize("number", [pytest.param(0, marks=pytest.mark.slow), 1])
def test_pages_appear_only_on_the_selected_screen(two_screens, number):
    done = python("-c", LOOK, number, env=two_screens)
    assert done.stdout.splitlines() == [
        f"0 {number == 0}",
        f"640 {number == 1}",
        "screen 0: 640 x 600 px; screen 1: 800 x 600 px",
    ], done.stderr


def test_unconnected_screen_is_refused_before_recording(two_screens, tmp_path):
    bench = tmp_path / "bench.toml"
    bench.write_text(BENCH.format(2))
    words = ("run", "tutorial", "--participant", "P01", "--bench", bench, "--out", tmp_path / "d")
    done = python("-m", "tactometry", *words, env=two_screens)
    assert done.returncode == 2
    assert done.stderr == (
        "tactometry: [screen] screen: found 2, expected a connected screen (screen 0: 640 x 600 px, "
        "screen 1: 800 x 600 px)\n"
    )
    assert not list(tmp_path.glob("d/data/*.csv")) or next(tmp_path.glob("d/data/*.csv")).read_text().count("\n") == 1


@pytest.mark.slow
def test_check_lists_screens_and_marks_participant_screen(two_screens, tmp_path):
    bench = tmp_path / "bench.toml"
    bench.write_text(BENCH.format(1))
    done = python("-m", "tactometry", "check", "--bench", bench, env=two_screens)
    assert "screen 0: 640 x 600 px; screen 1: 800 x 600 px; the participant uses screen 1" in done.stdout, done.stderr


def test_check_screen_rejects_unconnected_screens():
    there = (ConnectedScreen(0, 640, 480),)
    check_screen(0, there)
    for number in (-1, 1):
        with pytest.raises(InvalidParameter, match=r"expected a connected screen \(screen 0: 640 x 480 px\)"):
            check_screen(number, there)
