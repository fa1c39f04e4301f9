"""Capacity and lifetime of a window's keyboard queue."""

import os
import subprocess
import sys

from patience import LONGEST_PROGRAM_S
from places import ROOT

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
    pipes = {"capture_output": True, "text": True, "timeout": LONGEST_PROGRAM_S}
    ran = subprocess.run([sys.executable, "-c", SCRIPT], env=environment, check=False, **pipes)
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.split("\n")[:3] == ["5200", "1", "1 ()"]
