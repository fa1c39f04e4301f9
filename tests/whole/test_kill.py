"""Sessions killed at random moments: no completed trial is missing or doubled, and resumed they end as if never killed.

The children are forked from a server that has the program loaded, so that a moment costs the session and not its
imports. TACTOMETRY_SOAK=1 kills at 1 000 moments in all, `make test` at fewer.
"""

import json
import multiprocessing
import os
import re
import runpy
import signal
import threading
import time

import numpy as np
import pytest
from hard_cases import exact_case
from places import ROOT
from soak import SOAK

SCRIPT = str(ROOT / "tests" / "support" / "killed_session.py")
N_MOMENTS = {"simulate": 350 if SOAK else 12, "console": 150 if SOAK else 4}
SIGNALS = [signal.SIGKILL, signal.SIGTERM]
TIMES = re.compile(rb'"(at_s|onset_s|latency_s|timestamp_utc|started_utc|crc32)":("[^"]*"|[-0-9.e]+|null)')
SITTING = re.compile(rb'^{"sitting":.*\n', re.MULTILINE)
TIME_COLUMNS = ("onset_s", "latency_s", "timestamp_utc")


@pytest.fixture(scope="module")
def start():
    """Return a function that starts the command line in a new process."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(
        [
            "tactometry.experiments.sessions.simulation",
            "tactometry.cli.run",
            "tactometry.stimuli.scenes.default_scenes",
        ]
    )

    def started(arguments, terminal=None):
        process = context.Process(
            target=runpy.run_path, args=(SCRIPT,), kwargs={"init_globals": {"CALL": (arguments, terminal)}}
        )
        process.start()
        return process

    return started


def simulate(root, resume=False):
    words = ["simulate", "tutorial", "--participants", "3", "--seed", "7", "--out", str(root)]
    return words + ["--resume"] * resume


def console(root, resume=False):
    words = ["run", "tutorial", "--participant", "P01", "--rig", "console", "--seed", "7", "--out", str(root)]
    return words + ["--resume"] * resume


def files(root):
    """Return the files of a data set without the interruption records."""
    return {
        str(path.relative_to(root)): path.read_bytes()
        for path in sorted(root.rglob("*"))
        if path.is_file() and not path.name.startswith(".") and "_interruptions" not in path.name
    }


def timeless(content, name):
    """Return a file without time stamps and without session headers."""
    if name.endswith(".csv"):
        header, *rows = [line.split(",") for line in content.decode().splitlines()]
        keep = [n for n, column in enumerate(header) if column not in TIME_COLUMNS]
        return [[row[n] for n in keep] for row in (header, *rows)]
    return TIMES.sub(b"", SITTING.sub(b"", content)) if name.endswith(".jsonl") else content


def timeless_files(root):
    return {name: timeless(content, name) for name, content in files(root).items()}


def assert_no_trial_is_torn(root, whole):
    """Assert that a killed trials file is a beginning of the whole one.

    Its last line may be incomplete.
    """
    for path in (root / "data").glob("*.csv"):
        rows = path.read_bytes().split(b"\n")[:-1]
        assert timeless(b"\n".join(rows), path.name) == whole[f"data/{path.name}"][: len(rows)]


def kill_until_done(begin, duration_s, n_moments, number, rng, check):
    """Kill and resume at `n_moments` random moments.

    A process that ends by itself is followed by a new one.
    """
    n_killed, folder, resume = 0, 0, False
    while n_killed < n_moments:
        process = begin(folder, resume)
        process.join(float(rng.uniform(0, 1.1 * duration_s)))
        if process.exitcode is None:
            os.kill(process.pid, number)
            process.join()
            n_killed, resume = n_killed + 1, True
            check(folder)
        elif resume or process.exitcode == 0:
            assert process.exitcode == 0
            folder, resume = folder + 1, False
    process = begin(folder, resume)
    process.join()
    assert process.exitcode == 0
    return folder


@pytest.mark.parametrize("number", SIGNALS, ids=lambda number: number.name)
def test_simulate_survives_being_killed(start, tmp_path, number):
    rng = np.random.default_rng()
    for _ in range(2):
        began_s = time.perf_counter()
        process = start(simulate(tmp_path / f"whole{_}"))
        process.join()
        assert process.exitcode == 0
    duration_s = time.perf_counter() - began_s
    whole = timeless_files(tmp_path / "whole0")
    last = kill_until_done(
        lambda folder, resume: start(simulate(tmp_path / str(folder), resume)),
        duration_s,
        N_MOMENTS["simulate"],
        number,
        rng,
        lambda folder: assert_no_trial_is_torn(tmp_path / str(folder), whole),
    )
    for folder in range(last + 1):
        assert files(tmp_path / str(folder)) == files(tmp_path / "whole0")
    exact_case("a simulation killed at any moment", against="the same bytes after going on")


class Participant:
    """A participant on named pipes who answers each trial by its number."""

    def __init__(self, folder, start):
        self.pipes = tuple(str(folder / name) for name in ("source", "output"))
        for pipe in self.pipes:
            os.mkfifo(pipe)
        self._start = start

    def begin(self, arguments):
        process = self._start(arguments, self.pipes)
        threading.Thread(target=self._answer, daemon=True).start()
        return process

    def _answer(self):
        try:
            source, output = os.open(self.pipes[0], os.O_RDWR), os.open(self.pipes[1], os.O_RDONLY)
            self._talk(source, output)
        except OSError:
            pass
        finally:
            os.close(source)
            os.close(output)

    def _talk(self, source, output):
        heard = b""
        while part := os.read(output, 4096):
            heard += part
            asked = re.search(rb"\[trial (\d+)\] [^\n]*\(0 = no, 1 = yes\): $", heard)
            if asked:
                os.write(source, b"%d\n" % (int(asked[1]) * 7 % 3 == 1))
                heard = b""


@pytest.mark.parametrize("number", SIGNALS, ids=lambda number: number.name)
def test_a_console_session_survives_being_killed(start, tmp_path, number):
    rng = np.random.default_rng()
    n_pipes = iter(range(10**6))

    def begin(root, resume=False):
        folder = tmp_path / f"pipes{next(n_pipes)}"
        folder.mkdir()
        return Participant(folder, start).begin(console(root, resume))

    began_s = time.perf_counter()
    process = begin(tmp_path / "whole")
    process.join()
    duration_s = time.perf_counter() - began_s
    assert process.exitcode == 0
    whole = timeless_files(tmp_path / "whole")
    last = kill_until_done(
        lambda folder, resume: begin(tmp_path / str(folder), resume),
        duration_s,
        N_MOMENTS["console"],
        number,
        rng,
        lambda folder: assert_no_trial_is_torn(tmp_path / str(folder), whole),
    )
    for folder in range(last + 1):
        assert timeless_files(tmp_path / str(folder)) == whole


def test_cut_off_line_is_kept_in_a_file(start, tmp_path):
    process = start(simulate(tmp_path))
    process.join()
    journal = next((tmp_path / "journals").glob("*P02*.jsonl"))
    journal.write_bytes(journal.read_bytes()[:-300])
    process = start(simulate(tmp_path, resume=True))
    process.join()
    assert process.exitcode == 0
    kept = next((tmp_path / "journals").glob("*_interruptions.jsonl")).read_text().splitlines()
    assert json.loads(kept[0])["after_trials"] > 0
