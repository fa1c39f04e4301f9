"""The watch page in a real browser and for screen readers."""

import pytest
from chromium import PROGRAM, chromium
from watched import watched

pytest.importorskip("starlette")
pytest.importorskip("uvicorn")
pytestmark = pytest.mark.skipif(PROGRAM is None, reason="no Chromium is installed")


@pytest.fixture(scope="module")
def tab(tmp_path_factory):
    with chromium(tmp_path_factory.mktemp("browser")) as tab:
        yield tab


def test_page_follows_whole_session(tab, journal):
    with watched(journal.root) as page:
        tab.told.clear()
        tab.open(page.url)
        assert "no session yet" in tab.text("#title")
        journal.holds(40)
        tab.wait_for("document.querySelector('#title').innerText.includes('running')")
        n_marks = tab.value("document.querySelectorAll('#levels figure circle').length")
        journal.holds(60)
        tab.wait_for(f"document.querySelectorAll('#levels figure circle').length > {n_marks}")
        journal.holds(60, b'{"event":"remark"}\n')
        tab.wait_for("document.querySelector('#alerts').innerText.includes('line 61')")
        assert tab.value("document.querySelectorAll('#levels figure circle').length") > n_marks
        assert tab.complaints() == []
    # the server is gone: the page warns that it may be outdated
    tab.wait_for("document.querySelector('#lost').innerText.includes('No connection')")


def test_screen_reader_gets_page_contents(tab, journal):
    journal.holds()
    with watched(journal.root) as page:
        tab.open(page.url)
        named = tab.named()
    regions = [name for role, name in named if role == "region"]
    assert regions == [
        *("Where the session stands", "Levels", "Touches", "Psychometric curve", "The last touch"),
        *("Screen, output and sensors", "Conditions"),
    ]
    assert ("heading", "P01, session 1: tutorial") in named
    images = [name for role, name in named if role == "image"]
    assert len(images) == 2
    assert "presentations" in images[0]
    assert "threshold" in images[1]
    tables = {name for role, name in named if role == "table"}
    assert tables == {"Last touches, newest first", "Tracks that have begun, newest first"}
    assert [name for role, name in named if role == "progressbar"] == ["Trials of this part", "Trials of the session"]


@pytest.mark.parametrize(
    ("scheme", "width", "height"),
    [
        ("light", 1920, 1080),
        ("dark", 420, 800),
        pytest.param("dark", 1920, 1080, marks=pytest.mark.slow),
        pytest.param("light", 420, 800, marks=pytest.mark.slow),
    ],
)
def test_everything_has_room_and_can_be_read(tab, journal, scheme, width, height, tmp_path):
    journal.holds(60)
    with watched(journal.root) as page:
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
