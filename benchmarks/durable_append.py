"""What it costs that a trial is on the disk before the next request is put, beside PsychoPy's way of saving.

Run: python benchmarks/durable_append.py [FOLDER]. Prints, over 2 000 trials in one run, the time of a recorded trial
(journal line, its check, fsync, row of the trials file), of the fsync alone, and of an `ExperimentHandler` row that is
kept in memory and of one that is saved after every trial.
"""

import os
import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np
from measured import tell

from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import load
from tactometry.records.data_set import Session
from tactometry.records.open_session import OpenSession
from tactometry.session.answer import Done
from tactometry.session.request import Record
from tactometry.trials.trial import Trial

N_TRIALS = 2000


def trial(n: int) -> Trial:
    return Trial(
        1,
        n,
        {"frequency_hz": 240.0},
        "staircase",
        20.0,
        "dB re 1 V",
        "yes_no",
        1,
        True,
        float(n),
        0.5,
        1.0,
        0.01,
        1.0,
        speed_target_m_per_s=0.05,
        speed_mean_m_per_s=0.05,
        catch=False,
        level_delivered=20.0,
    )


def timed(action, n: int) -> np.ndarray:
    times_s = []
    for k in range(n):
        began_s = time.perf_counter()
        action(k)
        times_s.append(time.perf_counter() - began_s)
    return np.array(times_s)


def recorded(folder: Path) -> np.ndarray:
    study, toml = load("tutorial")
    session = OpenSession(
        folder, wire(study, "tutorial").design(toml), Session("P01", 1, study.name), "console", resume=False
    )
    times_s = timed(lambda n: session.append(Record(trial(n + 1)), Done(float(n))), N_TRIALS)
    session.close()
    return times_s


def synced(folder: Path) -> np.ndarray:
    file = os.open(folder / "plain", os.O_WRONLY | os.O_CREAT)

    def append(n: int) -> None:
        os.write(file, b"x" * 600 + b"%d\n" % n)
        os.fsync(file)

    return timed(append, N_TRIALS)


def psychopy(folder: Path, *, save: bool, n: int) -> np.ndarray:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from psychopy import logging
        from psychopy.data import ExperimentHandler
    logging.console.setLevel(logging.CRITICAL)
    handler = ExperimentHandler(dataFileName=str(folder / "peer"), savePickle=False, saveWideText=False)

    def entry(k: int) -> None:
        for name, value in (("level", 20.0), ("response", 1), ("rt", 0.5), ("trial", k)):
            handler.addData(name, value)
        handler.nextEntry()
        if save:
            handler.saveAsWideText(str(folder / "peer.csv"), fileCollisionMethod="overwrite")

    return timed(entry, n)


def report(name: str, times_s: np.ndarray, keeps: str) -> None:
    p50, p99 = np.percentile(1e3 * times_s, [50, 99])
    print(f"{name:<44} {p50:>9.3f} {p99:>9.3f} {1e3 * times_s.max():>9.2f}   {keeps}")


def main() -> None:
    folder = Path(tempfile.mkdtemp(dir=sys.argv[1] if len(sys.argv) > 1 else "."))
    print(f"{'ms per trial':<44} {'p50':>9} {'p99':>9} {'max':>9}   kept after SIGKILL")
    ours_s, alone_s = recorded(folder / "d"), synced(folder)
    report("tactometry: a recorded trial", ours_s, "every trial")
    report("write and fsync alone", alone_s, "every trial")
    tell("a recorded trial, 99th percentile by the clock", 1e3 * np.percentile(ours_s, 99), "ms", at_most=1)
    tell("a recorded trial over the fsync alone, medians", np.median(ours_s) / np.median(alone_s))
    report("PsychoPy ExperimentHandler", psychopy(folder, save=False, n=N_TRIALS), "none")
    report("PsychoPy, saved after every trial (500)", psychopy(folder, save=True, n=500), "all but one, not atomic")


if __name__ == "__main__":
    main()
