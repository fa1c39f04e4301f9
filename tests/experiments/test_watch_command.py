"""Start and end of the `watch` command and of the page of `run`."""

import json
import os
import signal
import subprocess
import sys
import time
from urllib.request import urlopen

import pytest
from patience import LONGEST_WAIT_S

from tactometry.cli import main
from tactometry.cli.watch import watching

pytest.importorskip("starlette")
pytest.importorskip("uvicorn")


def test_ctrl_c_ends_it_without_a_word(journal):
    journal.holds()
    command = [sys.executable, "-m", "tactometry", "watch", str(journal.root)]
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as watch:
        assert watch.stdout.readline().startswith(b"http://127.0.0.1:")
        os.kill(watch.pid, signal.SIGINT)
        assert watch.wait(LONGEST_WAIT_S) == 0
        assert watch.stderr.read() == b""


def test_watch_prints_address_as_json(journal):
    journal.holds()
    command = [sys.executable, "-m", "tactometry", "watch", str(journal.root), "--json", "--until-input-ends"]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=LONGEST_WAIT_S, check=True)
    assert json.loads(done.stdout)["url"].startswith("http://127.0.0.1:")


HOLDER = """
import sys, time
from pathlib import Path
from tactometry.cli.watch import watching
with watching(Path(sys.argv[1]), "P01", 1) as url:
    print(url, flush=True)
    time.sleep(600)
"""


def is_served(url):
    try:
        with urlopen(url, timeout=LONGEST_WAIT_S) as page:
            return page.status == 200
    except OSError:
        return False


def test_page_starts_before_the_data_and_ends(tmp_path):
    with watching(tmp_path / "yet-to-come", "P01", 1) as url:
        assert is_served(url)
    assert not is_served(url)


def test_page_ends_when_run_is_killed(tmp_path):
    with subprocess.Popen([sys.executable, "-c", HOLDER, str(tmp_path)], stdout=subprocess.PIPE, text=True) as run:
        url = run.stdout.readline().strip()
        assert is_served(url)
        run.kill()
    end_s = time.monotonic() + LONGEST_WAIT_S
    while is_served(url):
        assert time.monotonic() < end_s
        time.sleep(0.05)


@pytest.mark.slow
def test_run_tells_the_address_of_its_page(tmp_path, capfd):
    words = ["run", "tutorial", "--participant", "P01", "--rig", "simulated", "--out", str(tmp_path / "d"), "--watch"]
    with pytest.raises(SystemExit) as end:
        main(words)
    assert end.value.code == 0
    assert "watch the session at http://127.0.0.1:" in capfd.readouterr().err


def test_missing_folder_is_reported_in_one_sentence(tmp_path, capfd):
    with pytest.raises(SystemExit) as end:
        main(["watch", str(tmp_path / "nowhere")])
    assert end.value.code == 2
    assert "nowhere: found no folder, expected a data set, or --wait" in capfd.readouterr().err


def test_watch_reports_folder_without_session(tmp_path, capfd):
    with pytest.raises(SystemExit) as ended:
        main(["watch", str(tmp_path)])
    assert ended.value.code == 2
    assert "found no journal of this session, expected a session that has begun, or --wait" in capfd.readouterr().err
