"""The watch page: served only to this computer at a secret address, started and ended by its commands."""

import json
import os
import re
import signal
import socket
import subprocess
import sys
import time
from urllib.request import urlopen

import pytest
from command_line import call, refused
from patience import LONGEST_WAIT_S
from places import ROOT
from watched import watched

from tactometry.cli.watch import watching
from tactometry.errors import DeviceFailed
from tactometry.experiments.watch.scenery import Scenery
from tactometry.experiments.watch.server import serve
from tactometry.experiments.watch.watcher import Watcher

pytest.importorskip("starlette")
pytest.importorskip("uvicorn")


@pytest.fixture(scope="module")
def served(whole):
    with watched(whole) as page:
        yield page


def test_server_serves_page_and_files(served):
    assert served.ask()[0] == 200
    assert served.ask("page.css")[0] == served.ask("page.js")[0] == 200
    assert "P01, session 1" in served.ask()[1]


@pytest.mark.parametrize(
    ("name", "values", "status"),
    [
        ("Host", ("evil.example",), 403),
        ("Host", ("127.0.0.1",), 403),
        ("Host", ("evil.example", "127.0.0.1:{port}"), 400),  # a second host is no HTTP
        ("Host", ("127.0.0.1:{port}", "127.0.0.1:{port}"), 400),
        ("Origin", ("http://evil.example",), 403),
        ("Origin", ("null",), 403),
        ("Origin", ("http://evil.example", "http://127.0.0.1:{port}"), 403),
        ("Origin", ("http://127.0.0.1:{port}", "http://127.0.0.1:{port}"), 403),
        ("Sec-Fetch-Site", ("cross-site",), 403),
        ("Sec-Fetch-Site", ("same-site",), 403),
        ("Sec-Fetch-Site", ("none",), 200),
        ("Sec-Fetch-Site", ("cross-site", "same-origin"), 403),
        ("Sec-Fetch-Site", ("none", "none"), 403),
    ],
)
def test_foreign_or_repeated_headers_are_refused(served, name, values, status):
    for path in ("", "events", "page.js") if status != 200 else ("", "page.js"):  # events have no end
        connection = served.connection()
        connection.putrequest("GET", f"/{served.token}/{path}", skip_host=name == "Host")
        for value in values:
            connection.putheader(name, value.format(port=served.port))
        connection.endheaders()
        assert connection.getresponse().status == status
        connection.close()


def test_server_refuses_requests_without_token(served):
    token = served.token
    for path in ("/", "/events", "/page.js", f"/{token[:-1]}/", f"/{token}x/", "//", f"/x/{token}/"):
        assert served.ask(whole_path=path) == (404, "")


def test_server_serves_only_the_page(served):
    for path in ("../study.toml", "..%2fstudy.toml", "study.toml", "page.html", "page.js/..", "journals/"):
        assert served.ask(path)[0] == 404


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "PATCH", "OPTIONS"])
def test_server_refuses_other_methods(served, method):
    assert served.ask(method=method)[0] == 405


def test_only_the_loopback_is_listened_at(served):
    with socket.socket() as other:  # another address of this computer, as another computer would use
        assert other.connect_ex(("127.0.0.2", served.port)) != 0


def test_page_forbids_foreign_resources(served):
    connection = served.connection()
    connection.request("GET", f"/{served.token}/")
    headers = connection.getresponse().headers
    assert headers["Content-Security-Policy"].startswith("default-src 'none'")
    assert headers["Cache-Control"] == "no-store"
    assert headers["Referrer-Policy"] == "no-referrer"
    assert "server" not in headers
    connection.close()
    assert not re.search(r"https?:", served.ask()[1] + served.ask("page.css")[1] + served.ask("page.js")[1])


def test_two_pages_have_two_tokens(served, tmp_path):
    with watched(tmp_path) as other:
        assert other.token != served.token
        assert len(other.token) >= 32


def test_events_hold_changed_sections_only(journal):
    journal.holds(20)
    with watched(journal.root) as page, page.listening() as news:
        first = news()
        assert set(first) >= {"title", "where", "levels", "quality"}
        journal.holds(23)
        second = news()
        assert "where" in second
        assert "quality" not in second
        journal.holds()
        assert "over" in news()["title"]


def test_taken_port_is_reported_in_one_sentence(served):
    with pytest.raises(DeviceFailed, match=rf"--port: cannot listen at 127.0.0.1:{served.port}"):
        serve(Scenery(Watcher(ROOT)), served.port, print)


# --- the command


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
def test_run_prints_the_address_of_its_page(tmp_path, capsys):
    words = ("run", "tutorial", "--participant", "P01", "--rig", "simulated", "--out", tmp_path / "d", "--watch")
    code, said, _ = call(capsys, *words)
    assert code == 0
    assert "watch the session at http://127.0.0.1:" in said


def test_watch_refuses_folder_without_session(tmp_path, capsys):
    said = refused(capsys, "watch", tmp_path / "nowhere")
    assert "nowhere: found no folder, expected a data set, or --wait" in said
    said = refused(capsys, "watch", tmp_path)
    assert "found no journal of this session, expected a session that has begun, or --wait" in said
