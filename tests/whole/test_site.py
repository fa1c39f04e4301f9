"""The docs site builds without warnings, dead links or remote files."""

import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
from patience import LONGEST_PROGRAM_S
from places import DOCS

# Not imported: with sphinx loaded, pyglet enters its documentation mode, and a window ends the process.
PACKAGES = ("sphinx", "myst_nb", "furo", "sphinx_design", "sphinx_copybutton")
ABSENT = [package for package in PACKAGES if find_spec(package) is None]
pytestmark = pytest.mark.skipif(bool(ABSENT), reason=f"not installed: {', '.join(ABSENT)} (extra docs)")

FLAWED = """# A page

[gone](gone.md), [no such part](index.md#no-such-part)

{py:func}`nope`, {class}`tactometry.stimuli.Nope`, {py:func}`tactometry.errors.count_of`

```{eval-rst}
.. autofunction:: tactometry.errors.count_of
```
"""


def built(docs: Path, out: Path, builder: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-n", "-b", builder, str(docs), str(out)]
    command += ["-t", "quick"] if builder == "dummy" else []  # docstrings are read where pages are written
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=LONGEST_PROGRAM_S)


@pytest.mark.slow
def test_site_builds_without_warnings_or_dead_links(tmp_path: Path) -> None:
    """Missing pictures, unlisted pages and missing headings fail too."""
    done = built(DOCS, tmp_path, "dummy")
    assert (done.returncode, done.stderr) == (0, "")


def site_of(page: str, docs: Path) -> Path:
    """Build a site of one page with the settings of the docs."""
    docs.mkdir()
    for part in ("conf.py", "_extensions", "_static"):
        (docs / part).symlink_to(DOCS / part)
    (docs / "index.md").write_text(page, encoding="utf-8")
    return docs


def test_dead_link_or_unknown_python_name_fails_the_site(tmp_path: Path) -> None:
    done = built(site_of(FLAWED, tmp_path / "docs"), tmp_path / "out", "html")
    assert done.returncode == 1
    assert re.findall(r"reference target not found: ([\w.]+) \[", done.stderr) == ["nope", "tactometry.stimuli.Nope"]
    assert "gone.md" in done.stderr
    assert "no-such-part" in done.stderr


@pytest.mark.slow
def test_no_page_loads_anything_from_a_network(tmp_path: Path) -> None:
    """Links may leave the site; scripts, styles, fonts and pictures may not."""
    assert built(DOCS, tmp_path, "html").returncode == 0
    pages = {path: path.read_text(encoding="utf-8") for path in tmp_path.rglob("*.html")}
    styles = [path.read_text(encoding="utf-8") for path in tmp_path.rglob("*.css")]
    loaded = [found for text in pages.values() for found in re.findall(r'<(?!a )\w[^>]*?(?:src|href)="(\w+:)?//', text)]
    assert len(pages) > 20
    assert loaded == []
    assert [found for text in styles for found in re.findall(r"url\(['\"]?https?:|@import[^;]*https?:", text)] == []
