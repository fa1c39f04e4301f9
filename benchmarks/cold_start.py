"""Whole processes of built-in scenes from a cold start, in pairs with a bare import of numpy; and warm, in one process.

Interleaved, one warm-up each, medians. *cold* is `tactometry scene NAME` as a program: wall-clock time, and user plus
system time (on a busy machine the better figure). *first* and *second* are processor times of two computations in one
process, with what is imported for them. The limits are wall-clock times on a quiet machine.
"""

import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

from measured import ratios, tell

RUNS = 5
LIMITS_S = {"electrovibration-panel": 1.0, "a4-screen": 1.5}
NUMPY = [sys.executable, "-c", "import numpy"]
TWICE = """
import json, sys, time
from tactometry.experiments.scenes import path_of
from tactometry.stimuli.scenes.file import load_scene
def once():
    start_s = time.process_time()
    found = load_scene(path_of(sys.argv[1]))
    plan = found.scene.resolve()
    plan.run({name: found.given[name] for name in plan.given})
    return time.process_time() - start_s
print(json.dumps([once(), once()]))
"""


def whole(command: list[str]) -> tuple[float, float]:
    """Wall-clock and processor time (s) of a child that must succeed."""
    start_s = time.perf_counter()
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        raise SystemExit(f"{' '.join(command)}: exit status {child.returncode}")
    return time.perf_counter() - start_s, usage.ru_utime + usage.ru_stime


def twice(name: str) -> tuple[float, float]:
    """Processor times (s) of a first and a second computation in one process."""
    said = subprocess.run([sys.executable, "-c", TWICE, name], capture_output=True, text=True, check=True).stdout
    first_s, second_s = json.loads(said)
    return first_s, second_s


def main() -> None:
    program = str(Path(sys.executable).with_name("tactometry"))
    print(f"Python {sys.version.split()[0]}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}, {RUNS} pairs each")
    for name, limit_s in LIMITS_S.items():
        scene = [program, "scene", name]
        whole(scene), whole(NUMPY)
        pairs = [(*whole(scene), *whole(NUMPY), *twice(name)) for _ in range(RUNS)]
        cold_s, cpu_s, bare_s, bare_cpu_s, first_s, second_s = map(statistics.median, zip(*pairs, strict=True))
        print(
            f"{name:24} cold {cold_s:.2f} s (limit {limit_s} s), processor {cpu_s:.2f} s; numpy alone {bare_s:.2f} s, "
            f"processor {bare_cpu_s:.2f} s; within a process first {first_s:.2f} s, second {second_s:.3f} s"
        )
        whole_s, _, numpy_s, *_ = (list(column) for column in zip(*pairs, strict=True))
        tell(f"{name} from a cold start, by the clock", whole_s, "s", at_most=limit_s)
        tell(f"{name} from a cold start over a bare import of numpy", ratios(whole_s, numpy_s))


if __name__ == "__main__":
    main()
