"""The page is served only to this computer, at a secret address."""

import re
import socket

import pytest
from places import ROOT
from watched import watched

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
    ("headers", "status"),
    [
        ({"Host": "evil.example"}, 403),
        ({"Host": "127.0.0.1"}, 403),
        ({"Origin": "http://evil.example"}, 403),
        ({"Origin": "null"}, 403),
        ({"Sec_Fetch_Site": "cross-site"}, 403),
        ({"Sec_Fetch_Site": "same-site"}, 403),
        ({"Sec_Fetch_Site": "none"}, 200),
    ],
)
def test_foreign_hosts_and_pages_are_refused(served, headers, status):
    for path in ("", "events", "page.js"):
        if status == 200 and path == "events":
            continue  # it has no end
        assert served.ask(path, **headers)[0] == status


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("Sec-Fetch-Site", ("cross-site", "same-origin")),
        ("Sec-Fetch-Site", ("none", "none")),
        ("Origin", ("http://evil.example", "http://127.0.0.1:{port}")),
        ("Origin", ("http://127.0.0.1:{port}", "http://127.0.0.1:{port}")),
        ("Host", ("evil.example", "127.0.0.1:{port}")),
        ("Host", ("127.0.0.1:{port}", "127.0.0.1:{port}")),
    ],
)
def test_repeated_headers_are_refused(served, name, values):
    connection = served.connection()
    connection.putrequest("GET", f"/{served.token}/", skip_host=name == "Host")
    for value in values:
        connection.putheader(name, value.format(port=served.port))
    connection.endheaders()
    assert connection.getresponse().status == (400 if name == "Host" else 403)  # a second host is no HTTP
    connection.close()


def test_server_refuses_requests_without_token(served):
    for path in (
        "/",
        "/events",
        "/page.js",
        f"/{served.token[:-1]}/",
        f"/{served.token}x/",
        "//",
        f"/x/{served.token}/",
    ):
        status, text = served.ask(whole_path=path)
        assert (status, text) == (404, "")


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
