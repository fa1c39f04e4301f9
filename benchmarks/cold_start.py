"""Time commands and built-in scenes from a cold start.

Runs of whole processes take turns with runs of a bare interpreter.

Times of commands are processor times of the child process. Times of scenes are wall-clock times and require a quiet
machine.
"""

import os
import subprocess
import sys
import time
from pathlib import Path

from tactometry.experiments.harness import ratios, tell

RUNS, SCENE_RUNS = 15, 5
PROGRAM = str(Path(sys.executable).with_name("tactometry"))
HELP, KEYS, PANDAS, BARE = "tactometry --help", "tactometry keys touch.slide", "python -c 'import pandas'", "bare"
IMPORTS = {
    "import tactometry.analysis": "import tactometry.analysis",
    "import of fit": "from tactometry.analysis.threshold import fit",
}
COMMANDS = {
    HELP: [PROGRAM, "--help"],
    KEYS: [PROGRAM, "keys", "touch.slide"],
    BARE: [sys.executable, "-c", "pass"],
    PANDAS: [sys.executable, "-c", "import pandas"],
    **{name: [sys.executable, "-c", code] for name, code in IMPORTS.items()},
}
SCENES_S = {"electrovibration-panel": 1.0, "a4-screen": 1.5}
NUMPY = [sys.executable, "-c", "import numpy"]


def child(command: list[str]) -> tuple[float, float]:
    """Run a child process, and return its wall-clock and processor time (s)."""
    start_s = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{' '.join(command)}: exit status {process.returncode}")
    return time.perf_counter() - start_s, usage.ru_utime + usage.ru_stime


def commands() -> None:
    rounds = [{name: child(command)[1] for name, command in COMMANDS.items()} for _ in range(RUNS + 1)][1:]
    times = {name: [each[name] for each in rounds] for name in COMMANDS}
    tell(HELP, times[HELP], "s", at_most=0.3)
    for name in IMPORTS:
        tell(name, times[name], "s", at_most=1.0)
        tell(f"{name} over that of pandas", ratios(times[name], times[PANDAS]))
    tell(KEYS, times[KEYS], "s", at_most=1.0)
    tell(f"{KEYS} over an import of pandas", ratios(times[KEYS], times[PANDAS]))
    tell(f"{HELP} over a bare interpreter", ratios(times[HELP], times[BARE]))


def scenes() -> None:
    for name, limit_s in SCENES_S.items():
        pairs = [(child([PROGRAM, "scene", name])[0], child(NUMPY)[0]) for _ in range(SCENE_RUNS + 1)][1:]
        scene_s, numpy_s = (list(column) for column in zip(*pairs, strict=True))
        tell(f"{name} from a cold start, by the clock", scene_s, "s", at_most=limit_s)
        tell(f"{name} from a cold start over a bare import of numpy", ratios(scene_s, numpy_s))


if __name__ == "__main__":
    commands()
    scenes()
