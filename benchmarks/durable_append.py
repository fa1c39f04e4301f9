"""Time the durable writing of a trial, compared with a plain fsync.

The optional argument is a folder on the disk to measure.
"""

import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tactometry.experiments.harness import tell
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import load
from tactometry.records.data_set import Session
from tactometry.records.open_session import OpenSession
from tactometry.session.answer import Done
from tactometry.session.request import Record
from tactometry.trials.trial import Trial

N_TRIALS = 2000
SPEEDS = {"speed_target_m_per_s": 0.05, "speed_mean_m_per_s": 0.05}


def trial(n: int) -> Trial:
    judged = "staircase", 20.0, "dB re 1 V", "yes_no", 1, True
    return Trial(1, n, {"frequency_hz": 240.0}, *judged, float(n), 0.5, 1.0, 0.01, 1.0, level_delivered=20.0, **SPEEDS)


def timed_ms(action: Callable[[int], object], n: int = N_TRIALS) -> np.ndarray:
    times_s = []
    for k in range(n):
        began_s = time.perf_counter()
        action(k)
        times_s.append(time.perf_counter() - began_s)
    return 1e3 * np.array(times_s)


def recorded_ms(folder: Path) -> np.ndarray:
    study, toml = load("tutorial")
    design, who = wire(study, "tutorial").design(toml), Session("P01", 1, study.name)
    session = OpenSession(folder, design, who, "console", resume=False)
    times_ms = timed_ms(lambda n: session.append(Record(trial(n + 1)), Done(float(n))))
    session.close()
    return times_ms


def synced_ms(folder: Path) -> np.ndarray:
    file = os.open(folder / "plain", os.O_WRONLY | os.O_CREAT)
    return timed_ms(lambda n: (os.write(file, b"x" * 600 + b"%d\n" % n), os.fsync(file)))


def main() -> None:
    folder = Path(tempfile.mkdtemp(dir=sys.argv[1] if len(sys.argv) > 1 else "."))
    ours_ms, alone_ms = recorded_ms(folder / "d"), synced_ms(folder)
    tell("a recorded trial, 99th percentile by the clock", np.percentile(ours_ms, 99), "ms", at_most=1)
    tell("a recorded trial over the fsync alone, medians", np.median(ours_ms) / np.median(alone_ms))


if __name__ == "__main__":
    main()
