"""What a page costs that follows a session of three hours: `python benchmarks/watch.py`.

A journal of more than 2 000 trials (one in 5 s) with the events and the traces of a bench (three seconds of force and
place of each touch, at 1 kHz) is written; its last trials one by one, at the pace of a session, while the page is
served and a browser's connection is open. Prints the processor time of the server's process until the whole journal is
seen, and from then on as a share of one core. `--n-live` and `--pace-s` choose fewer or faster trials at the end; the
share is that of one trial in 5 s.
"""

import argparse
import os
import platform
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from http.client import HTTPConnection
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
from measured import tell

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

TRIAL_S = 5.0


def long_session(root: Path, n_trials: int) -> tuple[Line, ...]:
    """The lines of a session of the staircase study whose tracks have so many trials each."""
    text = load("electrovibration-threshold")[1].decode()
    content = text.replace("n_trials = 40", f"n_trials = {n_trials}").replace("n_reversals = 14", "n_reversals = 999")
    experiment, who = wire(parse(content.encode(), "the study"), "the study"), Who("P01", seed=1)
    record(experiment, content.encode(), root, who, simulated(experiment, who))
    return read(sessions(root)[0]).lines


def traced(answer: object, traces: TraceFiles) -> object:
    """An answer with samples of a touch of three seconds."""
    if not isinstance(answer, Touched):
        return answer
    times_s = answer.onset_s + np.linspace(-2.0, 1.0, 3000)
    force, place = (np.column_stack([times_s, size + size * np.sin(times_s)]) for size in (1.0, 0.05))
    return replace(answer, trace=(traces.keep("force", force, 1000.0), traces.keep("position", place, 1000.0)))


def write(journal: Journal, lines: Sequence[Line], traces: TraceFiles) -> Iterator[None]:
    """Write lines as a bench does, with its events; yields behind each trial."""
    for line in lines:
        if isinstance(line, Entry):
            journal.append(line.request, traced(line.answer, traces))
            if isinstance(line.request, Record):
                trial, at_s = line.request.trial, line.answer.at_s
                facts = {"block": trial.block, "trial": trial.trial, "n_frames": 300, "n_dropped_frames": 0}
                times_s = {"frame_interval_max_s": 0.017, "gate_delay_s": 0.004, "key_to_record_s": 0.012}
                journal.note(Event("trial", at_s, "2026-01-01T00:00:00.000+00:00", {**facts, **times_s}))
                journal.note(Event("stimulus", at_s, "2026-01-01T00:00:00.000+00:00", {"charge_c": 1e-7}, 1.0))
                yield


def cpu_s(pid: int) -> float:
    """Processor time of a process so far."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def listen(url: str, seen: list[int]) -> None:
    """As a browser does: the page, then what changes."""
    parts = urlsplit(url)
    connection = HTTPConnection(str(parts.hostname), parts.port)
    connection.request("GET", parts.path)
    connection.getresponse().read()
    connection.request("GET", f"{parts.path}events")
    answer = connection.getresponse()
    while line := answer.readline():
        seen.append(len(line))


def measure(
    root: Path, journal: Journal, live: Sequence[Line], traces: TraceFiles, pace_s: float
) -> tuple[float, float, int]:
    """Processor time until all is seen, processor time of each live trial, and how many bytes were sent for it."""
    command = [sys.executable, "-m", "tactometry", "watch", str(root)]
    seen: list[int] = []
    with subprocess.Popen(command, stdout=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True) as watch:
        try:
            assert watch.stdout is not None
            threading.Thread(target=listen, args=(watch.stdout.readline().strip(), seen), daemon=True).start()
            while not seen:
                time.sleep(0.1)
            time.sleep(3.0)
            before_s, n_sent, n_trials = cpu_s(watch.pid), sum(seen), 0
            for _ in write(journal, live, traces):
                n_trials += 1
                time.sleep(pace_s)
            return before_s, (cpu_s(watch.pid) - before_s) / n_trials, (sum(seen) - n_sent) // n_trials
        finally:
            watch.terminate()


def idle_share(root: Path, lasting_s: float) -> float:
    """What it takes of a core with nobody who looks."""
    command = [sys.executable, "-m", "tactometry", "watch", str(root)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True) as watch:
        try:
            assert watch.stdout is not None
            watch.stdout.readline()
            time.sleep(2.0)
            before_s = cpu_s(watch.pid)
            time.sleep(lasting_s)
            return (cpu_s(watch.pid) - before_s) / lasting_s
        finally:
            watch.terminate()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--n-trials", type=int, default=82, help="of each of 21 tracks")
    parser.add_argument("--n-live", type=int, default=24)
    parser.add_argument("--pace-s", type=float, default=TRIAL_S)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        lines = long_session(Path(folder) / "simulated", asked.n_trials)
        asked_at = [n for n, line in enumerate(lines) if isinstance(line, Entry) and isinstance(line.request, Record)]
        begin = asked_at[-asked.n_live - 1] + 1
        root = Path(folder) / "watched"
        make_folder(root / "journals")
        (root / "study.toml").write_bytes((Path(folder) / "simulated" / "study.toml").read_bytes())
        path = root / "journals" / sessions(Path(folder) / "simulated")[0].name
        journal = Journal(path, resume=False, syncs_trials=False)
        journal.begin(lines[0])  # type: ignore[arg-type]
        traces = TraceFiles(root, Session("P01", 1, "electrovibration-threshold"))
        n_before = sum(1 for _ in write(journal, lines[1:begin], traces))
        whole_s, trial_s, n_bytes = measure(root, journal, lines[begin:], traces, asked.pace_s)
        share = trial_s / TRIAL_S
        print(
            f"Python {platform.python_version()}, {platform.machine()}; {n_before} trials, {path.stat().st_size} bytes"
        )
        tell("start and the whole journal of three hours, once", whole_s, "s")
        tell("of a core, a page open and a trial in 5 s", 100 * share, "%", at_most=2)
        print(
            f"each trial with a page open: {1e3 * trial_s:.1f} ms, {n_bytes} bytes sent: {100 * share:.2f} % of a core"
        )
        tell("of a core, without a page open", 100 * idle_share(root, 10.0), "%")
        traces.close()
        journal.close()


if __name__ == "__main__":
    main()
