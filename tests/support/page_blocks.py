"""The code blocks of a page of the docs, each with what the page's source says of it in a comment before it.

`<!-- not run: WHY -->`, `<!-- file: NAME -->` (it is written there, for the blocks below), `<!-- of: FILE -->` (its
lines are lines of that file), and before TOML what reads it: `<!-- bench -->`, `<!-- study -->` (a whole one),
`<!-- study: tutorial -->` (put over that study), `<!-- keys: touch.slide -->` (a table of keys) and the other names of
`page_runner.READERS`. `<!-- before: COMMAND -->` runs a command that the page does not show; `<!-- with: PROGRAM -->`
runs the block where that program is installed.
"""

import re
from dataclasses import dataclass
from pathlib import Path

from markdown_it import MarkdownIt
from places import DOCS

MARK = re.compile(r"<!-- ([a-z ]+)(?:: (.+?))? -->\s*", re.DOTALL)


@dataclass(frozen=True)
class Block:
    """A fence, or an indented block, whose language is ``None``."""

    page: Path
    line: int
    language: str | None
    text: str
    mark: str = ""
    said: str = ""

    @property
    def place(self) -> str:
        return f"{self.page.name}:{self.line}"


def blocks_of(page: Path) -> list[Block]:
    """Return the blocks of a page; site directives in braces are skipped."""
    found, mark, said = [], "", ""
    for token in MarkdownIt("commonmark").parse(page.read_text(encoding="utf-8")):
        comment = MARK.fullmatch(token.content) if token.type == "html_block" else None
        if comment and comment[1] == "before":
            found.append(Block(page, token.map[0] + 1, "console", f"$ {comment[2]}\n"))
        elif comment:
            mark, said = comment[1], comment[2] or ""
        elif token.type in {"fence", "code_block"}:
            language = token.info.strip() if token.type == "fence" else None
            found.append(Block(page, token.map[0] + 1, language, token.content, mark, said))
            mark, said = "", ""
    return [block for block in found if not (block.language or "").startswith("{")]


def texts_of(page: str, language: str) -> list[str]:
    return [block.text for block in blocks_of(DOCS / page) if block.language == language]
