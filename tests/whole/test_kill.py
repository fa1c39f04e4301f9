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
from tables import contents

SCRIPT = str(ROOT / "tests" / "support" / "killed_session.py")


N_MOMENTS = {"simulate": 350 if SOAK else 12, "run": 150 if SOAK else 4}
SIGNALS = [signal.SIGKILL, signal.SIGTERM]
TIMES = re.compile(rb'"(at_s|onset_s|latency_s|timestamp_utc|started_utc|crc32)":("[^"]*"|[-0-9.e]+|null)')
SITTING = re.compile(rb'^{"sitting":.*\n', re.MULTILINE)
TIME_COLUMNS = ("onset_s", "latency_s", "timestamp_utc")


@pytest.fixture(scope="module")
def start():
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(
        ["tactometry.experiments.sessions.simulation", "tactometry.cli.run", "tactometry.stimuli.scenes.default_scenes"]
    )

    def started(arguments, terminal=None):
        given = {"init_globals": {"CALL": (arguments, terminal)}}
        process = context.Process(target=runpy.run_path, args=(SCRIPT,), kwargs=given)
        process.start()
        return process

    return started


SIMULATE = ["simulate", "tutorial", "--participants", "3", "--seed", "7", "--out"]
RUN = ["run", "tutorial", "--participant", "P01", "--rig", "console", "--seed", "7", "--out"]


def files(root):
    found = contents(root).items()
    return {path: content for path, content in found if "_interruptions" not in path.name and path.name[0] != "."}


def timeless(content, name):
    """Return a file without time stamps and without session headers."""
    if name.endswith(".csv"):
        header, *rows = [line.split(",") for line in content.decode().splitlines()]
        keep = [n for n, column in enumerate(header) if column not in TIME_COLUMNS]
        return [[row[n] for n in keep] for row in (header, *rows)]
    return TIMES.sub(b"", SITTING.sub(b"", content)) if name.endswith(".jsonl") else content


def timeless_files(root):
    return {path: timeless(content, path.name) for path, content in files(root).items()}


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
        text = b""
        while part := os.read(output, 4096):
            text += part
            question = re.search(rb"\[trial (\d+)\] [^\n]*\(0 = no, 1 = yes\): $", text)
            if question:
                os.write(source, b"%d\n" % (int(question[1]) * 7 % 3 == 1))
                text = b""


def check_rows(root, whole):
    """Check that a killed trials file, whose last line may be incomplete, is a beginning of the whole one."""
    for path in (root / "data").glob("*.csv"):
        rows = path.read_bytes().split(b"\n")[:-1]
        assert timeless(b"\n".join(rows), path.name) == whole[path.relative_to(root)][: len(rows)]


def kill_until_done(begin, folder, n_moments, number, rng):
    """Kill and resume sessions at `n_moments` random moments; return the folders of all data sets.

    A process that ends by itself is followed by a new one.
    """
    for name in ("warm-up", "whole"):
        began_s = time.perf_counter()
        process = begin(folder / name, False)
        process.join()
        assert process.exitcode == 0
    duration_s, whole = time.perf_counter() - began_s, timeless_files(folder / "whole")
    n_killed, roots, resume = 0, [folder / "0"], False
    while n_killed < n_moments:
        process = begin(roots[-1], resume)
        process.join(float(rng.uniform(0, 1.1 * duration_s)))
        if process.exitcode is None:
            os.kill(process.pid, number)
            process.join()
            n_killed, resume = n_killed + 1, True
            check_rows(roots[-1], whole)
        elif resume or process.exitcode == 0:
            assert process.exitcode == 0
            roots, resume = [*roots, folder / str(len(roots))], False
    process = begin(roots[-1], resume)
    process.join()
    assert process.exitcode == 0
    return roots


@pytest.mark.parametrize("number", SIGNALS, ids=lambda number: number.name)
@pytest.mark.parametrize("command", [SIMULATE, RUN], ids=lambda command: command[0])
def test_session_survives_being_killed(start, tmp_path, command, number):
    n_pipes = iter(range(10**6))

    def begin(root, resume):
        words = [*command, str(root), *["--resume"] * resume]
        if command is SIMULATE:
            return start(words)
        folder = tmp_path / f"pipes{next(n_pipes)}"
        folder.mkdir()
        return Participant(folder, start).begin(words)

    content_of = files if command is SIMULATE else timeless_files
    for root in kill_until_done(begin, tmp_path, N_MOMENTS[command[0]], number, np.random.default_rng()):
        assert content_of(root) == content_of(tmp_path / "whole")
    if command is SIMULATE:
        exact_case("a simulation killed at any moment", against="the same bytes after going on")


def test_cut_off_line_is_kept_in_a_file(start, tmp_path):
    process = start([*SIMULATE, str(tmp_path)])
    process.join()
    journal = next((tmp_path / "journals").glob("*P02*.jsonl"))
    journal.write_bytes(journal.read_bytes()[:-300])
    process = start([*SIMULATE, str(tmp_path), "--resume"])
    process.join()
    assert process.exitcode == 0
    kept = next((tmp_path / "journals").glob("*_interruptions.jsonl")).read_text().splitlines()
    assert json.loads(kept[0])["after_trials"] > 0
