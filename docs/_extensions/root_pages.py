"""CONTRIBUTING.md and others stand where a clone is looked at, beside `docs/`, and are pages of the site too."""

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
    """With links as they are in the folder of the site."""
    text = text.replace("](docs/", "](")
    for page, file in PAGES.items():
        text = text.replace(f"]({file}", f"]({page}.md")
    return text


def _of_the_site(text: str) -> str:
    """With links to files of the root turned to their pages."""
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
