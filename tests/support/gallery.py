"""The gallery of the docs, with the figures of its pages.

A section of a page is a heading, a picture `pictures/NAME.png`, and the code that writes a NAME.png. The first page of
the gallery shows all of them, and follows from the others. Pictures of pages need a browser: without it they stay.
"""

import os
import re
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from page_blocks import blocks_of
from page_runner import absent, run_page
from places import DOCS
from small_pictures import small

GALLERY = DOCS / "gallery"
PICTURES = GALLERY / "pictures"
PAGES = [GALLERY / f"{name}.md" for name in ("studies_to_copy", "sessions", "stimuli", "thesis")]
WIDTH_PIXELS = 900
SECTION = re.compile(r"^## (.+)\n\n!\[(.+)\]\(pictures/(.+)\.png\)$", re.MULTILINE)
HEAD = """# Gallery

On these pages you find figures with the commands or Python code that draw them. `make gallery` draws all of them.
"""


@dataclass(frozen=True)
class Picture:
    """A picture in the gallery, with the heading of its section, its content and its name."""

    page: Path
    title: str
    shows: str
    name: str

    @property
    def card(self) -> str:
        heading = re.sub(r"[^\w -]", "", self.title.lower()).replace(" ", "-")
        link = f"{self.page.name}#{heading}"
        return f":::{{grid-item}}\n[![](pictures/{self.name}.png)]({link})\n\n[{self.title}]({link})\n:::\n"


def pictures_of(page: Path) -> list[Picture]:
    return [Picture(page, *found) for found in SECTION.findall(page.read_text(encoding="utf-8"))]


def first_page() -> str:
    contents = "\n".join(["```{toctree}", ":hidden:", "", *(page.stem for page in PAGES), "```", ""])
    return "\n".join([HEAD, contents, *map(_part, PAGES)])


def _part(page: Path) -> str:
    _, title = page.read_text(encoding="utf-8").split("# ", maxsplit=1)
    cards = "".join(picture.card for picture in pictures_of(page))
    return f"## {title.splitlines()[0]}\n\n::::{{grid}} 2 2 3 3\n:gutter: 3\n\n{cards}::::\n"


def draw(page: Path) -> None:
    """Run a page in a temporary folder and keep its figures."""
    not_run = "".join(block.text for block in blocks_of(page) if absent(block))
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        run_page(page)
        for picture in pictures_of(page):
            if f"{picture.name}.png" in not_run:
                print(f"{picture.name}.png: no browser, so that it stays as it was", file=sys.stderr)
                continue
            (drawn,) = Path(folder).rglob(f"{picture.name}.png")
            (PICTURES / drawn.name).write_bytes(small(drawn.read_bytes(), WIDTH_PIXELS))


def write() -> None:
    PICTURES.mkdir(exist_ok=True)
    for page in PAGES:
        draw(page)
    (GALLERY / "index.md").write_text(first_page(), encoding="utf-8")


if __name__ == "__main__":
    write()
