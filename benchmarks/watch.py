"""Time a page that follows a session of three hours: `python benchmarks/watch.py`.

A journal of more than 2 000 trials is written, with events and traces of a bench. Its last trials are written one by
one at the pace of a session (5 s), while the page is served to a browser's connection. `--n-live` and `--pace-s` change
the number and pace of these trials. Shares of a core are for one trial in 5 s.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from http.client import HTTPConnection
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np

from tactometry.experiments.harness import tell
from tactometry.experiments.sessions.recording import Who, record, simulated
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import load, parse
from tactometry.files.durable import make_folder
from tactometry.records.data_set import Session, sessions
from tactometry.records.journal import Entry, Line, read
from tactometry.records.open_journal import Journal
from tactometry.records.traces import TraceFiles
from tactometry.session.answer import Touched
from tactometry.session.event import Event
from tactometry.session.request import Record

TRIAL_S, BEGAN = 5.0, "2026-01-01T00:00:00.000+00:00"
FACTS = {"n_frames": 300, "n_dropped_frames": 0}
FACTS_S = {"frame_interval_max_s": 0.017, "gate_delay_s": 0.004, "key_to_record_s": 0.012}


def long_session(root: Path, n_trials: int) -> tuple[Line, ...]:
    """Simulate the staircase study with a number of trials per track."""
    text = load("electrovibration-threshold")[1].decode()
    content = text.replace("n_trials = 40", f"n_trials = {n_trials}").replace("n_reversals = 14", "n_reversals = 999")
    experiment, who = wire(parse(content.encode(), "the study"), "the study"), Who("P01", seed=1)
    record(experiment, content.encode(), root, who, simulated(experiment, who))
    return read(sessions(root)[0]).lines


def traced(answer: object, traces: TraceFiles) -> object:
    """Return the answer of a touch, with samples of three seconds."""
    if not isinstance(answer, Touched):
        return answer
    times_s = answer.onset_s + np.linspace(-2.0, 1.0, 3000)
    force, place = (np.column_stack([times_s, size + size * np.sin(times_s)]) for size in (1.0, 0.05))
    return replace(answer, trace=(traces.keep("force", force, 1000.0), traces.keep("position", place, 1000.0)))


def write(journal: Journal, lines: Sequence[Line], traces: TraceFiles) -> Iterator[None]:
    """Write lines with the events of a bench, and yield after each trial."""
    for line in lines:
        if isinstance(line, Entry):
            journal.append(line.request, traced(line.answer, traces))
            if isinstance(line.request, Record):
                trial, at_s = line.request.trial, line.answer.at_s
                facts = {"block": trial.block, "trial": trial.trial, **FACTS, **FACTS_S}
                journal.note(Event("trial", at_s, BEGAN, facts))
                journal.note(Event("stimulus", at_s, BEGAN, {"charge_c": 1e-7}, 1.0))
                yield


def cpu_s(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def listen(url: str, seen: list[int]) -> None:
    """Request the page and then its changes, like a browser."""
    parts = urlsplit(url)
    connection = HTTPConnection(str(parts.hostname), parts.port)
    connection.request("GET", parts.path)
    connection.getresponse().read()
    connection.request("GET", f"{parts.path}events")
    answer = connection.getresponse()
    while line := answer.readline():
        seen.append(len(line))


@contextmanager
def served(root: Path) -> Iterator[tuple[int, str]]:
    """Run `tactometry watch`, and yield its process number and address."""
    command = [sys.executable, "-m", "tactometry", "watch", str(root)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True) as watch:
        try:
            assert watch.stdout is not None
            yield watch.pid, watch.stdout.readline().strip()
        finally:
            watch.terminate()


def measure(root: Path, journal: Journal, live: Sequence[Line], traces: TraceFiles, pace_s: float) -> None:
    seen: list[int] = []
    with served(root) as (pid, url):
        threading.Thread(target=listen, args=(url, seen), daemon=True).start()
        while not seen:
            time.sleep(0.1)
        time.sleep(3.0)
        before_s = cpu_s(pid)
        n_trials = sum(time.sleep(pace_s) or 1 for _ in write(journal, live, traces))
        share = (cpu_s(pid) - before_s) / n_trials / TRIAL_S
    tell("start and the whole journal of three hours, once", before_s, "s")
    tell("of a core, a page open and a trial in 5 s", 100 * share, "%", at_most=2)
    with served(root) as (pid, _):
        time.sleep(2.0)
        before_s = cpu_s(pid)
        time.sleep(10.0)
        tell("of a core, without a page open", 100 * (cpu_s(pid) - before_s) / 10.0, "%")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--n-trials", type=int, default=82, help="of each of 21 tracks")
    parser.add_argument("--n-live", type=int, default=24)
    parser.add_argument("--pace-s", type=float, default=TRIAL_S)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        whole, root = Path(folder) / "simulated", Path(folder) / "watched"
        lines = long_session(whole, arguments.n_trials)
        records = [n for n, line in enumerate(lines) if isinstance(line, Entry) and isinstance(line.request, Record)]
        begin = records[-arguments.n_live - 1] + 1
        make_folder(root / "journals")
        (root / "study.toml").write_bytes((whole / "study.toml").read_bytes())
        journal = Journal(root / "journals" / sessions(whole)[0].name, resume=False, syncs_trials=False)
        journal.begin(lines[0])  # type: ignore[arg-type]
        traces = TraceFiles(root, Session("P01", 1, "electrovibration-threshold"))
        list(write(journal, lines[1:begin], traces))
        measure(root, journal, lines[begin:], traces, arguments.pace_s)
        traces.close()
        journal.close()


if __name__ == "__main__":
    main()
