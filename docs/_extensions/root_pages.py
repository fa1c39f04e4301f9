"""Include files of the repository's root, such as CONTRIBUTING.md, as pages of the site."""

from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

ROOT = Path(__file__).resolve().parents[2]
PAGES = {
    "contributing": "CONTRIBUTING.md",
    "changelog": "CHANGELOG.md",
    "benchmarks": "benchmarks/README.md",
    "security": "SECURITY.md",
}


def _of_the_root(text: str) -> str:
    """Return the text with links relative to the folder of the site."""
    text = text.replace("](docs/", "](")
    for page, file in PAGES.items():
        text = text.replace(f"]({file}", f"]({page}.md")
    return text


def _of_the_site(text: str) -> str:
    """Return the text with links to root files replaced by links to their pages."""
    for page, file in PAGES.items():
        text = text.replace(f"](../../{file}", f"](../{page}.md").replace(f"](../../../{file}", f"](../../{page}.md")
    return text


def read(app: Sphinx, page: str, source: list[str]) -> None:
    if page in PAGES:
        file = ROOT / PAGES[page]
        app.env.note_dependency(file)
        source[0] = _of_the_root(file.read_text(encoding="utf-8"))
    else:
        source[0] = _of_the_site(source[0])


def setup(app: Sphinx) -> dict[str, Any]:
    app.connect("source-read", read)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
