"""The page in a real browser: what is seen, what a screen reader is told, and that it follows a session that runs."""

import os
import signal
import subprocess
import sys
import time
from urllib.request import urlopen

import pytest
from chromium import PROGRAM, chromium
from patience import LONGEST_WAIT_S
from tutorial_session import journal_of, live
from watched import watched

from tactometry.cli import main
from tactometry.cli.watch import watching

pytest.importorskip("starlette")
pytest.importorskip("uvicorn")
pytestmark = pytest.mark.skipif(PROGRAM is None, reason="no Chromium is installed")


@pytest.fixture(scope="module")
def tab(tmp_path_factory):
    with chromium(tmp_path_factory.mktemp("browser")) as tab:
        yield tab


@pytest.fixture(scope="module")
def content(tmp_path_factory):
    root = tmp_path_factory.mktemp("watched")
    live(root)
    return journal_of(root).read_bytes(), (root / "study.toml").read_bytes(), journal_of(root).name


@pytest.fixture
def path(content, tmp_path):
    (tmp_path / "journals").mkdir()
    (tmp_path / "study.toml").write_bytes(content[1])
    return tmp_path / "journals" / content[2]


def whole(content, n_lines):
    return b"".join(content[0].splitlines(keepends=True)[:n_lines])


def test_the_page_follows_a_session_from_before_its_start_to_its_end(tab, content, path):
    with watched(path.parents[1]) as page:
        tab.told.clear()
        tab.open(page.url)
        assert "no session yet" in tab.text("#title")
        path.write_bytes(whole(content, 40))
        tab.wait_for("document.querySelector('#title').innerText.includes('running')")
        n_marks = tab.value("document.querySelectorAll('#levels figure circle').length")
        path.write_bytes(whole(content, 60))
        tab.wait_for(f"document.querySelectorAll('#levels figure circle').length > {n_marks}")
        path.write_bytes(whole(content, 60) + b'{"event":"remark"}\n')
        tab.wait_for("document.querySelector('#alerts').innerText.includes('line 61')")
        assert tab.value("document.querySelectorAll('#levels figure circle').length") > n_marks
        assert tab.complaints() == []
    # the server is gone: what is shown says that it may be old
    tab.wait_for("document.querySelector('#lost').innerText.includes('No connection')")


def test_a_screen_reader_is_told_what_the_page_shows(tab, content, path):
    path.write_bytes(content[0])
    with watched(path.parents[1]) as page:
        tab.open(page.url)
        told = tab.named()
    regions = [name for role, name in told if role == "region"]
    assert regions == [
        *("Where the session stands", "Levels", "Touches", "Psychometric curve", "The last touch"),
        *("Screen, output and sensors", "Conditions"),
    ]
    assert ("heading", "P01, session 1: tutorial") in told
    images = [name for role, name in told if role == "image"]
    assert len(images) == 2
    assert "presentations" in images[0]
    assert "threshold" in images[1]
    assert {name for role, name in told if role == "table"} == {
        "The last touches, the newest first",
        "Every track that has begun, the newest first",
    }
    assert [name for role, name in told if role == "progressbar"] == ["Trials of this part", "Trials of the session"]


@pytest.mark.parametrize(
    ("scheme", "width", "height"),
    [
        ("light", 1920, 1080),
        ("dark", 420, 800),
        pytest.param("dark", 1920, 1080, marks=pytest.mark.slow),
        pytest.param("light", 420, 800, marks=pytest.mark.slow),
    ],
)
def test_everything_has_room_and_can_be_read(tab, content, path, scheme, width, height, tmp_path):
    path.write_bytes(whole(content, 60))
    with watched(path.parents[1]) as page:
        tab.look(scheme=scheme, width=width, height=height)
        tab.open(page.url)
        assert tab.value("document.documentElement.scrollWidth <= window.innerWidth")
        assert tab.value(OVERLAPS) == []
        assert tab.value(CONTRAST) >= 4.5
        tab.screenshot(tmp_path / "page.png")
    assert (tmp_path / "page.png").stat().st_size > 10_000


OVERLAPS = """(() => {
  const texts = [...document.querySelectorAll('figure text')].map(e => [e.textContent, e.getBoundingClientRect()]);
  const found = [];
  for (const [i, [a, p]] of texts.entries()) for (const [b, q] of texts.slice(i + 1))
    if (p.left < q.right && q.left < p.right && p.top < q.bottom && q.top < p.bottom) found.push([a, b]);
  return found;
})()"""
"""Texts of a plot that lie on each other."""
CONTRAST = """(() => {
  const light = c => { const v = c.match(/[\\d.]+/g).slice(0, 3).map(x => x / 255).map(
    x => x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);
    return 0.2126 * v[0] + 0.7152 * v[1] + 0.0722 * v[2]; };
  const ground = e => { while (getComputedStyle(e).backgroundColor === 'rgba(0, 0, 0, 0)') e = e.parentElement;
    return getComputedStyle(e).backgroundColor; };
  const ratio = (a, b) => (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
  return Math.min(...[...document.querySelectorAll('h1, h2, p, dt, dd, td, th, caption, li, figcaption')].map(
    e => ratio(light(getComputedStyle(e).color), light(ground(e)))));
})()"""
"""The least contrast of a text with what it stands on (WCAG 2.2, relative luminance)."""


def test_ctrl_c_ends_it_without_a_word(content, path):
    path.write_bytes(content[0])
    command = [sys.executable, "-m", "tactometry", "watch", str(path.parents[1])]
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as watch:
        assert watch.stdout.readline().startswith(b"http://127.0.0.1:")
        os.kill(watch.pid, signal.SIGINT)
        assert watch.wait(LONGEST_WAIT_S) == 0
        assert watch.stderr.read() == b""


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


def test_the_page_of_a_run_is_there_before_its_data_and_ends_with_it(tmp_path):
    with watching(tmp_path / "yet-to-come", "P01", 1) as url:
        assert is_served(url)
    assert not is_served(url)


def test_the_page_of_a_run_that_is_killed_ends_too(tmp_path):
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


def test_a_folder_that_is_none_is_one_sentence(tmp_path, capfd):
    with pytest.raises(SystemExit) as end:
        main(["watch", str(tmp_path / "nowhere")])
    assert end.value.code == 2
    assert "nowhere: found no folder, expected a data set, or --wait" in capfd.readouterr().err


def test_a_folder_without_a_session_is_told(tmp_path, capfd):
    with pytest.raises(SystemExit) as ended:
        main(["watch", str(tmp_path)])
    assert ended.value.code == 2
    assert "found no journal of such a session, expected a session that has begun, or --wait" in capfd.readouterr().err
