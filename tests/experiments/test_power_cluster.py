"""Power on a Dask scheduler with two workers, one of which is killed."""

import os
import re
import signal
import subprocess
import sys
import threading
import time

import pytest
from command_line import status

pytest.importorskip("distributed", reason="the extra 'cluster' is not installed")
pytestmark = pytest.mark.slow

ASKED = ("power", "tutorial", "--effect", "frequency_hz: 8 dB", "--participants", "3,4", "--seed", "5", "--most", "12")
ADDRESS = re.compile(rb"tcp://127\.0\.0\.1:\d+")
PATIENCE_S = 60


def files(root):
    return {str(path.relative_to(root)): path.read_bytes() for path in sorted(root.rglob("*")) if path.is_file()}


def started(place, name, *words):
    """Start a Dask process; return it with the file of its output."""
    log = place / f"{name}.log"
    command = [sys.executable, "-m", "distributed.cli." + words[0], *words[1:]]
    with log.open("wb") as said:
        return subprocess.Popen(command, stderr=said, stdout=subprocess.DEVNULL, cwd=place), log


def found_in(log, pattern, process):
    end_s = time.monotonic() + PATIENCE_S
    while time.monotonic() < end_s and process.poll() is None:
        if match := pattern.search(log.read_bytes()):
            return match[0].decode()
        time.sleep(0.1)
    raise AssertionError(log.read_text())


@pytest.fixture
def cluster(tmp_path):
    """Start a scheduler with two workers; yield its address and the workers."""
    place = tmp_path / "dask"
    place.mkdir()
    scheduler, log = started(
        place, "scheduler", "dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard"
    )
    workers = []
    try:
        address = found_in(log, ADDRESS, scheduler)
        for name in ("one", "two"):
            words = ("dask_worker", address, "--no-nanny", "--nthreads", "1", "--no-dashboard", "--name", name)
            worker, said = started(place, name, *words)
            workers.append(worker)
            found_in(said, re.compile(rb"Registered to"), worker)
        yield address, workers
    finally:
        for process in (*workers, scheduler):
            process.kill()
            process.wait()


def test_cluster_gives_same_bytes_when_a_worker_dies(tmp_path, cluster):
    address, workers = cluster
    out = tmp_path / "spread"

    def kill_one():
        while not list(out.glob("studies/*.parquet")):
            time.sleep(0.05)
        time.sleep(1.0)  # in the middle of the second batch
        os.kill(workers[0].pid, signal.SIGKILL)

    killer = threading.Thread(target=kill_one, daemon=True)
    killer.start()
    words = [sys.executable, "-m", "tactometry", *ASKED, "--out", out, "--scheduler", address]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    killer.join(PATIENCE_S)
    assert workers[0].poll() is not None
    assert status(*ASKED, "--out", tmp_path / "alone") == 0
    assert files(out) == files(tmp_path / "alone")
